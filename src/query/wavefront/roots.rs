//! Where the wave bent, and what it knows of the vertices that it has seen.

use std::collections::HashMap;
use std::hash::BuildHasherDefault;

use crate::collections::mix::Mix;
use crate::geometry::Point;
use crate::query::free_space::Mark;
use crate::store::VertexId;

/// Ways whose lengths differ by less than this part may be equally long but for rounding, so that neither rules out the other.
pub(crate) const TIE: f64 = 1.0 + 1e-12;

/// A point from which the wave spreads: the source, or a vertex round which it bends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Root {
    pub(crate) point: Point,
    /// The vertex, unless the source is none.
    pub(crate) vertex: Option<VertexId>,
    /// The way from the source.
    pub(crate) length: f64,
    /// The root before it, unless it is the source.
    pub(crate) parent: Option<u32>,
    /// How many wedges of its sector are done, from its left end on, and from its right end on.
    pub(crate) done: [u32; 2],
}

/// What is known of a vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    /// What is true of it, once its tile was there.
    pub(crate) mark: Option<Mark>,
    /// The way over which it was told of, if it is to be.
    pub(crate) told: f64,
    /// Its root.
    pub(crate) root: Option<u32>,
    /// The way to its root, or that over which it waits in the queue, if it has one free sector only: longer ones are not needed.
    pub(crate) limit: f64,
}

impl Default for Seen {
    fn default() -> Self {
        Self {
            mark: None,
            told: f64::INFINITY,
            root: None,
            limit: f64::INFINITY,
        }
    }
}

/// Vertices by their numbers.
pub(crate) type SeenVertices = HashMap<VertexId, Seen, BuildHasherDefault<Mix>>;
