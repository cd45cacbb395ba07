//! Exact geometric predicates: orientation, incircle, and incircle with ties broken by coordinates
//! alone.
//!
//! # Method
//!
//! There are three stages. Each is called only where the one before cannot determine the sign:
//!
//! 1. floating point with a forward error bound (Shewchuk, "Adaptive Precision Floating-Point
//!    Arithmetic and Fast Robust Geometric Predicates", Discrete & Computational Geometry 18, 1997:
//!    the bounds called A);
//! 2. integers, where one power of two makes *all* the coordinates integers of at most 61 bits,
//!    which is verified bit for bit. This covers grids, lidar and other coordinates of similar
//!    magnitudes, and decides ties at little cost;
//! 3. [expansions](crate::geometry::expansion) with the rounding errors of the differences, for all
//!    other input.
//!
//! Departures from the paper: integers replace its stages B and C. And `incircle` is not expanded
//! along the column of squares, but written in terms of the angles at `b` and at `d` over the chord
//! `ac`,
//!
//! ```text
//!       c          det = - (sin B · cos D + cos B · sin D) · |a-b| |c-b| |a-d| |c-d|
//!     / | \            = - (cross(c-b, a-b) · dot(a-d, c-d) + dot(c-b, a-b) · cross(a-d, c-d))
//!   d   |   b
//!     \ | /        d is inside the circle if and only if B + D > π.
//!       a
//! ```
//!
//! which is the same polynomial, with fewer operations and fewer terms.
//!
//! # Why nothing overflows or underflows
//!
//! Coordinates are zero or of magnitude 2⁻¹⁴² to 2²⁰⁰ ([`Point::is_valid`]), so each is
//! a multiple of 2⁻¹⁴²⁻⁵² = 2⁻¹⁹⁴, and so is every sum and difference of them,
//! rounded or not, and every rounding error of one.
//!
//! - *Below.* A product of two is a multiple of 2⁻³⁸⁸, a product of four of 2⁻⁷⁷⁶,
//!   and so are their sums, their halves when split and the rounding errors of all these, because
//!   rounding a multiple of a power of two yields a multiple of it. So every nonzero result is at
//!   least 2⁻⁷⁷⁶, far above the smallest normal number, 2⁻¹⁰²². Even the error
//!   bounds, which are about 2⁻⁵⁰ times a product of four, are above 2⁻⁸²⁷. A product
//!   is zero only if a factor is.
//! - *Above.* A difference is at most 2²⁰¹, a product of two 2⁴⁰², a cross or dot product
//!   2⁴⁰³, a product of these 2⁸⁰⁶, the sum of two such, or of their magnitudes,
//!   2⁸⁰⁷. A term of an expansion exceeds its number by a factor of two at most. Splitting
//!   multiplies by 2²⁷, and is applied only to factors: terms of cross and dot products, at most
//!   2⁴⁰⁴. All of this is far below 2¹⁰²⁴.
//!
//! Outside these limits the functions return, but their results are unspecified.

use std::cmp::Ordering;

use crate::geometry::expansion::Expansion;
use crate::geometry::point::Point;

/// Half a unit in the last place of 1: the largest relative error of one rounded operation,
/// 2⁻⁵³.
const HALF_ULP: f64 = f64::EPSILON / 2.0;

/// The error of the rounded orientation determinant relative to the sum of the magnitudes of its
/// two products (Shewchuk, `ccwerrboundA`).
pub(super) const ORIENT2D_BOUND: f64 = (3.0 + 16.0 * HALF_ULP) * HALF_ULP;

/// The error of the rounded incircle determinant relative to the sum of the magnitudes of its eight
/// products.
///
/// Each of these products passes ten roundings: four differences, one product and one sum in each
/// of cross and dot, their product, and the last sum. So the error is at most 10ε/(1-10ε) times
/// the exact sum of magnitudes. The exact sum exceeds the computed one by a factor of at most
/// 1/(1-ε)¹⁰. The bound itself adds one more rounding. In total, this stays below 10ε +
/// 256ε², for ε = 2⁻⁵³.
pub(super) const INCIRCLE_BOUND: f64 = (10.0 + 256.0 * HALF_ULP) * HALF_ULP;

/// The direction in which a path through three points turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Orientation {
    /// To the right.
    Clockwise,
    /// Not at all, or straight back: the points are collinear, or two of them are equal.
    Collinear,
    /// To the left.
    CounterClockwise,
}

impl From<Ordering> for Orientation {
    /// Converts the sign of the determinant to the orientation.
    #[inline]
    fn from(sign: Ordering) -> Self {
        match sign {
            Ordering::Less => Self::Clockwise,
            Ordering::Equal => Self::Collinear,
            Ordering::Greater => Self::CounterClockwise,
        }
    }
}

/// Returns the orientation of the triangle `a`, `b`, `c`. Exact for all valid points.
#[inline]
#[must_use]
pub fn orient2d(a: Point, b: Point, c: Point) -> Orientation {
    let left = (a.x - c.x) * (b.y - c.y);
    let right = (a.y - c.y) * (b.x - c.x);
    let det = left - right;
    let sign = if det.abs() >= (left.abs() + right.abs()) * ORIENT2D_BOUND {
        sign(det)
    } else {
        orient2d_exact(a, b, c)
    };
    sign.into()
}

/// Returns the direction of the turn, by less than a half-turn, from the direction a → b to the
/// direction c → d. The result is `Collinear` if the directions are parallel, whichever way they
/// point, or if one segment has no length. Exact for all valid points.
#[inline]
fn turn([a, b]: [Point; 2], [c, d]: [Point; 2]) -> Orientation {
    let left = (b.x - a.x) * (d.y - c.y);
    let right = (b.y - a.y) * (d.x - c.x);
    let det = left - right;
    // The operations are the same as for three points, so the bound is the same.
    let sign = if det.abs() >= (left.abs() + right.abs()) * ORIENT2D_BOUND {
        sign(det)
    } else {
        turn_exact([a, b], [c, d])
    };
    sign.into()
}

/// Compares the straight lines through two segments: by slope, and parallel lines by the side on
/// which they lie. The segments have a positive length and run in lexicographic direction. Exact
/// for all valid points.
pub(crate) fn compare_lines(one: [Point; 2], other: [Point; 2]) -> Ordering {
    let order = |turn: Orientation| match turn {
        Orientation::CounterClockwise => Ordering::Less,
        Orientation::Collinear => Ordering::Equal,
        Orientation::Clockwise => Ordering::Greater,
    };
    order(turn(one, other)).then_with(|| order(orient2d(one[0], one[1], other[0])))
}

/// Returns where `d` lies relative to the circle through `a`, `b` and `c`, which are
/// counter-clockwise: `Greater` if inside, `Equal` if on it, `Less` if outside. Exact for all valid
/// points.
///
/// In general, this is the sign of the determinant with the rows (pₓ - dₓ, p_y - d_y, |p -
/// d|²), p = a, b, c. So it is reversed if the triangle is clockwise.
#[inline]
#[must_use]
pub fn incircle(a: Point, b: Point, c: Point, d: Point) -> Ordering {
    let (abx, aby) = (a.x - b.x, a.y - b.y);
    let (cbx, cby) = (c.x - b.x, c.y - b.y);
    let (adx, ady) = (a.x - d.x, a.y - d.y);
    let (cdx, cdy) = (c.x - d.x, c.y - d.y);
    let (b1, b2, b3, b4) = (cbx * aby, cby * abx, cbx * abx, cby * aby);
    let (d1, d2, d3, d4) = (adx * cdy, ady * cdx, adx * cdx, ady * cdy);
    let det = -((b1 - b2) * (d3 + d4) + (b3 + b4) * (d1 - d2));
    let magnitude = (b1.abs() + b2.abs()) * (d3.abs() + d4.abs()) + (b3.abs() + b4.abs()) * (d1.abs() + d2.abs());
    if det.abs() >= magnitude * INCIRCLE_BOUND {
        sign(det)
    } else {
        incircle_exact(a, b, c, d)
    }
}

/// Returns whether `d` lies inside the circle through the counter-clockwise `a`, `b` and `c`. Ties
/// are broken by coordinates alone, so that the Delaunay triangulation of a set of points is
/// unique. Exact for all valid points.
///
/// Of four cocircular points, the largest by x, then by y, counts as outside the circle through the
/// others: the diagonal of their quadrilateral avoids it. This is symbolic perturbation. It lifts
/// the points off the paraboloid by vanishing amounts, of which the largest point's vanishes least
/// quickly: Devillers & Teillaud, "Perturbations and vertex removal in a 3D Delaunay
/// triangulation", SODA 2003, and CGAL's `side_of_oriented_circle` with `perturb`.
///
/// A `d` equal to a vertex of the triangle is outside.
#[inline]
#[must_use]
pub fn in_circle(a: Point, b: Point, c: Point, d: Point) -> bool {
    match incircle(a, b, c, d) {
        Ordering::Greater => true,
        Ordering::Less => false,
        Ordering::Equal => in_circle_tie(a, b, c, d),
    }
}

/// Decides a tie by the lift of the largest point alone. The factor of this lift in the determinant
/// is the orientation of the other points, which is that of the triangle with `d` in place of the
/// largest point. It cannot be zero, as no three of four distinct points on a circle are collinear.
#[inline(never)]
fn in_circle_tie(a: Point, b: Point, c: Point, d: Point) -> bool {
    let exceeds = |p: Point, q: Point| p.lex_cmp(q) == Ordering::Greater;
    let orientation = if exceeds(a, b) {
        if exceeds(a, c) {
            exceeds(a, d).then(|| orient2d(d, b, c))
        } else {
            exceeds(c, d).then(|| orient2d(a, b, d))
        }
    } else if exceeds(b, c) {
        exceeds(b, d).then(|| orient2d(a, d, c))
    } else {
        exceeds(c, d).then(|| orient2d(a, b, d))
    };
    orientation == Some(Orientation::CounterClockwise)
}

#[inline]
fn sign(v: f64) -> Ordering {
    if v > 0.0 {
        Ordering::Greater
    } else if v < 0.0 {
        Ordering::Less
    } else {
        Ordering::Equal
    }
}

#[cold]
#[inline(never)]
fn orient2d_exact(a: Point, b: Point, c: Point) -> Ordering {
    if let Some([a, b, c]) = to_integers([a, b, c]) {
        let left = product(a.x - c.x, b.y - c.y);
        return left.cmp(&product(a.y - c.y, b.x - c.x));
    }
    orient2d_expansion(a, b, c)
}

#[cold]
#[inline(never)]
fn turn_exact([a, b]: [Point; 2], [c, d]: [Point; 2]) -> Ordering {
    if let Some([a, b, c, d]) = to_integers([a, b, c, d]) {
        let left = product(b.x - a.x, d.y - c.y);
        return left.cmp(&product(b.y - a.y, d.x - c.x));
    }
    turn_expansion([a, b], [c, d])
}

#[inline(never)]
fn turn_expansion([a, b]: [Point; 2], [c, d]: [Point; 2]) -> Ordering {
    let (one, other) = (Vector::<2>::between(a, b), Vector::<2>::between(c, d));
    one.cross::<8, 16>(&other).sign()
}

#[cold]
#[inline(never)]
fn incircle_exact(a: Point, b: Point, c: Point, d: Point) -> Ordering {
    if let Some([a, b, c, d]) = to_integers([a, b, c, d]) {
        let (abx, aby) = (a.x - b.x, a.y - b.y);
        let (cbx, cby) = (c.x - b.x, c.y - b.y);
        let (adx, ady) = (a.x - d.x, a.y - d.y);
        let (cdx, cdy) = (c.x - d.x, c.y - d.y);
        let cross_b = product(cbx, aby) - product(cby, abx);
        let dot_b = product(cbx, abx) + product(cby, aby);
        let cross_d = product(adx, cdy) - product(ady, cdx);
        let dot_d = product(adx, cdx) + product(ady, cdy);
        return wide_product(-dot_b, cross_d).cmp(&wide_product(cross_b, dot_d));
    }
    incircle_expansion(a, b, c, d)
}

/// A point whose coordinates are multiplied by a power of two.
#[derive(Clone, Copy)]
struct IntegerPoint {
    x: i64,
    y: i64,
}

/// Multiplies all coordinates by one power of two that makes the largest of them an integer of 61
/// bits. Returns `None` unless all of them become integers, exactly. (The factor's exponent is
/// within ±202, so the multiplication is exact.)
#[inline]
fn to_integers<const N: usize>(points: [Point; N]) -> Option<[IntegerPoint; N]> {
    debug_assert!(points.iter().all(|p| p.is_valid()), "outside the limits: {points:?}");
    const BIAS: u64 = 1023;
    // Magnitudes have the same order as their bits. If all were zero, the factor would be larger
    // than the largest number.
    let smallest = Point::MIN_MAGNITUDE.to_bits();
    let largest = points.iter().fold(smallest, |most, p| {
        most.max(p.x.abs().to_bits()).max(p.y.abs().to_bits())
    });
    let factor = f64::from_bits((2 * BIAS + 60 - (largest >> 52)) << 52);
    let mut exact = true;
    let mut integer = |v: f64| {
        let scaled = v * factor;
        #[expect(
            clippy::cast_possible_truncation,
            reason = "it is below 2^61, and a fraction is found out"
        )]
        let integer = scaled as i64;
        #[expect(clippy::cast_precision_loss, reason = "a loss is found out")]
        let same = integer as f64 == scaled;
        exact &= same;
        integer
    };
    let integers = points.map(|p| IntegerPoint {
        x: integer(p.x),
        y: integer(p.y),
    });
    exact.then_some(integers)
}

/// Returns the product of two differences of 62 bits.
#[inline]
fn product(a: i64, b: i64) -> i128 {
    i128::from(a) * i128::from(b)
}

/// Returns the product of two cross or dot products in two's complement, as its high and low half.
/// The factors are below 2¹²⁵ in magnitude.
#[inline]
fn wide_product(a: i128, b: i128) -> (i128, u128) {
    const LOW: u128 = u64::MAX as u128;
    let (u, v) = (a.unsigned_abs(), b.unsigned_abs());
    let middle = (u >> 64) * (v & LOW) + (u & LOW) * (v >> 64);
    let (low, carry) = ((u & LOW) * (v & LOW)).overflowing_add(middle << 64);
    let high = (u >> 64) * (v >> 64) + (middle >> 64) + u128::from(carry);
    let (low, high) = if (a < 0) != (b < 0) {
        let (low, borrow) = 0u128.overflowing_sub(low);
        (low, 0u128.wrapping_sub(high).wrapping_sub(u128::from(borrow)))
    } else {
        (low, high)
    };
    (high.cast_signed(), low)
}

#[inline(never)]
fn orient2d_expansion(a: Point, b: Point, c: Point) -> Ordering {
    orientation_determinant(a, b, c).sign()
}

/// Returns twice the signed area of a triangle, positive if its corners are counter-clockwise, with a
/// relative error below 2⁻⁴⁰.
pub(crate) fn doubled_area(a: Point, b: Point, c: Point) -> f64 {
    /// Below this share of its terms, the difference has lost too many digits.
    const CANCELLED: f64 = 1.0 / 1024.0;
    let (left, right) = ((a.x - c.x) * (b.y - c.y), (a.y - c.y) * (b.x - c.x));
    let difference = left - right;
    if difference.abs() > CANCELLED * (left.abs() + right.abs()) {
        return difference;
    }
    orientation_determinant(a, b, c).estimate()
}

/// Returns the determinant whose sign is the orientation: twice the signed area of the triangle.
pub(super) fn orientation_determinant(a: Point, b: Point, c: Point) -> Expansion<16> {
    let from_c = |p: Point| Vector::<2>::between(c, p);
    from_c(a).cross::<8, 16>(&from_c(b))
}

#[inline(never)]
fn incircle_expansion(a: Point, b: Point, c: Point, d: Point) -> Ordering {
    let [ab, cb] = [a, c].map(|p| Vector::<2>::between(b, p));
    let [ad, cd] = [a, c].map(|p| Vector::<2>::between(d, p));
    let vectors = [ab, cb, ad, cd];
    // If coordinates are close to each other, most differences are exact. These need a sixteenth of
    // the capacity.
    if vectors.iter().all(Vector::is_single) {
        incircle_of_vectors::<1, 2, 4, 8, 32, 64>(&vectors.map(|v| v.shrunk()))
    } else {
        incircle_of_vectors::<2, 8, 16, 32, 512, 1024>(&vectors)
    }
}

/// Computes the last step of incircle for differences of `N` terms. Products of two differences
/// have `P` terms, cross and dot products `C`, scaled ones `S`, products of these `Q`, and the
/// determinant `D`.
fn incircle_of_vectors<
    const N: usize,
    const P: usize,
    const C: usize,
    const S: usize,
    const Q: usize,
    const D: usize,
>(
    [ab, cb, ad, cd]: &[Vector<N>; 4],
) -> Ordering {
    let left = Expansion::<Q>::product::<C, C, S>(&cb.cross::<P, C>(ab), &ad.dot::<P, C>(cd));
    let right = Expansion::<Q>::product::<C, C, S>(&cb.dot::<P, C>(ab), &ad.cross::<P, C>(cd));
    Expansion::<D>::sum(&left, &right).sign().reverse()
}

/// The exact difference of two points, each coordinate an expansion of at most `N` terms.
#[derive(Clone, Copy)]
struct Vector<const N: usize> {
    x: Expansion<N>,
    y: Expansion<N>,
}

impl<const N: usize> Vector<N> {
    fn between(from: Point, to: Point) -> Self {
        Self {
            x: Expansion::difference(to.x, from.x),
            y: Expansion::difference(to.y, from.y),
        }
    }

    /// Returns whether each coordinate is a single term, so that the difference had no rounding
    /// error.
    fn is_single(&self) -> bool {
        self.x.len() <= 1 && self.y.len() <= 1
    }

    fn shrunk<const M: usize>(&self) -> Vector<M> {
        Vector {
            x: self.x.shrunk(),
            y: self.y.shrunk(),
        }
    }

    fn cross<const P: usize, const C: usize>(&self, other: &Self) -> Expansion<C> {
        let left = Expansion::<P>::product::<N, N, P>(&self.x, &other.y);
        let right = Expansion::<P>::product::<N, N, P>(&self.y, &other.x);
        Expansion::sum(&left, &right.negated())
    }

    fn dot<const P: usize, const C: usize>(&self, other: &Self) -> Expansion<C> {
        let left = Expansion::<P>::product::<N, N, P>(&self.x, &other.x);
        let right = Expansion::<P>::product::<N, N, P>(&self.y, &other.y);
        Expansion::sum(&left, &right)
    }
}

#[cfg(test)]
mod tests;
