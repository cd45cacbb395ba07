//! A certificate that the circumdisc of a triangle lies inside a cell.
//!
//! One-sided: it costs a little work to miss a disc that is inside, and corrupts the mesh to certify one that is not.
//! So this is floating point with an error bound, and whatever is uncertain is not certified.
//!
//! # Error bound
//!
//! Take vertex `a` as origin, with u = b - a, v = c - a, w = c - b. With
//!
//! ```text
//! d = 2 (uₓ v_y - u_y vₓ)     x = v_y u² - u_y v²     y = uₓ v² - vₓ u²     n = |u| |v| |w|
//! ```
//!
//! the centre is (x, y) / d and the radius n / d. As d > 0, the closed disc lies strictly left of a vertical line at
//! distance g to the right of `a` if and only if x + n < g d; the other three sides are alike. No division is needed.
//!
//! Let ε = 2⁻⁵³. As the error analysis counts roundings, k of them are a relative error of k ε and terms in ε², which
//! the whole numbers below absorb. A hat marks what is computed.
//!
//! - Differences pass 1 rounding, squared lengths 4 (two differences, a product, a sum, all terms positive).
//! - x: each of its two products passes 6 roundings, the difference is the 7th, so |x̂ - x| ≤ 7.1 ε s, where s is the
//!   computed sum of the magnitudes of the two products. The same holds for y.
//! - n̂ = √(u² v²) √(w²) passes (4 + 4 + 1) / 2 + 1, then 4 / 2 + 1, then 1: n ≤ n̂ (1 + 9.6 ε).
//! - x̂ + n̂ + 16 ε (s + n̂): the two sums add errors of at most 1.1 ε (s + n̂) each, in all 9.3 ε s + 11.8 ε n̂. So
//!   this is at least x + n, and hence never negative.
//! - d: with t the computed sum of the magnitudes of its two products, |d̂ - d| ≤ 4.1 ε t, and d̂ ≤ 1.1 t. So for the
//!   computed d̂ - 16 ε t, if it is positive, (1 + ε)⁴ (d̂ - 16 ε t) ≤ d, which leaves room for the rounding of it,
//!   of ĝ, and of their product.
//!
//! So if x̂ + n̂ + 16 ε (s + n̂) < ĝ (d̂ - 16 ε t) as computed, then x + n < g d.
//!
//! Underflow: coordinates being within the limits of [`Point::is_valid`], differences are multiples of 2⁻¹⁹⁴ (see
//! [`predicates`](crate::geometry::predicates)), so products of two are multiples of 2⁻³⁸⁸ and of three of 2⁻⁵⁸², n is at least
//! 2⁻⁵⁸² if it is not zero, and the slack at least 2⁻⁶³²; none is near 2⁻¹⁰²². The product with ĝ may underflow, as the
//! sides of the cell are arbitrary, but not if it is greater than the slack. Overflow: x, y and n are below 2⁶⁰⁷, n² is
//! never formed, and an infinite ĝ ends in a comparison that is true if the left side is finite, which is intended.

use crate::geometry::point::{Point, Rect};

/// 16 ε, the bound derived above.
const SLACK: f64 = 8.0 * f64::EPSILON;

/// Whether the closed circumdisc of the counter-clockwise triangle `a`, `b`, `c` certainly lies strictly inside the
/// open rectangle `cell`, whose sides may be at infinity. The whole plane contains every disc.
///
/// False if the disc is not inside, and also if it is nearly touching, if the triangle is not certainly
/// counter-clockwise, or if a number is NaN or too large. Never true if the disc, as exact arithmetic has it, touches
/// or passes a side. The points must be [valid](Point::is_valid) or have a coordinate that is not finite.
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

    // Every comparison is false if a side of it is NaN, and `&` spares branches that cannot be foretold.
    (d > 0.0)
        & ((n + x) + x_slack < (cell.max_x - a.x) * d)
        & ((n - x) + x_slack < (a.x - cell.min_x) * d)
        & ((n + y) + y_slack < (cell.max_y - a.y) * d)
        & ((n - y) + y_slack < (a.y - cell.min_y) * d)
}

#[cfg(test)]
mod tests;
