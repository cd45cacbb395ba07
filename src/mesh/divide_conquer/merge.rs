//! Joins two triangulations along a cut.

use super::arrays::Arrays;
use super::half_edges::{BitHalfEdge, GHOST, HalfEdges};
use super::hull::{Axis, Hull};
use crate::geometry::{BoxFilter, Chord, View};

impl Arrays {
    /// Joins two triangulations that a cut across `axis` separates.
    ///
    /// On entry, either hull is a ring of ghosts. On exit, there is one ring around both.
    ///
    /// The base edge l → r rises from the lower tangent to the upper one. At each step one of the
    /// hull edges that face the cut, l → l1 or r1 → r, gets a triangle with the base. Before
    /// that, the inner triangles whose circle contains a point of the other part become ghosts
    /// again.
    ///
    /// ```text
    ///      l'───────r'  upper tangent
    ///     /│╲      ╱│╲
    ///    / l1 ╲  ╱  r1
    ///    ╲ │   ╲╱   │ ╱
    ///     ╲l────────r╱  lower tangent
    /// ```
    ///
    /// For a cut across Y the picture is turned clockwise.
    pub(super) fn merge(&mut self, left: Hull, right: Hull, axis: Axis) -> Hull {
        let first = self.corners.len() as u32;
        self.corners.extend([[GHOST; 3]; 2]);
        self.twins.extend([[BitHalfEdge::UNSET; 3]; 2]);
        let new_ghosts = [first, first + 1].map(|ghost| BitHalfEdge::new(ghost, 0));
        self.half_edges().merge(left, right, axis, new_ghosts)
    }
}

impl HalfEdges<'_> {
    /// Does the work of [`Arrays::merge`], with two new ghosts.
    #[inline(always)]
    fn merge(&mut self, left_hull: Hull, right_hull: Hull, axis: Axis, [bottom, top]: [BitHalfEdge; 2]) -> Hull {
        let filter = BoxFilter::new(left_hull.bounds_with(&right_hull, self.points));
        let (mut ghost_left, mut ghost_right) = self.lower_tangent(&filter, left_hull, right_hull, axis);
        let (mut l, mut r) = (self.dest(ghost_left), self.origin(ghost_right));
        let lowest_left = l;

        self.set_corners(bottom, [r, l, GHOST]);
        let before = self.twin(ghost_left.next());
        let after = self.twin(ghost_right.prev());
        self.link(bottom.next(), before);
        self.link(bottom.prev(), after);

        let mut base = bottom;
        let mut chord = Chord {
            l: self.point(l),
            r: self.point(r),
        };
        loop {
            let mut left = chord.view(self.point(self.origin(ghost_left)));
            let mut right = chord.view(self.point(self.dest(ghost_right)));
            let left_valid = chord.is_left(&filter, &left);
            let right_valid = chord.is_left(&filter, &right);
            if left_valid {
                self.expose_left(&filter, ghost_left, chord, &mut left);
            }
            if right_valid {
                self.expose_right(&filter, ghost_right, chord, &mut right);
            }
            let take_right = match (left_valid, right_valid) {
                (false, false) => break,
                (true, true) => chord.circle_contains(&filter, &left, &right),
                (_, right_valid) => right_valid,
            };
            if take_right {
                // The ghost (r, r1, ∞) becomes the triangle (r, r1, l).
                let above = self.hull_prev(ghost_right);
                self.set_apex(ghost_right, l);
                self.link(ghost_right.prev(), base);
                base = ghost_right.next();
                r = self.origin(base);
                chord.r = right.point();
                ghost_right = above;
            } else {
                // The ghost (l1, l, ∞) becomes the triangle (l1, l, r).
                let above = self.hull_next(ghost_left);
                self.set_apex(ghost_left, r);
                self.link(ghost_left.next(), base);
                base = ghost_left.prev();
                l = self.dest(base);
                chord.l = left.point();
                ghost_left = above;
            }
        }

        self.set_corners(top, [l, r, GHOST]);
        self.link(top, base);
        self.link(top.next(), ghost_right.prev());
        self.link(top.prev(), ghost_left.next());

        // New hull edges leave the left part at the lower tangent and the right part at the upper
        // one. Every other vertex of the hull keeps the ghost of the edge that leaves it.
        let left_hull = left_hull.with_leaving(lowest_left, bottom);
        let right_hull = right_hull.with_leaving(r, top);
        Hull::joined(axis, left_hull, right_hull, self.points)
    }

    /// Returns the lower tangent l → r, as the ghosts of the hull edges that leave l and that
    /// arrive at r.
    ///
    /// If several vertices lie on the tangent line, the ones next to the cut are taken.
    #[inline(always)]
    fn lower_tangent(&self, filter: &BoxFilter, left: Hull, right: Hull, axis: Axis) -> (BitHalfEdge, BitHalfEdge) {
        let next_to_the_cut = match axis {
            Axis::X => (left.right, right.left),
            Axis::Y => (left.top, right.bottom),
        };
        let (mut leaves_l, mut leaves_r) = (next_to_the_cut.0.leaves, next_to_the_cut.1.leaves);
        loop {
            let chord = Chord {
                l: self.point(self.dest(leaves_l)),
                r: self.point(self.dest(leaves_r)),
            };
            let is_below = |vertex: u32| chord.is_right(filter, &chord.view(self.point(vertex)));
            let before_l = self.hull_prev(leaves_l);
            if is_below(self.dest(before_l)) {
                leaves_l = before_l;
            } else if is_below(self.origin(leaves_r)) {
                leaves_r = self.hull_next(leaves_r);
            } else {
                return (leaves_l, self.hull_prev(leaves_r));
            }
        }
    }

    /// Turns triangles (l, l1, a) inside the hull edge l → l1 into ghosts, while the circle
    /// through l, r and l1 contains a. The ghost at l keeps its number. `tip` is l1 at first, and
    /// the vertex that follows l on the hull in the end.
    ///
    /// ```text
    ///      l1                    l1
    ///     ╱ │ ghost             ╱   new ghost
    ///    a  │            →     a
    ///     ╲ │                   ╲   ghost
    ///       l ──── r              l ──── r
    /// ```
    #[inline(always)]
    fn expose_left(&mut self, filter: &BoxFilter, ghost: BitHalfEdge, chord: Chord, tip: &mut View) {
        loop {
            let inner = self.twin(ghost);
            let a = self.origin(inner.prev());
            if a == GHOST {
                return;
            }
            let behind = chord.view(self.point(a));
            if !chord.circle_contains(filter, tip, &behind) {
                return;
            }
            *tip = behind;
            let behind_a_l = self.twin(inner.prev());
            let following = self.twin(ghost.prev());
            self.set_origin(ghost, a);
            self.link(ghost, behind_a_l);
            // The triangle (l, l1, a) becomes the ghost (∞, l1, a).
            self.set_origin(inner, GHOST);
            self.link(inner, following);
            self.link(inner.prev(), ghost.prev());
        }
    }

    /// The mirror image of [`expose_left`](Self::expose_left), for triangles (r1, r, a) inside the
    /// hull edge r1 → r.
    #[inline(always)]
    fn expose_right(&mut self, filter: &BoxFilter, ghost: BitHalfEdge, chord: Chord, tip: &mut View) {
        loop {
            let inner = self.twin(ghost);
            let a = self.origin(inner.prev());
            if a == GHOST {
                return;
            }
            let behind = chord.view(self.point(a));
            if !chord.circle_contains(filter, tip, &behind) {
                return;
            }
            *tip = behind;
            let behind_r_a = self.twin(inner.next());
            let preceding = self.twin(ghost.next());
            self.set_origin(ghost.next(), a);
            self.link(ghost, behind_r_a);
            // The triangle (r1, r, a) becomes the ghost (r1, ∞, a).
            self.set_origin(inner.next(), GHOST);
            self.link(inner, preceding);
            self.link(inner.next(), ghost.next());
        }
    }
}
