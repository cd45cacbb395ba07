//! Parts of tiles. A part is formatted at once, so that no text exceeds a mebibyte, however large
//! the tile is.

use std::ops::Range;
use std::sync::Arc;

use super::error::Contradiction;
use super::numbering::Numbering;
use crate::geometry::{TriangleId, VertexIndex};
use crate::store::{ReadError, TileInPass};

/// The number of vertices, triangles or edges in a part.
const PART: u32 = 2048;

/// The limit on the bytes of a formatted part: no vertex and no triangle takes more than 512 bytes
/// in any format.
pub(super) const CHUNK_BYTES: u64 = 512 * PART as u64;

/// The elements by which tiles are cut into parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CutBy {
    Vertices,
    Triangles,
    /// The constraint edges that belong to the tile.
    Edges,
}

/// Some of the vertices, triangles or edges of a tile.
pub(super) struct TilePart {
    pub(super) tile: Arc<TileInPass>,
    /// The indices of the elements in the tile.
    pub(super) range: Range<u32>,
    /// The number of triangles or edges to be written; 0 if the tile is cut by vertices.
    pub(super) triangles: u32,
    /// The number of triangles written before these, over all tiles.
    pub(super) written_before: u64,
    /// Whether this is the last part of its tile.
    pub(super) is_last: bool,
}

impl TilePart {
    /// Calls `take` with the corners, and the numbers of the corners, of each triangle that is
    /// written.
    pub(super) fn for_each_triangle(
        &self,
        numbering: &Numbering,
        mut take: impl FnMut([VertexIndex; 3], [u64; 3]) -> Result<(), Contradiction>,
    ) -> Result<(), Contradiction> {
        let Self { tile, range, .. } = self;
        let start = numbering.start(tile);
        let triangles = range.clone().map(TriangleId);
        for triangle in triangles.filter(|&triangle| numbering.is_written(tile, triangle)) {
            let corners = tile.corners(triangle);
            let mut numbers = corners.map(|corner| start + u64::from(corner.0));
            for (corner, number) in corners.into_iter().zip(&mut numbers) {
                if !tile.has_vertex(corner) {
                    *number = numbering.number(tile.vertex(corner).id)?;
                }
            }
            take(corners, numbers)?;
        }
        Ok(())
    }

    /// Returns the vertices, with their numbers over the whole file.
    pub(super) fn vertices(&self, numbering: &Numbering) -> impl Iterator<Item = (VertexIndex, u64)> + use<> {
        let start = numbering.start(&self.tile);
        let vertices = self.range.clone();
        vertices.map(move |vertex| (VertexIndex(vertex), start + u64::from(vertex)))
    }
}

impl Numbering {
    /// Cuts a tile into parts, at least one. Fails if the tile and the directory disagree on whether
    /// there is a z, or, if it is cut by triangles, on the number of triangles that it owns.
    pub(super) fn cut(&self, tile: &Arc<TileInPass>, cut: CutBy) -> Result<Vec<TilePart>, ReadError> {
        if tile.has_z() != self.reader().metadata().has_z {
            return Err(self.damaged(tile.id(), Contradiction::HasZ));
        }
        let count = match cut {
            CutBy::Vertices => tile.vertex_count(),
            CutBy::Triangles => tile.triangle_count(),
            CutBy::Edges => tile.owned_constraints().count() as u32,
        };
        let mut owned = 0;
        let mut parts = Vec::new();
        for start in (0..count.max(1)).step_by(PART as usize) {
            let range = start..count.min(start.saturating_add(PART));
            let mut triangles = match cut {
                CutBy::Edges => range.end - range.start,
                CutBy::Vertices | CutBy::Triangles => 0,
            };
            if cut == CutBy::Triangles {
                let core = tile.core_triangle_count().clamp(range.start, range.end);
                let of_part =
                    core - range.start + (core..range.end).filter(|&t| tile.owns(TriangleId(t))).count() as u32;
                owned += of_part;
                triangles = match self.leaves_out_holes() {
                    true => range.clone().filter(|&t| self.is_written(tile, TriangleId(t))).count() as u32,
                    false => of_part,
                };
            }
            parts.push(TilePart {
                tile: Arc::clone(tile),
                is_last: range.end == count,
                range,
                triangles,
                written_before: 0,
            });
        }
        let expected = self.reader().directory().tiles[tile.id().0 as usize].owned_triangles;
        if cut == CutBy::Triangles && owned != expected {
            let reason = format!("it owns {owned} triangles, but the directory says {expected}");
            return Err(self.reader().damaged(tile.id(), reason));
        }
        Ok(parts)
    }
}
