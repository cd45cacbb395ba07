//! Questions to a triangulation on disk.
//!
//! A query is a state machine without I/O that asks for tiles; a thin async driver feeds it through the cache.

mod locate;
mod star;
mod triangles_in;

pub use locate::{Location, TriangleRef};

use crate::geometry::Point;

/// A coordinate that someone asks for, as the exact predicates can take it: what is closer to 0 than any coordinate of a
/// triangulation can be counts as 0. What is too large is outside anyway.
fn representable(v: f64) -> f64 {
    if v.abs() < Point::MIN_MAGNITUDE { 0.0 } else { v }
}
