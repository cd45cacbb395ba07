//! Joins two triangulations along a cut.

use super::arrays::Arrays;
use super::half_edges::{BitHalfEdge, GHOST, HalfEdges, Hull};
use crate::geometry::{Chord, Point, View};

/// A vertex of a hull and the ghost of the hull edge that leaves it.
type End = (u32, BitHalfEdge);

/// The axis whose extent a cut halves.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Axis {
    X,
    Y,
}

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
        let mut new_ghost = || BitHalfEdge::new(self.push([GHOST; 3], [BitHalfEdge::UNSET; 3]), 0);
        let (bottom, top) = (new_ghost(), new_ghost());
        self.half_edges().merge([left, right], axis, [bottom, top])
    }
}

impl HalfEdges<'_> {
    /// Does the work of [`Arrays::merge`], with two new ghosts.
    fn merge(&mut self, [left, right]: [Hull; 2], axis: Axis, [bottom, top]: [BitHalfEdge; 2]) -> Hull {
        let ends_left = [left.min, left.max].map(|ghost| (self.dest(ghost), ghost));
        let ends_right = [right.min, right.max].map(|ghost| (self.dest(ghost), ghost));
        let (mut ghost_left, mut ghost_right) = self.lower_tangent(left, right, axis);
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
            let left_valid = chord.is_left(&left);
            let right_valid = chord.is_left(&right);
            if left_valid {
                self.expose_left(ghost_left, chord, &mut left);
            }
            if right_valid {
                self.expose_right(ghost_right, chord, &mut right);
            }
            let take_right = match (left_valid, right_valid) {
                (false, false) => break,
                (true, true) => chord.circle_contains(&left, &right),
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
        let leaving_left = |(vertex, ghost): End| (vertex, if vertex == lowest_left { bottom } else { ghost });
        let leaving_right = |(vertex, ghost): End| (vertex, if vertex == r { top } else { ghost });
        self.joined_hull(axis, ends_left.map(leaving_left), ends_right.map(leaving_right))
    }

    /// Returns the hull of two joined parts, from the smallest and the largest vertex of each.
    fn joined_hull(&self, axis: Axis, [left_min, left_max]: [End; 2], [right_min, right_max]: [End; 2]) -> Hull {
        // A cut across X separates the parts lexicographically.
        if axis == Axis::X {
            return Hull {
                min: left_min.1,
                max: right_max.1,
            };
        }
        let smaller = |a: End, b: End| self.point(a.0).lex_cmp(self.point(b.0)).is_lt();
        let pick = |first: bool, a: End, b: End| if first { a.1 } else { b.1 };
        Hull {
            min: pick(smaller(left_min, right_min), left_min, right_min),
            max: pick(smaller(left_max, right_max), right_max, left_max),
        }
    }

    /// Returns the lower tangent l → r, as the ghosts of the hull edges that leave l and that
    /// arrive at r.
    ///
    /// If several vertices lie on the tangent line, the ones next to the cut are taken.
    fn lower_tangent(&self, left: Hull, right: Hull, axis: Axis) -> (BitHalfEdge, BitHalfEdge) {
        let (mut leaves_l, mut leaves_r) = match axis {
            Axis::X => (left.max, right.min),
            Axis::Y => (
                self.climb(left.max, yx_less),
                self.climb(right.min, |here, next| yx_less(next, here)),
            ),
        };
        loop {
            let (l, r) = (self.point(self.dest(leaves_l)), self.point(self.dest(leaves_r)));
            let before_l = self.hull_prev(leaves_l);
            if self.is_below(l, r, self.dest(before_l)) {
                leaves_l = before_l;
            } else if self.is_below(l, r, self.origin(leaves_r)) {
                leaves_r = self.hull_next(leaves_r);
            } else {
                return (leaves_l, self.hull_prev(leaves_r));
            }
        }
    }

    /// Walks counter-clockwise along a hull while `better(here, next)` holds.
    fn climb(&self, mut leaves: BitHalfEdge, better: impl Fn(Point, Point) -> bool) -> BitHalfEdge {
        while better(self.point(self.dest(leaves)), self.point(self.origin(leaves))) {
            leaves = self.hull_next(leaves);
        }
        leaves
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
    fn expose_left(&mut self, ghost: BitHalfEdge, chord: Chord, tip: &mut View) {
        loop {
            let inner = self.twin(ghost);
            let a = self.origin(inner.prev());
            if a == GHOST {
                return;
            }
            let behind = chord.view(self.point(a));
            if !chord.circle_contains(tip, &behind) {
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
    fn expose_right(&mut self, ghost: BitHalfEdge, chord: Chord, tip: &mut View) {
        loop {
            let inner = self.twin(ghost);
            let a = self.origin(inner.prev());
            if a == GHOST {
                return;
            }
            let behind = chord.view(self.point(a));
            if !chord.circle_contains(tip, &behind) {
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

/// Returns whether `a` comes before `b` by x, then by y.
pub(super) fn xy_less(a: Point, b: Point) -> bool {
    (a.x < b.x) | ((a.x == b.x) & (a.y < b.y))
}

/// Returns whether `a` comes before `b` by y, then by x.
pub(super) fn yx_less(a: Point, b: Point) -> bool {
    (a.y < b.y) | ((a.y == b.y) & (a.x < b.x))
}
