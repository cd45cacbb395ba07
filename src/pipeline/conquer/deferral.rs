//! Segments that hold too much: they are put off until the file is there, and inserted then by an edit of it.
//!
//! In: what pieces and segments that cannot go in yet hold in a node. Out: those that wait no more; what they held is final. As a
//! piece can go in at any time, that changes nothing in the end.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};

use parking_lot::Mutex;

use crate::constraints::segment::Segment;
use crate::store::EdgeSource;

type Key = ([[u64; 2]; 2], EdgeSource);

/// Which segments are put off.
#[derive(Debug)]
pub(crate) struct Deferral {
    /// Triangles that may be held in a leaf, and in a node above.
    limits: [usize; 2],
    any: AtomicBool,
    segments: Mutex<HashMap<Key, (Segment, usize)>>,
}

impl Deferral {
    /// With limits of the triangles that may be held in a leaf, and in a node above.
    pub(crate) fn new(limits: [usize; 2]) -> Self {
        Self {
            limits,
            any: AtomicBool::new(false),
            segments: Mutex::default(),
        }
    }

    /// Triangles that may be held in a leaf.
    pub(crate) fn leaf_limit(&self) -> usize {
        self.limits[0]
    }

    /// Triangles that may be held in a node above.
    pub(crate) fn node_limit(&self) -> usize {
        self.limits[1]
    }

    /// Whether none is put off so far.
    pub(crate) fn is_empty(&self) -> bool {
        !self.any.load(Ordering::Acquire)
    }

    /// Whether a segment is put off.
    pub(crate) fn has(&self, segment: &Segment) -> bool {
        !self.is_empty() && self.segments.lock().contains_key(&segment.key())
    }

    /// Puts a segment off, which is there so many times.
    pub(crate) fn add(&self, segment: Segment, copies: usize) {
        let mut segments = self.segments.lock();
        let (_, known) = segments.entry(segment.key()).or_insert((segment, 0));
        *known = copies.max(*known);
        self.any.store(true, Ordering::Release);
    }

    /// All that were put off, in order.
    pub(crate) fn take(&self) -> Vec<Segment> {
        let mut segments: Vec<_> = std::mem::take(&mut *self.segments.lock()).into_values().collect();
        segments.sort_unstable_by_key(|(segment, _)| segment.key());
        let copies = segments
            .into_iter()
            .flat_map(|(segment, copies)| std::iter::repeat_n(segment, copies));
        copies.collect()
    }
}

/// Of those that hold so many triangles each, says which are put off, so that the others hold no more than `limit` together: those
/// that hold most.
pub(crate) fn put_off(held: &[usize], limit: usize) -> Vec<bool> {
    let mut order: Vec<usize> = (0..held.len()).collect();
    order.sort_by_key(|&place| held[place]);
    let mut sum = 0;
    let mut is_off = vec![false; held.len()];
    for place in order {
        sum += held[place];
        is_off[place] = sum > limit && held[place] > 0;
    }
    is_off
}
