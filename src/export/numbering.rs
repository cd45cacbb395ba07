//! The numbers of the vertices over the whole file, and checks that tiles agree with each other.
//!
//! Tiles are checked when they are loaded, but not against each other and not against the counts of
//! the directory, from which headers are written. This module does these checks: a contradiction
//! becomes an error, never a broken output.

use super::error::Contradiction;
use super::options::ExportOptions;
use super::what::{CutBy, What};
use crate::geometry::{TriangleId, VertexIndex};
use crate::store::{PassReader, ReadError, Tile, TileEdge, TileId, VertexId};
use crate::terrain::{FileSurface, TileSurface};

/// The number of each tile's first vertex.
pub(super) struct Numbering {
    reader: PassReader,
    starts: Vec<u64>,
    options: ExportOptions,
    surface: FileSurface,
}

impl Numbering {
    pub(super) fn new(reader: PassReader, options: ExportOptions, surface: FileSurface) -> Self {
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
            surface,
        }
    }

    pub(super) fn reader(&self) -> &PassReader {
        &self.reader
    }

    /// Returns the triangles that count, before they are clipped.
    pub(super) fn surface(&self) -> &FileSurface {
        &self.surface
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
        !self.surface.has_holes() && self.reader.metadata().hole_triangles > 0
    }

    /// Returns what is exported in a format of features.
    pub(super) fn what(&self) -> What {
        let default = match self.reader.metadata().triangles {
            0 => What::Vertices,
            _ => What::Triangles,
        };
        self.options.what.unwrap_or(default)
    }

    /// Returns whether a mesh is written with its constraint edges, of which there are some.
    pub(super) fn has_edges(&self) -> bool {
        self.options.edges && self.reader.metadata().constraint_edges > 0
    }

    /// Returns the number of elements that are written, if the directory says it.
    pub(super) fn count(&self, by: CutBy) -> Option<u64> {
        let metadata = self.reader.metadata();
        let is_clipped = self.options.clip.is_some();
        match by {
            CutBy::Triangles if is_clipped || self.surface.is_limited() => None,
            // A directory with more triangles in holes than triangles was refused at open.
            CutBy::Triangles if self.leaves_out_holes() => Some(metadata.triangles - metadata.hole_triangles),
            CutBy::Triangles => Some(metadata.triangles),
            CutBy::Vertices => Some(metadata.vertices),
            CutBy::Points | CutBy::Edges if is_clipped => None,
            CutBy::Points => Some(metadata.vertices),
            CutBy::Edges => Some(metadata.constraint_edges),
        }
    }

    /// Returns whether all elements are written, so that their bounds are those of the file.
    pub(super) fn writes_all(&self, by: CutBy) -> bool {
        match by {
            CutBy::Triangles => self.count(by) == Some(self.reader.metadata().triangles),
            CutBy::Vertices => true,
            CutBy::Points => self.options.clip.is_none(),
            CutBy::Edges => false,
        }
    }

    /// Returns whether a triangle is written as part of this tile, of which the surface is known.
    pub(super) fn is_written(&self, tile: &Tile, surface: &TileSurface, triangle: TriangleId) -> bool {
        tile.owns(triangle)
            && surface.has(tile, triangle)
            && self
                .options
                .clip
                .as_ref()
                .is_none_or(|clip| clip.meets_triangle(tile.triangle_points(triangle)))
    }

    /// Returns whether a vertex of this tile is written as a point.
    pub(super) fn writes_point(&self, tile: &Tile, vertex: VertexIndex) -> bool {
        let clip = self.options.clip.as_ref();
        clip.is_none_or(|clip| clip.covers(tile.point(vertex)))
    }

    /// Returns whether a constraint edge of this tile is written.
    pub(super) fn writes_edge(&self, tile: &Tile, edge: TileEdge) -> bool {
        let clip = self.options.clip.as_ref();
        clip.is_none_or(|clip| clip.meets_edge(tile.ends(edge).map(|end| end.point)))
    }
}
