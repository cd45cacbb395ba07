//! The orientation and incircle predicates for tests that share two points.

use super::point::{Point, Rect};
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
}

/// The sign of a rounded determinant.
#[derive(Clone, Copy)]
pub(crate) struct RoundedSign {
    pub(crate) is_positive: bool,
    /// Whether the exact determinant has the same sign, and is not zero.
    pub(crate) is_certain: bool,
}

/// The largest rounding errors that tests of points inside a box can have.
///
/// A test is a comparison with a constant, which takes no magnitudes of the test's own products.
/// Source: Devillers and Pion, "Efficient exact geometric predicates for Delaunay triangulations"
/// (2003), and CGAL's static filters.
///
/// The constants are those of [`orient2d`] and [`incircle`](super::incircle): the error bound times
/// the sum of the magnitudes of the products, for differences of coordinates as large as the box.
/// Rounding is monotone. So no rounded difference of two coordinates exceeds the rounded width or
/// height; and no rounded product, sum or bound of these exceeds the same one of the box. A sign
/// that is certain here is certain by the magnitudes of its own products too.
#[derive(Clone, Copy)]
pub(crate) struct BoxFilter {
    side_error: f64,
    circle_error: f64,
}

impl BoxFilter {
    #[inline]
    pub(crate) fn new(bounds: Rect) -> Self {
        let (x, y) = bounds.size();
        let (cross_terms, dot_terms) = (x * y + y * x, x * x + y * y);
        Self {
            side_error: cross_terms * ORIENT2D_BOUND,
            circle_error: circle_terms((cross_terms, dot_terms), (cross_terms, dot_terms)) * INCIRCLE_BOUND,
        }
    }

    /// Returns whether the viewing point lies to the left of the chord. The operations are those of
    /// `orient2d(l, r, point)`.
    #[inline(always)]
    pub(crate) fn side(&self, view: &View) -> RoundedSign {
        RoundedSign {
            is_positive: view.cross > 0.0,
            is_certain: view.cross.abs() > self.side_error,
        }
    }

    /// Returns whether `q` lies inside the circle through the chord and `p`, which lies to its left.
    #[inline(always)]
    pub(crate) fn circle(&self, p: &View, q: &View) -> RoundedSign {
        let det = circle_determinant(p, q);
        RoundedSign {
            is_positive: det > 0.0,
            is_certain: det.abs() > self.circle_error,
        }
    }
}

/// The operations are those of `incircle(r, p, l, q)`, with both signs of q's cross product and of
/// the result reversed, so its bound holds.
#[inline(always)]
fn circle_determinant(p: &View, q: &View) -> f64 {
    p.dot * q.cross - p.cross * q.dot
}

/// Returns the sum of the magnitudes of the products in [`circle_determinant`], from the magnitudes
/// of the products in the cross and the dot product of both views.
#[inline(always)]
fn circle_terms((p_cross, p_dot): (f64, f64), (q_cross, q_dot): (f64, f64)) -> f64 {
    p_dot * q_cross + p_cross * q_dot
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
        let [c1, c2, d1, d2] = self.products(point);
        View {
            point,
            cross: c1 - c2,
            dot: d1 + d2,
        }
    }

    /// Returns the products that make up the cross and the dot product of a view, two each.
    #[inline(always)]
    fn products(self, point: Point) -> [f64; 4] {
        let (lx, ly) = (self.l.x - point.x, self.l.y - point.y);
        let (rx, ry) = (self.r.x - point.x, self.r.y - point.y);
        [lx * ry, ly * rx, lx * rx, ly * ry]
    }

    /// Returns whether the viewing point lies to the left of the chord. Exact for all valid points
    /// in the box of `filter`.
    #[inline(always)]
    pub(crate) fn is_left(self, filter: &BoxFilter, view: &View) -> bool {
        let sign = filter.side(view);
        if sign.is_certain {
            sign.is_positive
        } else {
            self.orientation(view.point) == Orientation::CounterClockwise
        }
    }

    /// Returns whether the viewing point lies to the right of the chord. Exact for all valid points
    /// in the box of `filter`.
    #[inline(always)]
    pub(crate) fn is_right(self, filter: &BoxFilter, view: &View) -> bool {
        let sign = filter.side(view);
        if sign.is_certain {
            !sign.is_positive
        } else {
            self.orientation(view.point) == Orientation::Clockwise
        }
    }

    /// Returns whether `q` lies inside the circle through `l`, `r` and `p`, as [`in_circle`] does.
    /// `p` lies to the left of the chord. Exact for all valid points in the box of `filter`.
    #[inline(always)]
    pub(crate) fn circle_contains(self, filter: &BoxFilter, p: &View, q: &View) -> bool {
        let sign = filter.circle(p, q);
        if sign.is_certain {
            sign.is_positive
        } else {
            self.circle_contains_by_terms(p, q)
        }
    }

    #[cold]
    #[inline(never)]
    fn orientation(self, point: Point) -> Orientation {
        orient2d(self.l, self.r, point)
    }

    /// Does the work of [`circle_contains`](Self::circle_contains) with the bound of the test's own
    /// products. A tie is never certain.
    #[inline(never)]
    fn circle_contains_by_terms(self, p: &View, q: &View) -> bool {
        let terms = |view: &View| {
            let [c1, c2, d1, d2] = self.products(view.point).map(f64::abs);
            (c1 + c2, d1 + d2)
        };
        let det = circle_determinant(p, q);
        if det.abs() > circle_terms(terms(p), terms(q)) * INCIRCLE_BOUND {
            det > 0.0
        } else {
            in_circle(self.l, self.r, p.point, q.point)
        }
    }
}
