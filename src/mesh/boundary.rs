//! The boundary of a triangulation, or of parts of one: edges with a triangle on one side only.

use std::num::NonZeroU32;
use std::sync::OnceLock;

use crate::geometry::{HalfEdge, Orientation, Point, orient2d};

/// Boundary edges, each with its triangle on the left.
#[derive(Clone, Debug, Default)]
pub(super) struct Boundary {
    /// From, to, and the half-edge there, in order. A point has several where parts are missing.
    edges: Vec<(u32, u32, HalfEdge)>,
    /// For each point one more than the position of its first edge, if it has any; without edges nothing.
    first: Vec<Option<NonZeroU32>>,
    /// The ends of the edges, once somebody comes in.
    ends: OnceLock<Vec<[Point; 2]>>,
}

impl Boundary {
    /// Of these edges between so many points.
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

    /// Whether a point is on the boundary.
    pub(super) fn has(&self, point: u32) -> bool {
        self.first_edge(point).is_some()
    }

    /// The half-edge that is the n-th of those that leave a point.
    pub(super) fn leaving(&self, point: u32, n: usize) -> Option<HalfEdge> {
        let edge = self.edges.get(self.first_edge(point)? + n);
        edge.filter(|&&(from, ..)| from == point)
            .map(|&(.., half_edge)| half_edge)
    }

    /// An edge belongs to this half-edge now.
    pub(super) fn set(&mut self, from: u32, to: u32, half_edge: HalfEdge) {
        if let Ok(place) = self
            .edges
            .binary_search_by_key(&(from, to), |&(from, to, _)| (from, to))
        {
            self.edges[place].2 = half_edge;
        }
    }

    /// The edge by which the line from `a` to `b` comes in, between its ends and through none of the edge's: from, to, half-edge.
    pub(super) fn entry(&self, points: &[Point], [a, b]: [Point; 2]) -> Option<(u32, u32, HalfEdge)> {
        let ends = self.ends.get_or_init(|| {
            let edges = self.edges.iter();
            edges
                .map(|&(from, to, _)| [from, to].map(|point| points[point as usize]))
                .collect()
        });
        let (left, right, low, high) = (a.x.min(b.x), a.x.max(b.x), a.y.min(b.y), a.y.max(b.y));
        let enters = |[p, q]: &[Point; 2]| {
            // Most edges are nowhere near.
            let is_beside = p.x.max(q.x) < left || p.x.min(q.x) > right || p.y.max(q.y) < low || p.y.min(q.y) > high;
            !is_beside
                && orient2d(*p, *q, a) == Orientation::Clockwise
                && orient2d(*p, *q, b) == Orientation::CounterClockwise
                && orient2d(a, b, *p) == Orientation::CounterClockwise
                && orient2d(a, b, *q) == Orientation::Clockwise
        };
        ends.iter().position(enters).map(|place| self.edges[place])
    }
}
