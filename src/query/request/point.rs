//! Coordinates that someone asks for, as the exact predicates can take them.

use crate::geometry::Point;

/// A coordinate that someone asks for, as the exact predicates can take it: what is closer to 0 than any coordinate of a
/// triangulation can be counts as 0. What is too large is outside anyway.
pub(crate) fn representable(v: f64) -> f64 {
    if v.abs() < Point::MIN_MAGNITUDE { 0.0 } else { v }
}

/// A point that someone asks for, likewise.
pub(crate) fn target(point: Point) -> Point {
    Point::new(representable(point.x), representable(point.y)).normalized()
}
