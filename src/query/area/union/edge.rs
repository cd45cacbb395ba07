//! Edges between two points.

use std::cmp::Ordering;

use crate::geometry::Point;

/// An edge between two points, and the change of the winding number from its right to its left.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub(super) low: Point,
    /// Greater than `low`, in lexicographic order.
    pub(super) high: Point,
    pub(super) change: i32,
}

impl Edge {
    /// Returns an edge with an area on the left of the way from one point to another.
    pub(super) fn of(from: Point, to: Point) -> Self {
        let (low, high, change) = match from.lex_cmp(to) {
            Ordering::Less => (from, to, 1),
            _ => (to, from, -1),
        };
        Self { low, high, change }
    }

    /// Compares edges by their lower ends, then by their upper ends.
    pub(super) fn cmp(&self, other: &Self) -> Ordering {
        self.low.lex_cmp(other.low).then(self.high.lex_cmp(other.high))
    }
}
