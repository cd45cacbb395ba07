//! The boundary of a triangulation or of a part of one: edges with a triangle on one side only.

use std::num::NonZeroU32;
use std::sync::OnceLock;

use crate::geometry::{HalfEdge, Orientation, Point, orient2d};

/// Boundary edges, each with its triangle on the left.
#[derive(Clone, Debug, Default)]
pub(super) struct Boundary {
    /// The origin, the destination and the half-edge of each boundary edge, sorted. Several edges
    /// leave a point where parts of the triangulation are missing.
    edges: Vec<(u32, u32, HalfEdge)>,
    /// For each point, one more than the index of its first edge in `edges`, or `None`. Empty if
    /// the triangulation has no triangles.
    first: Vec<Option<NonZeroU32>>,
    /// The end points of `edges`. The first call of [`entry`](Self::entry) computes them.
    ends: OnceLock<Vec<[Point; 2]>>,
}

impl Boundary {
    /// Creates the boundary from its edges. `points` is the number of points of the triangulation.
    pub(super) fn new(mut edges: Vec<(u32, u32, HalfEdge)>, points: usize) -> Self {
        edges.sort_unstable();
        let mut first = vec![None; points];
        let mut next = NonZeroU32::MIN;
        for of_point in edges.chunk_by(|a, b| a.0 == b.0) {
            first[of_point[0].0 as usize] = Some(next);
            next = next.saturating_add(of_point.len() as u32);
        }
        Self {
            edges,
            first,
            ends: OnceLock::new(),
        }
    }

    fn first_edge(&self, point: u32) -> Option<usize> {
        let first = *self.first.get(point as usize)?;
        first.map(|first| first.get() as usize - 1)
    }

    /// Returns whether a point is on the boundary.
    pub(super) fn has(&self, point: u32) -> bool {
        self.first_edge(point).is_some()
    }

    /// Returns the `n`-th boundary half-edge that leaves `point`, counted from 0.
    pub(super) fn leaving(&self, point: u32, n: usize) -> Option<HalfEdge> {
        let edge = self.edges.get(self.first_edge(point)? + n);
        edge.filter(|&&(from, ..)| from == point)
            .map(|&(.., half_edge)| half_edge)
    }

    /// Replaces the half-edge of the boundary edge `from` → `to`. Does nothing if there is no
    /// such edge.
    pub(super) fn set(&mut self, from: u32, to: u32, half_edge: HalfEdge) {
        if let Ok(index) = self
            .edges
            .binary_search_by_key(&(from, to), |&(from, to, _)| (from, to))
        {
            self.edges[index].2 = half_edge;
        }
    }

    /// Returns the edge through which the segment from `a` to `b` enters: its origin, destination
    /// and half-edge. The segment crosses that edge in the interior of both.
    pub(super) fn entry(&self, points: &[Point], [a, b]: [Point; 2]) -> Option<(u32, u32, HalfEdge)> {
        let ends = self.ends.get_or_init(|| {
            let edges = self.edges.iter();
            edges
                .map(|&(from, to, _)| [from, to].map(|point| points[point as usize]))
                .collect()
        });
        let (left, right, low, high) = (a.x.min(b.x), a.x.max(b.x), a.y.min(b.y), a.y.max(b.y));
        let enters = |[p, q]: &[Point; 2]| {
            // The bounding boxes rule out most edges.
            let is_beside = p.x.max(q.x) < left || p.x.min(q.x) > right || p.y.max(q.y) < low || p.y.min(q.y) > high;
            !is_beside
                && orient2d(*p, *q, a) == Orientation::Clockwise
                && orient2d(*p, *q, b) == Orientation::CounterClockwise
                && orient2d(a, b, *p) == Orientation::CounterClockwise
                && orient2d(a, b, *q) == Orientation::Clockwise
        };
        ends.iter().position(enters).map(|index| self.edges[index])
    }
}
