//! Deferred segments: segments that hold too many triangles. An edit inserts them once the file is
//! complete.
//!
//! In: the triangles that pending subsegments and segments hold in a node. Out: the segments that
//! are deferred; the triangles that they held are final. As a subsegment can be inserted at any
//! time, deferring it does not change the result.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};

use parking_lot::Mutex;

use crate::constraints::segment::Segment;
use crate::store::LinePart;

type Key = ([[u64; 2]; 2], LinePart);

/// The set of deferred segments.
#[derive(Debug)]
pub(crate) struct Deferral {
    /// Most triangles that may be held in a leaf, and in a node above.
    limits: [usize; 2],
    any: AtomicBool,
    segments: Mutex<HashMap<Key, (Segment, usize)>>,
}

impl Deferral {
    /// Creates an empty set with limits of the held triangles in a leaf, and in a node above.
    pub(crate) fn new(limits: [usize; 2]) -> Self {
        Self {
            limits,
            any: AtomicBool::new(false),
            segments: Mutex::default(),
        }
    }

    /// Returns the most triangles that may be held in a leaf.
    pub(crate) fn leaf_limit(&self) -> usize {
        self.limits[0]
    }

    /// Returns the most triangles that may be held in a node above the leaves.
    pub(crate) fn node_limit(&self) -> usize {
        self.limits[1]
    }

    /// Returns whether no segment is deferred so far.
    pub(crate) fn is_empty(&self) -> bool {
        !self.any.load(Ordering::Acquire)
    }

    /// Returns whether a segment is deferred.
    pub(crate) fn has(&self, segment: &Segment) -> bool {
        !self.is_empty() && self.segments.lock().contains_key(&segment.key())
    }

    /// Defers `copies` copies of a segment.
    pub(crate) fn add(&self, segment: Segment, copies: usize) {
        let mut segments = self.segments.lock();
        let (_, known) = segments.entry(segment.key()).or_insert((segment, 0));
        *known = copies.max(*known);
        self.any.store(true, Ordering::Release);
    }

    /// Takes all deferred segments, sorted.
    pub(crate) fn take(&self) -> Vec<Segment> {
        let mut segments: Vec<_> = std::mem::take(&mut *self.segments.lock()).into_values().collect();
        segments.sort_unstable_by_key(|(segment, _)| segment.key());
        let copies = segments
            .into_iter()
            .flat_map(|(segment, copies)| std::iter::repeat_n(segment, copies));
        copies.collect()
    }
}

/// Chooses which segments to defer, given the number of triangles that each holds. Those that hold
/// most are deferred, so that the others together hold at most `limit`.
pub(crate) fn choose_deferred(held: &[usize], limit: usize) -> Vec<bool> {
    let mut order: Vec<usize> = (0..held.len()).collect();
    order.sort_by_key(|&index| held[index]);
    let mut sum = 0;
    let mut is_deferred = vec![false; held.len()];
    for index in order {
        sum += held[index];
        is_deferred[index] = sum > limit && held[index] > 0;
    }
    is_deferred
}
