//! The nodes of a search along edges: vertices in their sectors.

use super::corner::{GraphVertex, Within};
use crate::geometry::Point;

/// A vertex in a sector, as the search reached it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Node {
    pub(crate) vertex: GraphVertex,
    pub(crate) point: Point,
    /// The sector: the neighbour at its right end, or the vertex itself if it has one free sector
    /// only. For an inserted point, the number of the sector.
    pub(crate) sector: GraphVertex,
    /// The length of the path.
    pub(crate) length: f64,
    /// The previous node; `None` for the source.
    pub(crate) parent: Option<u32>,
    /// The wedge in which the vertex was reached; `None` for the source.
    pub(crate) within: Option<Within>,
}
