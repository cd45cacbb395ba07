//! Lengths, and their rounding errors.

use crate::geometry::{Point, Rect};

/// Returns the distance between two points. Its error is below two units in the last place.
#[inline]
pub(crate) fn distance(a: Point, b: Point) -> f64 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    (dx * dx + dy * dy).sqrt()
}

/// Returns a distance of a rectangle that, even with rounding, is not above the computed distance
/// of any point in it.
pub(crate) fn distance_to_rect(at: Point, rect: Rect) -> f64 {
    let gap = |v: f64, min: f64, max: f64| (min - v).max(v - max).max(0.0);
    let (dx, dy) = (gap(at.x, rect.min_x, rect.max_x), gap(at.y, rect.min_y, rect.max_y));
    (dx * dx + dy * dy).sqrt()
}

/// A length, with bounds of the true length.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Distance {
    /// The best estimate.
    pub value: f64,
    /// A lower bound of the true length.
    pub lower: f64,
    /// An upper bound of the true length.
    pub upper: f64,
}

impl Distance {
    /// Returns a distance that the wavefront found, as the sum of `legs` straight legs.
    ///
    /// The error of a leg's length is at most two units in the last place, and each leg adds at
    /// most half a unit to the error of the sum. At each bend, the search may have chosen any of
    /// the paths whose lengths differ by less than that.
    pub(crate) fn of_legs(value: f64, legs: usize) -> Self {
        let error = 8.0 * f64::EPSILON * (legs as f64 + 1.0);
        Self {
            value,
            lower: value * (1.0 - error),
            upper: value * (1.0 + error),
        }
    }
}
