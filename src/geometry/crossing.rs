//! The exact crossing point of two segments, rounded once.
//!
//! # Method
//!
//! Segment cd crosses the line ab at the point that divides cd in the ratio of the distances of `c`
//! and `d` from that line. These distances are proportional to the orientation determinants:
//!
//! ```text
//!          d
//!         /            v·c + w·d
//!   a----x----b    x = ---------    v = |orient(a, b, d)|, w = |orient(a, b, c)|
//!       /                v + w
//!      c
//! ```
//!
//! Numerators and denominator are [expansions](crate::geometry::expansion), so they have no
//! rounding error. Their rounded quotient is off by at most a few units in the last place. From
//! there, exact signs of `numerator - middle · denominator` lead to the nearest number, where
//! `middle` is halfway to a neighbour.
//!
//! # Rounding is monotonic
//!
//! A coordinate is rounded to the nearest coordinate that is valid by [`Point::is_valid`], with
//! ties to even. So a nonzero coordinate smaller than [`Point::MIN_MAGNITUDE`] becomes that value
//! or zero, whichever is nearer, and zero if it is halfway. Rounding to the nearest number of a set
//! preserves order, and leaves the set's own numbers unchanged:
//!
//! - the rounded point lies in the bounding box of either segment;
//! - points that follow each other along a segment still do so after rounding, in both coordinates;
//! - a coordinate that is left of a number of the set is not right of it after rounding.
//!
//! # Why nothing overflows or underflows
//!
//! As in [`predicates`](crate::geometry::predicates), coordinates are multiples of 2⁻¹⁹⁴ up
//! to 2²⁰⁰. Determinants are multiples of 2⁻³⁸⁸ up to 2⁴⁰³, and numerators are
//! multiples of 2⁻⁵⁸² up to 2⁶⁰⁴. Half the distance of two neighbouring numbers is at
//! least 2⁻¹⁹⁶, and a power of two, so its product with the denominator is a multiple of
//! 2⁻⁵⁸⁴.

use std::cmp::Ordering;

use crate::geometry::expansion::Expansion;
use crate::geometry::point::{Point, Rect};
use crate::geometry::predicates::{Orientation, orient2d, orientation_determinant};

/// Returns whether the segments ab and cd cross: they meet in exactly one point, which is not an
/// end of either.
///
/// Segments that share an end, that overlap, or one of which ends on the other do not cross. Exact
/// for all valid points.
#[inline]
#[must_use]
pub fn segments_cross(a: Point, b: Point, c: Point, d: Point) -> bool {
    are_opposite(orient2d(a, b, c), orient2d(a, b, d)) && are_opposite(orient2d(c, d, a), orient2d(c, d, b))
}

/// Returns the point where the segments ab and cd cross, if they do. Each coordinate is the valid
/// number nearest to the exact coordinate.
///
/// Ties go to even. A coordinate that is too small to be valid becomes [`Point::MIN_MAGNITUDE`] or
/// 0, whichever is nearer. The result does not depend on the order or the direction of the
/// segments, and lies in the bounding box of either. The result is `None` if a point is not valid.
#[must_use]
pub fn crossing_point(a: Point, b: Point, c: Point, d: Point) -> Option<Point> {
    ExactCrossing::of([a, b], [c, d]).map(|crossing| crossing.rounded())
}

/// Returns whether two crossing segments certainly do not cross in a rectangle, even after their
/// crossing point is rounded.
///
/// This uses floating point with error bounds. An area passes four roundings (see [`orient2d`]), so
/// its error is at most 4ε times the sum of the magnitudes of its two products, with ε =
/// 2⁻⁵³. Twice that is compared with the sum of both areas, which bounds the error of the
/// ratio in which the crossing point divides cd.
pub(crate) fn cross_outside([a, b]: [Point; 2], [c, d]: [Point; 2], rect: Rect) -> bool {
    let area = |p: Point| {
        let (left, right) = ((a.x - p.x) * (b.y - p.y), (a.y - p.y) * (b.x - p.x));
        ((left - right).abs(), (left.abs() + right.abs()) * (4.0 * f64::EPSILON))
    };
    let ((of_c, error_c), (of_d, error_d)) = (area(c), area(d));
    let ratio = of_c / (of_c + of_d);
    let error = 2.0 * (error_c + error_d) / (of_c + of_d) + 4.0 * f64::EPSILON;
    let is_beyond = |c: f64, d: f64, min: f64, max: f64| {
        let at = c + ratio * (d - c);
        let error = (d - c).abs() * error + (c.abs() + d.abs()) * (4.0 * f64::EPSILON) + Point::MIN_MAGNITUDE;
        at + error < min || at - error > max
    };
    // Also false if `error` is NaN.
    error < 0.25 && (is_beyond(c.x, d.x, rect.min_x, rect.max_x) || is_beyond(c.y, d.y, rect.min_y, rect.max_y))
}

/// Returns whether a segment may meet a closed cell. Exact if the cell is finite.
pub(crate) fn segment_meets([a, b]: [Point; 2], cell: Rect) -> bool {
    let beside = a.x.max(b.x) < cell.min_x
        || a.x.min(b.x) > cell.max_x
        || a.y.max(b.y) < cell.min_y
        || a.y.min(b.y) > cell.max_y;
    if beside {
        return false;
    }
    if cell.contains(a) || cell.contains(b) {
        return true;
    }
    let corners = [
        Point::new(cell.min_x, cell.min_y),
        Point::new(cell.max_x, cell.min_y),
        Point::new(cell.min_x, cell.max_y),
        Point::new(cell.max_x, cell.max_y),
    ];
    if corners
        .iter()
        .any(|corner| !corner.x.is_finite() || !corner.y.is_finite())
    {
        return true;
    }
    let turns = corners.map(|corner| orient2d(a, b, corner));
    turns.iter().any(|turn| *turn != turns[0]) || turns[0] == Orientation::Collinear
}

#[inline]
fn are_opposite(one: Orientation, other: Orientation) -> bool {
    one != Orientation::Collinear && other != Orientation::Collinear && one != other
}

/// The exact point where two segments cross.
#[derive(Clone, Debug)]
pub(crate) struct ExactCrossing {
    /// The ends of one segment. `weights` has the weight of each.
    ends: [Point; 2],
    weights: [Expansion<16>; 2],
    /// The sum of the weights.
    denominator: Expansion<32>,
}

impl ExactCrossing {
    /// Returns the crossing point of two segments, if they cross.
    pub(crate) fn of([a, b]: [Point; 2], [c, d]: [Point; 2]) -> Option<Self> {
        let are_valid = [a, b, c, d].into_iter().all(Point::is_valid);
        (are_valid && segments_cross(a, b, c, d)).then(|| {
            let weights = [d, c].map(|p| {
                let determinant = orientation_determinant(a, b, p);
                match determinant.sign() {
                    Ordering::Less => determinant.negated(),
                    _ => determinant,
                }
            });
            Self {
                ends: [c, d],
                denominator: Expansion::sum(&weights[0], &weights[1]),
                weights,
            }
        })
    }

    /// Returns the point with each coordinate rounded to the nearest valid one.
    pub(crate) fn rounded(&self) -> Point {
        Point::new(self.nearest(|p| p.x), self.nearest(|p| p.y))
    }

    /// Returns the rounded point, if the exact point is in `cell`. The cell owns its right and top
    /// side, but not its left and bottom side.
    ///
    /// The sides are valid coordinates or infinite.
    pub(crate) fn rounded_if_in(&self, cell: Rect) -> Option<Point> {
        let point @ Point { x, y } = self.rounded();
        let is_beyond = |rounded: f64, side: f64, coordinate: fn(Point) -> f64| {
            // Otherwise the rounded coordinate is on the same side of `side` as the exact one.
            if rounded == side {
                self.compare(coordinate, side).is_gt()
            } else {
                rounded > side
            }
        };
        let is_in = is_beyond(x, cell.min_x, |p| p.x)
            && is_beyond(y, cell.min_y, |p| p.y)
            && !is_beyond(x, cell.max_x, |p| p.x)
            && !is_beyond(y, cell.max_y, |p| p.y);
        is_in.then_some(point)
    }

    /// Compares a coordinate of the exact point with a number.
    fn compare(&self, coordinate: fn(Point) -> f64, number: f64) -> Ordering {
        self.less(&self.numerator(coordinate), number).sign()
    }

    fn numerator(&self, coordinate: fn(Point) -> f64) -> Expansion<64> {
        let [c, d] = [0, 1].map(|i| Expansion::<32>::scaled(&self.weights[i], coordinate(self.ends[i])));
        Expansion::sum(&c, &d)
    }

    /// Returns `numerator` - `number` · denominator.
    fn less(&self, numerator: &Expansion<64>, number: f64) -> Expansion<128> {
        Expansion::sum(numerator, &Expansion::<64>::scaled(&self.denominator, -number))
    }

    fn nearest(&self, coordinate: fn(Point) -> f64) -> f64 {
        let [c, d] = self.ends.map(coordinate);
        let numerator = self.numerator(coordinate);
        let quotient = numerator.estimate() / self.denominator.estimate();
        let mut best = nearly_valid(quotient.max(c.min(d)).min(c.max(d)));
        loop {
            let rest = self.less(&numerator, best);
            let neighbour = match rest.sign() {
                Ordering::Equal => break,
                Ordering::Greater => next_up(best),
                Ordering::Less => -next_up(-best),
            };
            // Both results are exact: the two numbers differ by a unit in the last place.
            let half = (neighbour - best) / 2.0;
            let beyond = Expansion::<192>::sum(&rest, &Expansion::<64>::scaled(&self.denominator, -half)).sign();
            if beyond == Ordering::Equal {
                best = even(best, neighbour);
                break;
            }
            if beyond != rest.sign() {
                break;
            }
            best = neighbour;
        }
        // Turns -0.0 into 0.0.
        best + 0.0
    }
}

/// Returns `v`, or 0 if `v` is too small to be a coordinate.
fn nearly_valid(v: f64) -> f64 {
    if v.abs() < Point::MIN_MAGNITUDE { 0.0 } else { v }
}

/// Returns the next larger coordinate.
fn next_up(v: f64) -> f64 {
    if v == 0.0 {
        Point::MIN_MAGNITUDE
    } else if v == -Point::MIN_MAGNITUDE {
        0.0
    } else {
        v.next_up()
    }
}

/// Returns the one of two neighbours that has an even significand. If both have, they are zero and
/// the smallest magnitude, and the result is zero.
fn even(one: f64, other: f64) -> f64 {
    let (small, large) = if one.abs() < other.abs() {
        (one, other)
    } else {
        (other, one)
    };
    if small.to_bits() & 1 == 0 { small } else { large }
}

#[cfg(test)]
mod tests;
