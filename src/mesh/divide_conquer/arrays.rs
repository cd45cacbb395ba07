//! The triangles of all parts, and the smallest parts.

use super::half_edges::{BitHalfEdge, GHOST, HalfEdges, Hull};
use crate::geometry::{Orientation, Point, orient2d};

/// The triangles and ghosts of all parts.
#[derive(Default)]
pub(super) struct Arrays {
    /// The points in the order of the cuts. Vertices are positions in this order.
    pub(super) points: Vec<Point>,
    /// The corners of each triangle. While the kernel works, it owns the arrays of the result, and
    /// builds the result in place.
    pub(super) corners: Vec<[u32; 3]>,
    /// For each triangle and corner, the twin of the half-edge that starts there.
    pub(super) twins: Vec<[BitHalfEdge; 3]>,
}

impl Arrays {
    /// Returns the half-edges, for merges.
    #[inline]
    pub(super) fn half_edges(&mut self) -> HalfEdges<'_> {
        HalfEdges {
            points: &self.points,
            origins: self.corners.as_flattened_mut(),
            twins: self.twins.as_flattened_mut(),
        }
    }

    /// Adds a triangle or ghost with the twins of its half-edges. Returns its number.
    #[inline]
    pub(super) fn push(&mut self, corners: [u32; 3], twins: [BitHalfEdge; 3]) -> u32 {
        let number = self.corners.len() as u32;
        self.corners.push(corners);
        self.twins.push(twins);
        number
    }

    /// Creates a ring of ghosts, one for each hull edge, with consecutive numbers. `inside` has the
    /// twins of their real half-edges.
    #[inline(always)]
    fn ring<const N: usize>(&mut self, hull_edges: [(u32, u32); N], inside: [BitHalfEdge; N]) {
        let first = self.corners.len() as u32;
        let ghost = |i: usize| first + (i % N) as u32;
        for (i, ((u, v), twin)) in hull_edges.into_iter().zip(inside).enumerate() {
            let preceding = BitHalfEdge::new(ghost(i + N - 1), 2);
            let following = BitHalfEdge::new(ghost(i + 1), 1);
            self.push([v, u, GHOST], [twin, preceding, following]);
        }
    }

    /// Creates an edge with a ghost on either side, from `a` and the vertex after it. They are in
    /// lexicographic order.
    pub(super) fn edge(&mut self, a: u32) -> Hull {
        let b = a + 1;
        let [ab, ba] = self.next_edges();
        self.ring([(a, b), (b, a)], [ba, ab]);
        Hull { min: ab, max: ba }
    }

    /// Creates a triangle, or a chain, from `a` and the two vertices after it. They are in
    /// lexicographic order.
    pub(super) fn three(&mut self, a: u32) -> Hull {
        let (b, c) = (a + 1, a + 2);
        let [p, q, r] = [a, b, c].map(|vertex| self.points[vertex as usize]);
        match orient2d(p, q, r) {
            Orientation::CounterClockwise => self.triangle([a, b, c], 2),
            Orientation::Clockwise => self.triangle([a, c, b], 1),
            Orientation::Collinear => {
                let [ab, bc, cb, ba] = self.next_edges();
                self.ring([(a, b), (b, c), (c, b), (b, a)], [ba, cb, bc, ab]);
                Hull { min: ab, max: cb }
            }
        }
    }

    /// Creates one triangle with its three ghosts. Its first corner is the smallest vertex, and
    /// corner `max` is the largest.
    fn triangle(&mut self, corners: [u32; 3], max: usize) -> Hull {
        let [_, ab, bc, ca] = self.next_edges();
        let inner = self.push(corners, [ab, bc, ca]);
        let [a, b, c] = corners;
        let inside = [0, 1, 2].map(|corner| BitHalfEdge::new(inner, corner));
        self.ring([(a, b), (b, c), (c, a)], inside);
        Hull {
            min: ab,
            max: [ab, bc, ca][max],
        }
    }

    /// Returns the first half-edge of each of the next `N` triangles or ghosts.
    #[inline(always)]
    fn next_edges<const N: usize>(&self) -> [BitHalfEdge; N] {
        let first = self.corners.len() as u32;
        std::array::from_fn(|i| BitHalfEdge::new(first + i as u32, 0))
    }

    /// Moves triangles to the slots of `ghosts` until the first `count` slots hold no ghosts. The
    /// ghosts are lost.
    pub(super) fn move_behind(&mut self, ghosts: &[BitHalfEdge], count: usize) {
        let mut behind = count;
        for &ghost in ghosts {
            let inner = self.twins[ghost.triangle()][ghost.corner()];
            // A chain has ghosts on both sides. Then the other ghost may have unset this twin
            // before.
            if inner != BitHalfEdge::UNSET {
                self.twins[inner.triangle()][inner.corner()] = BitHalfEdge::UNSET;
            }
            if ghost.triangle() >= count {
                continue;
            }
            while self.corners[behind].contains(&GHOST) {
                behind += 1;
            }
            let slot = ghost.triangle();
            self.corners[slot] = self.corners[behind];
            self.twins[slot] = self.twins[behind];
            for (corner, twin) in (0..).zip(self.twins[slot]) {
                if twin != BitHalfEdge::UNSET {
                    self.twins[twin.triangle()][twin.corner()] = BitHalfEdge::new(slot as u32, corner);
                }
            }
            behind += 1;
        }
    }
}
