//! Where the wave bent, and what it knows of the vertices that it has seen.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use crate::geometry::Point;
use crate::store::VertexId;

/// No root, where the source has none.
pub(super) const NO_ROOT: u32 = u32::MAX;

/// Ways whose lengths differ by less than this part may be equally long but for rounding, so that neither rules out the other.
pub(super) const TIE: f64 = 1.0 + 1e-12;

/// A point from which the wave spreads: the source, or a vertex round which it bends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Root {
    pub(super) point: Point,
    /// The vertex, unless the source is none.
    pub(super) vertex: Option<VertexId>,
    /// The way from the source.
    pub(super) length: f64,
    /// The root before it.
    pub(super) parent: u32,
    /// How many wedges of its sector are done, from its left end on, and from its right end on.
    pub(super) done: [u32; 2],
}

/// What is known of a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// Its marks, once its tile was there.
    pub(super) marks: Option<u8>,
    /// The way over which it was told of, if it is to be.
    pub(super) told: f64,
    /// Its root, or [`NO_ROOT`].
    pub(super) root: u32,
    /// The way to its root, or that over which it waits in the queue, if it has one free sector only: longer ones are not needed.
    pub(super) limit: f64,
}

impl Default for Seen {
    fn default() -> Self {
        Self {
            marks: None,
            told: f64::INFINITY,
            root: NO_ROOT,
            limit: f64::INFINITY,
        }
    }
}

/// Vertices by their numbers.
pub(super) type SeenVertices = HashMap<VertexId, Seen, BuildHasherDefault<Mix>>;

/// A fast hash for numbers that nobody chooses: multiply and fold.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::query) struct Mix(u64);

impl Hasher for Mix {
    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 32)
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_u64(byte.into()));
    }

    fn write_u32(&mut self, value: u32) {
        self.write_u64(value.into());
    }

    fn write_u64(&mut self, value: u64) {
        // The golden ratio's digits.
        self.0 = (self.0.rotate_left(26) ^ value).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
}
