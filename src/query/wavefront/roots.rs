//! The roots of the wavefront, and its knowledge of the vertices that it has seen.

use std::collections::HashMap;
use std::hash::BuildHasherDefault;

use crate::collections::mix::Mix;
use crate::geometry::Point;
use crate::query::free_space::Mark;
use crate::store::VertexId;

/// Paths whose lengths differ by less than this factor may be equally long except for rounding, so
/// neither excludes the other.
pub(crate) const TIE: f64 = 1.0 + 1e-12;

/// A point from which the wavefront spreads: the source, or a vertex round which it bends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Root {
    pub(crate) point: Point,
    /// The vertex; `None` if the root is a source that is not a vertex.
    pub(crate) vertex: Option<VertexId>,
    /// The length of the path from the source.
    pub(crate) length: f64,
    /// The previous root; `None` for the source.
    pub(crate) parent: Option<u32>,
    /// The number of roots on the path, this one included.
    pub(crate) depth: u32,
    /// The number of wedges of its sector that are processed, from the left end and from the right
    /// end.
    pub(crate) done: [u32; 2],
}

/// The knowledge of a vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    /// The properties of the vertex, known once its tile was read.
    pub(crate) mark: Option<Mark>,
    /// The length of the path at which the vertex was reported, if vertices like it are reported.
    pub(crate) reported: f64,
    /// The root at the vertex.
    pub(crate) root: Option<u32>,
    /// The length of the path to its root, or, if the vertex has one free sector only, of the path
    /// with which it waits in the queue. Longer paths are not needed.
    pub(crate) limit: f64,
}

impl Default for Seen {
    fn default() -> Self {
        Self {
            mark: None,
            reported: f64::INFINITY,
            root: None,
            limit: f64::INFINITY,
        }
    }
}

/// The vertices that were seen, by their ids.
pub(crate) type SeenVertices = HashMap<VertexId, Seen, BuildHasherDefault<Mix>>;
