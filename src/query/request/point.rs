//! Coordinates of queries, adapted to the exact predicates.

use crate::geometry::Point;

/// Returns a coordinate of a query as the exact predicates can take it. It is 0 if it is closer to
/// 0 than any coordinate of a triangulation can be. Coordinates that are too large need no change,
/// because they are outside anyway.
pub(crate) fn representable(v: f64) -> f64 {
    if v.abs() < Point::MIN_MAGNITUDE { 0.0 } else { v }
}

/// Returns a point of a query as the exact predicates can take it.
pub(crate) fn target(point: Point) -> Point {
    Point::new(representable(point.x), representable(point.y)).normalized()
}
