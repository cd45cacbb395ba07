//! A vertex with its z, which a tile hands to the others that get it as a corner.

use crate::geometry::Point;
use crate::store::{TileId, VertexId};

/// A vertex: its id, its point and its z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EditVertex {
    pub(crate) id: VertexId,
    pub(crate) point: Point,
    /// 0 if the file has no z.
    pub(crate) z: f64,
}

/// Returns the tile that an edge belongs to, and so knows its lines: that of its lexicographically
/// smaller end.
pub(crate) fn owner([a, b]: [EditVertex; 2]) -> TileId {
    match a.point.lex_cmp(b.point).is_lt() {
        true => a.id.tile,
        false => b.id.tile,
    }
}
