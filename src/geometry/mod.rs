//! Points, rectangles, exact predicates with the tie rule, and the circumdisc certificate.
//!
//! Knows nothing of the rest of the crate.

mod point;

pub use point::{Point, Rect};
