//! The numbers of the vertices over the whole file, and checks that tiles agree with each other.
//!
//! Tiles are checked when they are loaded, but not against each other and not against the counts of
//! the directory, from which headers are written. This module does these checks: a contradiction
//! becomes an error, never a broken output.

use super::error::Contradiction;
use super::options::ExportOptions;
use crate::geometry::TriangleId;
use crate::store::{PassReader, ReadError, Tile, TileId, VertexId};

/// The number of each tile's first vertex.
pub(super) struct Numbering {
    reader: PassReader,
    starts: Vec<u64>,
    options: ExportOptions,
}

impl Numbering {
    pub(super) fn new(reader: PassReader, options: ExportOptions) -> Self {
        let directory = reader.directory();
        let mut starts = vec![0; directory.tiles.len()];
        let mut next = 0;
        for id in directory.tile_ids() {
            starts[id.0 as usize] = next;
            next += u64::from(directory.tiles[id.0 as usize].vertices);
        }
        Self {
            starts,
            reader,
            options,
        }
    }

    pub(super) fn reader(&self) -> &PassReader {
        &self.reader
    }

    /// Returns the number of a tile's first vertex.
    pub(super) fn start(&self, tile: &Tile) -> u64 {
        self.starts[tile.id().0 as usize]
    }

    /// Returns the number of a vertex. Fails if the file has no such vertex.
    pub(super) fn number(&self, vertex: VertexId) -> Result<u64, Contradiction> {
        let tile = vertex.tile.0 as usize;
        match self.reader.directory().entry(vertex.tile) {
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

    /// Returns the error for a tile with a contradiction.
    pub(super) fn damaged(&self, tile: TileId, contradiction: Contradiction) -> ReadError {
        self.reader.damaged(tile, contradiction.to_string())
    }

    /// Returns whether there are triangles that are not written because they are in holes.
    pub(super) fn leaves_out_holes(&self) -> bool {
        !self.options.holes && self.reader.metadata().hole_triangles > 0
    }

    /// Returns the number of triangles that are written, according to the directory.
    pub(super) fn triangles(&self) -> u64 {
        let metadata = self.reader.metadata();
        match self.leaves_out_holes() {
            // A directory with more triangles in holes than triangles was refused at open.
            true => metadata.triangles - metadata.hole_triangles,
            false => metadata.triangles,
        }
    }

    /// Returns whether a triangle is written as part of this tile.
    pub(super) fn is_written(&self, tile: &Tile, triangle: TriangleId) -> bool {
        tile.owns(triangle) && !(self.leaves_out_holes() && tile.is_hole(triangle))
    }
}
