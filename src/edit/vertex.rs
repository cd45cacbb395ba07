//! A vertex with its z, which a tile hands to the others that get it as a corner.

use crate::geometry::Point;
use crate::store::VertexId;

/// A vertex: its id, its point and its z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EditVertex {
    pub(crate) id: VertexId,
    pub(crate) point: Point,
    /// 0 if the file has no z.
    pub(crate) z: f64,
}
