//! One number for each vertex of the file, and what a tile's triangles are in those numbers.
//!
//! Tiles check themselves when they are loaded, but not against each other nor against the directory's counts, which
//! headers are written from. Here that is made up for: what contradicts becomes an error, and never a broken output.

use super::error::Contradiction;
use super::options::ExportOptions;
use crate::geometry::{TriangleId, VertexIndex};
use crate::store::{Directory, ReadError, Tile, TileId, TileReader, VertexId};

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
    pub(super) fn number(&self, vertex: VertexId) -> Result<u64, Contradiction> {
        let tile = vertex.tile.0 as usize;
        match self.directory().tiles.get(tile) {
            Some(entry) if vertex.index.0 < entry.vertices => Ok(self.starts[tile] + u64::from(vertex.index.0)),
            Some(entry) => Err(Contradiction::NoSuchVertex {
                vertex,
                vertices: entry.vertices,
            }),
            None => Err(Contradiction::NoSuchTile {
                vertex,
                tiles: self.starts.len(),
            }),
        }
    }

    /// The error for a tile that contradicts others.
    pub(super) fn damaged(&self, tile: TileId, contradiction: Contradiction) -> ReadError {
        self.reader.damaged(tile, contradiction.to_string())
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
    pub(super) fn is_written(&self, tile: &Tile, triangle: TriangleId) -> bool {
        tile.owns(triangle) && !(self.leaves_out_holes() && tile.is_hole(triangle))
    }

    /// Whether the vertices have a z.
    pub(super) fn has_z(&self) -> bool {
        self.directory().metadata.has_z
    }

    /// The z of a vertex of a tile, if the file has any; an error if it is no number, or the tile differs from the directory.
    pub(super) fn z(&self, tile: &Tile, vertex: VertexIndex) -> Result<Option<f64>, Contradiction> {
        match tile.z(vertex) {
            Some(z) if !z.is_finite() => Err(Contradiction::InfiniteZ(vertex)),
            z if z.is_some() != self.has_z() => Err(Contradiction::HasZ),
            z => Ok(z),
        }
    }
}
