//! Tiles in parts: what is formatted at once, so that no text is larger than a mebibyte, however large the tile.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use super::error::Contradiction;
use super::numbering::Numbering;
use crate::geometry::{TriangleId, VertexIndex};
use crate::store::{ReadError, TileInPass, VertexId};

/// Vertices, triangles or edges of a part.
const PART: u32 = 2048;

/// Bytes of what is made of a part, at most: no vertex and no triangle has more than 512 in any format.
pub(super) const PIECE_BYTES: u64 = 512 * PART as u64;

/// What tiles are cut by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cut {
    Vertices,
    Triangles,
    /// By the constraint edges that belong to the tile.
    Edges,
}

/// Some vertices, triangles or edges of a tile.
pub(super) struct Part {
    pub(super) tile: Arc<TileInPass>,
    /// Their numbers in the tile.
    pub(super) range: Range<u32>,
    /// How many of the triangles or edges are to be written; 0 if the tile is cut by vertices.
    pub(super) triangles: u32,
    /// How many triangles were written before these, of all tiles.
    pub(super) written_before: u64,
    /// Whether it is the last of its tile.
    pub(super) is_last: bool,
    /// The z of corners that other tiles own, if the format asks for them.
    pub(super) foreign_z: Arc<ForeignZ>,
}

/// The z of vertices of other tiles, by tile.
pub(super) type ForeignZ = BTreeMap<VertexId, f64>;

impl Part {
    /// Hands out the triangles that are written: their corners, and their vertices' numbers.
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

    /// The vertices, and their numbers through the file.
    pub(super) fn vertices(&self, numbering: &Numbering) -> impl Iterator<Item = (VertexIndex, u64)> + use<> {
        let start = numbering.start(&self.tile);
        let vertices = self.range.clone();
        vertices.map(move |vertex| (VertexIndex(vertex), start + u64::from(vertex)))
    }
}

impl Numbering {
    /// The parts of a tile, at least one. Those of triangles are an error if not as many triangles belong to
    /// it as the directory says.
    pub(super) fn cut(
        &self,
        tile: &Arc<TileInPass>,
        cut: Cut,
        foreign_z: &Arc<ForeignZ>,
    ) -> Result<Vec<Part>, ReadError> {
        let count = match cut {
            Cut::Vertices => tile.vertex_count(),
            Cut::Triangles => tile.triangle_count(),
            Cut::Edges => tile.owned_constraints().count() as u32,
        };
        let mut owned = 0;
        let mut parts = Vec::new();
        for start in (0..count.max(1)).step_by(PART as usize) {
            let range = start..count.min(start.saturating_add(PART));
            let mut triangles = match cut {
                Cut::Edges => range.end - range.start,
                Cut::Vertices | Cut::Triangles => 0,
            };
            if cut == Cut::Triangles {
                let core = tile.core_triangle_count().clamp(range.start, range.end);
                let of_part =
                    core - range.start + (core..range.end).filter(|&t| tile.owns(TriangleId(t))).count() as u32;
                owned += of_part;
                triangles = match self.leaves_out_holes() {
                    true => range.clone().filter(|&t| self.is_written(tile, TriangleId(t))).count() as u32,
                    false => of_part,
                };
            }
            parts.push(Part {
                tile: Arc::clone(tile),
                is_last: range.end == count,
                range,
                triangles,
                written_before: 0,
                foreign_z: Arc::clone(foreign_z),
            });
        }
        let expected = self.reader().directory().tiles[tile.id().0 as usize].owned_triangles;
        if cut == Cut::Triangles && owned != expected {
            let reason = format!("{owned} triangles belong to it, and {expected} by the directory");
            return Err(self.reader().damaged(tile.id(), reason));
        }
        Ok(parts)
    }
}
