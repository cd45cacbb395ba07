//! Finds crossings in the leaves of a block, before any of them is conquered.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use parking_lot::Mutex;

use crate::constraints::crossings::find::find;
use crate::constraints::crossings::first::{Crossing, FirstCrossings};
use crate::constraints::segment::Segment;
use crate::geometry::{Orientation, Point, Rect, orient2d};
use crate::io::start_scoped;
use crate::store::divide::Item;

/// The points and segments of a leaf.
pub(crate) struct LeafLines<'a> {
    pub(crate) cell: Rect,
    pub(crate) items: &'a [Item],
    /// Indices of the block's segments that may meet the cell.
    pub(crate) segment_indices: &'a [u32],
}

/// Finds the crossings in all leaves on up to `threads` threads.
pub(crate) fn in_leaves(segments: &[Segment], leaves: &[LeafLines<'_>], threads: usize) -> FirstCrossings {
    let next = AtomicUsize::new(0);
    let all = Mutex::new(FirstCrossings::default());
    let work = || {
        while let Some(leaf) = leaves.get(next.fetch_add(1, Ordering::Relaxed)) {
            let found = in_leaf(segments, leaf);
            if found.count() > 0 {
                all.lock().merge(&found);
            }
        }
    };
    thread::scope(|scope| {
        // Works with fewer threads if some cannot be started.
        (1..threads.min(leaves.len())).all(|_| start_scoped(scope, "tile-crossings", work).is_ok());
        work();
    });
    all.into_inner()
}

fn in_leaf(segments: &[Segment], leaf: &LeafLines<'_>) -> FirstCrossings {
    let segments: Vec<Segment> = leaf
        .segment_indices
        .iter()
        .map(|&segment| segments[segment as usize])
        .collect();
    let mut crossings = FirstCrossings::default();
    let mut vertices = None;
    let done = find(&segments, leaf.cell, &mut |one, other, point| {
        let pair = [one, other].map(|segment| segments[segment as usize]);
        // If a vertex is on both, the segments meet there and do not cross.
        let is_on = |segment: Segment| orient2d(segment.ends[0], segment.ends[1], point) == Orientation::Collinear;
        let is_vertex =
            pair.into_iter().all(is_on) && vertices.get_or_insert_with(|| PointSet::of(leaf.items)).has(point);
        if !is_vertex {
            crossings.push(Crossing::new(pair.map(|segment| segment.source.source()), point));
        }
        ControlFlow::Continue(())
    });
    debug_assert!(done.is_continue());
    crossings
}

/// The positions of points, each once.
struct PointSet(Vec<Point>);

impl PointSet {
    fn of(items: &[Item]) -> Self {
        let mut points: Vec<Point> = items.iter().map(|item| item.point).collect();
        points.sort_unstable_by(|a, b| a.lex_cmp(*b));
        points.dedup();
        Self(points)
    }

    fn has(&self, point: Point) -> bool {
        self.0.binary_search_by(|p| p.lex_cmp(point)).is_ok()
    }
}
