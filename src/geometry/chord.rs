//! The orientation and incircle predicates for tests that share two points.

use super::point::Point;
use super::predicates::{INCIRCLE_BOUND, ORIENT2D_BOUND, Orientation, in_circle, orient2d};

/// The chord from `l` to `r`. All circles through `l` and `r` form a pencil, which is ordered by
/// the angles at which points see the chord.
///
/// A merge asks about several points with the same chord: whether they lie to its left, and which
/// of them lies inside the circle through another. Each point is viewed once. The comparison of
/// two views takes a third of the operations of [`incircle`](super::incircle).
#[derive(Clone, Copy)]
pub(crate) struct Chord {
    pub(crate) l: Point,
    pub(crate) r: Point,
}

/// A chord as a point sees it: the cross and the dot product of the directions to its ends.
/// The cotangent of the angle between these is `dot / cross`.
#[derive(Clone, Copy)]
pub(crate) struct View {
    point: Point,
    cross: f64,
    dot: f64,
    /// The sums of the magnitudes of the products in `cross` and in `dot`.
    cross_terms: f64,
    dot_terms: f64,
}

impl View {
    #[inline]
    pub(crate) fn point(&self) -> Point {
        self.point
    }
}

impl Chord {
    #[inline(always)]
    pub(crate) fn view(self, point: Point) -> View {
        let (lx, ly) = (self.l.x - point.x, self.l.y - point.y);
        let (rx, ry) = (self.r.x - point.x, self.r.y - point.y);
        let (c1, c2, d1, d2) = (lx * ry, ly * rx, lx * rx, ly * ry);
        View {
            point,
            cross: c1 - c2,
            dot: d1 + d2,
            cross_terms: c1.abs() + c2.abs(),
            dot_terms: d1.abs() + d2.abs(),
        }
    }

    /// Returns whether the viewing point lies to the left of the chord. Exact for all valid points.
    #[inline(always)]
    pub(crate) fn is_left(self, view: &View) -> bool {
        // The operations are those of `orient2d(l, r, point)`.
        if view.cross.abs() >= view.cross_terms * ORIENT2D_BOUND {
            view.cross > 0.0
        } else {
            self.is_left_exactly(view.point)
        }
    }

    /// Returns whether `q` lies inside the circle through `l`, `r` and `p`, as [`in_circle`] does.
    /// `p` lies to the left of the chord. Exact for all valid points.
    #[inline(always)]
    pub(crate) fn circle_contains(self, p: &View, q: &View) -> bool {
        // The operations are those of `incircle(r, p, l, q)`, with both signs of q's cross product
        // and of the result reversed, so its bound holds. A tie is never certain.
        let det = p.dot * q.cross - p.cross * q.dot;
        let magnitude = p.dot_terms * q.cross_terms + p.cross_terms * q.dot_terms;
        if det.abs() > magnitude * INCIRCLE_BOUND {
            det > 0.0
        } else {
            self.circle_contains_exactly(p.point, q.point)
        }
    }

    #[cold]
    #[inline(never)]
    fn is_left_exactly(self, point: Point) -> bool {
        orient2d(self.l, self.r, point) == Orientation::CounterClockwise
    }

    #[cold]
    #[inline(never)]
    fn circle_contains_exactly(self, p: Point, q: Point) -> bool {
        in_circle(self.l, self.r, p, q)
    }
}
