//! A certificate that the circumdisc of a triangle lies inside a cell.
//!
//! The certificate is one-sided: to miss a disc that is inside costs a little work, but to certify
//! one that is not inside corrupts the mesh. So the test uses floating point with an error bound,
//! and does not certify uncertain cases.
//!
//! # Error bound
//!
//! Take vertex `a` as origin, with u = b - a, v = c - a, w = c - b. With
//!
//! ```text
//! d = 2 (uₓ v_y - u_y vₓ)     n = |u| |v| |w|
//! x = v_y u² - u_y v²         y = uₓ v² - vₓ u²
//! ```
//!
//! the centre is (x, y) / d and the radius n / d. As d > 0, the closed disc lies strictly left of a
//! vertical line at distance g to the right of `a` if and only if x + n < g d. The other three
//! sides are alike. No division is needed.
//!
//! Let ε = 2⁻⁵³. The error analysis counts roundings: k of them are a relative error of k ε
//! and terms in ε². The whole numbers below absorb these terms. A hat marks a computed value.
//!
//! - Differences pass 1 rounding, squared lengths 4 (two differences, a product, a sum, all terms
//!   positive).
//! - x: each of its two products passes 6 roundings, the difference is the 7th, so |x̂ - x| ≤
//!   7.1 ε s, where s is the computed sum of the magnitudes of the two products. The same holds
//!   for y.
//! - n̂ = √(u² v²) √(w²) passes (4 + 4 + 1) / 2 + 1, then 4 / 2 + 1, then 1: n ≤ n̂ (1 +
//!   9.6 ε).
//! - x̂ + n̂ + 16 ε (s + n̂): the two sums add errors of at most 1.1 ε (s + n̂) each, in all
//!   9.3 ε s + 11.8 ε n̂. So this is at least x + n, and hence never negative.
//! - d: with t the computed sum of the magnitudes of its two products, |d̂ - d| ≤ 4.1 ε t, and
//!   d̂ ≤ 1.1 t. So if the computed d̂ - 16 ε t is positive, (1 + ε)⁴ (d̂ - 16 ε t) ≤
//!   d. This leaves room for the rounding of d̂ - 16 ε t, of ĝ, and of their product.
//!
//! So if x̂ + n̂ + 16 ε (s + n̂) < ĝ (d̂ - 16 ε t) as computed, then x + n < g d.
//!
//! Underflow: coordinates are within the limits of [`Point::is_valid`], so differences are
//! multiples of 2⁻¹⁹⁴ (see [`predicates`](crate::geometry::predicates)), products of two are
//! multiples of 2⁻³⁸⁸, and products of three are multiples of 2⁻⁵⁸². n is zero or at
//! least 2⁻⁵⁸², and the slack is zero or at least 2⁻⁶³². None of these is near
//! 2⁻¹⁰²². The product with ĝ may underflow, as the sides of the cell are arbitrary, but
//! not if it is greater than the slack.
//!
//! Overflow: x, y and n are below 2⁶⁰⁷, and n² is never computed. An infinite ĝ ends in a
//! comparison that is true if the left side is finite, which is intended.

use crate::geometry::point::{Point, Rect};

/// 16 ε, the bound derived above.
const SLACK: f64 = 8.0 * f64::EPSILON;

/// Returns whether the closed circumdisc of the counter-clockwise triangle `a`, `b`, `c` certainly
/// lies strictly inside the open rectangle `cell`. The sides of `cell` may be at infinity. The
/// whole plane contains every disc.
///
/// The result is false if the disc is not inside, and also if the disc nearly touches a side, if
/// the triangle is not certainly counter-clockwise, or if a number is NaN or too large. It is never
/// true if the exact disc touches or passes a side. The points must be [valid](Point::is_valid) or
/// have a coordinate that is not finite.
#[inline]
#[must_use]
pub fn disc_strictly_inside(a: Point, b: Point, c: Point, cell: Rect) -> bool {
    if cell == Rect::PLANE {
        return true;
    }
    let (ux, uy) = (b.x - a.x, b.y - a.y);
    let (vx, vy) = (c.x - a.x, c.y - a.y);
    let (wx, wy) = (c.x - b.x, c.y - b.y);
    let (uu, vv, ww) = (ux * ux + uy * uy, vx * vx + vy * vy, wx * wx + wy * wy);

    let (left, right) = (ux * vy, uy * vx);
    let d = 2.0 * ((left - right) - SLACK * (left.abs() + right.abs()));
    let n = (uu * vv).sqrt() * ww.sqrt();
    let (x_left, x_right) = (vy * uu, uy * vv);
    let (y_left, y_right) = (ux * vv, vx * uu);
    let (x, y) = (x_left - x_right, y_left - y_right);
    let x_slack = SLACK * (x_left.abs() + x_right.abs() + n);
    let y_slack = SLACK * (y_left.abs() + y_right.abs() + n);

    // A comparison with a NaN is false, and `&` avoids unpredictable branches.
    (d > 0.0)
        & ((n + x) + x_slack < (cell.max_x - a.x) * d)
        & ((n - x) + x_slack < (a.x - cell.min_x) * d)
        & ((n + y) + y_slack < (cell.max_y - a.y) * d)
        & ((n - y) + y_slack < (a.y - cell.min_y) * d)
}

#[cfg(test)]
mod tests;
