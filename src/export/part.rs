//! Tiles in parts: what is formatted at once, so that no text is larger than a mebibyte, however large the tile.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use super::numbering::Numbering;
use crate::store::{ReadError, TileInPass, VertexId};

/// Vertices or triangles of a part.
const PART: u32 = 2048;

/// Bytes of what is made of a part, at most: no vertex and no triangle has more than 512 in any format.
pub(super) const PIECE_BYTES: u64 = 512 * PART as u64;

/// What tiles are cut by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cut {
    Vertices,
    Triangles,
}

/// Some vertices or triangles of a tile.
pub(super) struct Part {
    pub(super) tile: Arc<TileInPass>,
    /// Their numbers in the tile.
    pub(super) range: Range<u32>,
    /// How many of the triangles before these belong to the tile.
    pub(super) owned_before: u32,
    /// Whether it is the last of its tile.
    pub(super) is_last: bool,
    /// The z of corners that other tiles own, if the format asks for them.
    pub(super) foreign_z: Arc<ForeignZ>,
}

/// The z of vertices of other tiles, by tile.
pub(super) type ForeignZ = BTreeMap<VertexId, f64>;

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
        };
        let mut owned = 0;
        let mut parts = Vec::new();
        for start in (0..count.max(1)).step_by(PART as usize) {
            let range = start..count.min(start.saturating_add(PART));
            let of_part = match cut {
                Cut::Vertices => 0,
                Cut::Triangles => {
                    let core = tile.core_triangle_count().clamp(range.start, range.end);
                    core - range.start + (core..range.end).filter(|&t| tile.owns(t)).count() as u32
                }
            };
            parts.push(Part {
                tile: Arc::clone(tile),
                is_last: range.end == count,
                range,
                owned_before: owned,
                foreign_z: Arc::clone(foreign_z),
            });
            owned += of_part;
        }
        let expected = self.reader().directory().tiles[tile.id().0 as usize].owned_triangles;
        if cut == Cut::Triangles && owned != expected {
            let reason = format!("{owned} triangles belong to it, and {expected} by the directory");
            return Err(self.reader().damaged(tile.id(), reason));
        }
        Ok(parts)
    }
}
