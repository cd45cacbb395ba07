//! Vertices in their sectors, as a search along edges reached them.

use super::corner::{End, Within};
use crate::geometry::Point;

/// A vertex in a sector, as it was reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Node {
    pub(crate) vertex: End,
    pub(crate) point: Point,
    /// Its sector: the neighbour at the right end of it, or the vertex itself if it has one free sector only. Of a point
    /// that was put in, its number.
    pub(crate) sector: End,
    /// The way to it.
    pub(crate) length: f64,
    /// The node before it; none for the source.
    pub(crate) parent: Option<u32>,
    /// In which wedge it was reached; none for the source.
    pub(crate) within: Option<Within>,
}
