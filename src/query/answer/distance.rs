//! Lengths, and what rounding makes of them.

use crate::geometry::{Point, Rect};

/// The distance between two points. Its error is below two units in the last place.
#[inline]
pub(crate) fn distance(a: Point, b: Point) -> f64 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    (dx * dx + dy * dy).sqrt()
}

/// How far a rectangle is, computed so that rounding makes it no farther than any point in it.
pub(crate) fn distance_to_rect(at: Point, rect: Rect) -> f64 {
    let gap = |v: f64, min: f64, max: f64| (min - v).max(v - max).max(0.0);
    let (dx, dy) = (gap(at.x, rect.min_x, rect.max_x), gap(at.y, rect.min_y, rect.max_y));
    (dx * dx + dy * dy).sqrt()
}

/// A length, with bounds of the true one.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Distance {
    /// The best guess.
    pub value: f64,
    /// The true one is not less.
    pub lower: f64,
    /// The true one is not more.
    pub upper: f64,
}

impl Distance {
    /// A distance that the wave found, over so many straight legs.
    ///
    /// A leg's length is wrong by two units in the last place at most, and a sum by half a unit more for each leg. Of ways that
    /// differ by less than that, any may have been taken, for each of its bends.
    pub(crate) fn of_legs(value: f64, legs: usize) -> Self {
        let error = 8.0 * f64::EPSILON * (legs as f64 + 1.0);
        Self {
            value,
            lower: value * (1.0 - error),
            upper: value * (1.0 + error),
        }
    }
}
