//! One number for each vertex of the file, and what a tile's triangles are in those numbers.
//!
//! Tiles check themselves when they are loaded, but not against each other nor against the directory's counts, which
//! headers are written from. Here that is made up for: what contradicts becomes an error, and never a broken output.

use super::ExportOptions;
use super::part::Part;
use crate::store::{Directory, Tile, TileReader, VertexId};

/// The number of each tile's first vertex.
pub(super) struct Numbering {
    reader: TileReader,
    starts: Vec<u64>,
    options: ExportOptions,
}

impl Numbering {
    pub(super) fn new(reader: &TileReader, options: ExportOptions) -> Self {
        let counts = reader.directory().tiles.iter().map(|tile| u64::from(tile.vertices));
        let starts = counts.scan(0, |sum, count| {
            let start = *sum;
            *sum += count;
            Some(start)
        });
        Self {
            starts: starts.collect(),
            reader: reader.clone(),
            options,
        }
    }

    pub(super) fn reader(&self) -> &TileReader {
        &self.reader
    }

    fn directory(&self) -> &Directory {
        self.reader.directory()
    }

    /// The number of a tile's first vertex.
    pub(super) fn start(&self, tile: &Tile) -> u64 {
        self.starts[tile.id().0 as usize]
    }

    /// The number of a vertex; an error if the file has no such vertex.
    pub(super) fn number(&self, vertex: VertexId) -> Result<u64, String> {
        let tile = vertex.tile.0 as usize;
        match self.directory().tiles.get(tile) {
            Some(entry) if vertex.index < entry.vertices => Ok(self.starts[tile] + u64::from(vertex.index)),
            Some(entry) => Err(format!(
                "it has a triangle with vertex {vertex}, but tile {tile} has {} vertices",
                entry.vertices
            )),
            None => Err(format!(
                "it has a triangle with vertex {vertex}, but the file has {} tiles",
                self.starts.len()
            )),
        }
    }

    /// Whether there are triangles that are not written because they are in holes.
    pub(super) fn leaves_out_holes(&self) -> bool {
        !self.options.holes && self.directory().metadata.hole_triangles > 0
    }

    /// How many triangles are written, by the directory.
    pub(super) fn triangles(&self) -> u64 {
        let metadata = &self.directory().metadata;
        match self.leaves_out_holes() {
            // The directory was refused if there are more in holes than in all.
            true => metadata.triangles - metadata.hole_triangles,
            false => metadata.triangles,
        }
    }

    /// Whether a triangle is written with this tile.
    pub(super) fn is_written(&self, tile: &Tile, triangle: u32) -> bool {
        tile.owns(triangle) && !(self.leaves_out_holes() && tile.is_hole(triangle))
    }

    /// Hands out the triangles of a part that are written: their corners, and their vertices' numbers.
    pub(super) fn for_each_triangle(
        &self,
        Part { tile, range, .. }: &Part,
        mut take: impl FnMut([u32; 3], [u64; 3]) -> Result<(), String>,
    ) -> Result<(), String> {
        let start = self.start(tile);
        for triangle in range.clone().filter(|&triangle| self.is_written(tile, triangle)) {
            let corners = tile.corners(triangle);
            let mut numbers = corners.map(|corner| start + u64::from(corner));
            for (corner, number) in corners.into_iter().zip(&mut numbers) {
                if corner >= tile.vertex_count() {
                    *number = self.number(tile.vertex(corner).id)?;
                }
            }
            take(corners, numbers)?;
        }
        Ok(())
    }

    /// The vertices of a part, and their numbers through the file.
    pub(super) fn vertices(&self, part: &Part) -> impl Iterator<Item = (u32, u64)> + use<> {
        let start = self.start(&part.tile);
        part.range
            .clone()
            .map(move |vertex| (vertex, start + u64::from(vertex)))
    }

    /// Whether the vertices have a z.
    pub(super) fn has_z(&self) -> bool {
        self.directory().metadata.has_z
    }

    /// The z of a vertex of a tile, if the file has any; an error if it is no number, or the tile differs from the directory.
    pub(super) fn z(&self, tile: &Tile, vertex: u32) -> Result<Option<f64>, String> {
        match tile.z(vertex) {
            Some(z) if !z.is_finite() => Err(format!("vertex {vertex} has no finite z")),
            z if z.is_some() != self.has_z() => Err("it and the directory disagree on whether there is a z".to_owned()),
            z => Ok(z),
        }
    }
}
