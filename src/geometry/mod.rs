//! Points, rectangles, exact predicates with the tie rule, and the circumdisc certificate.
//!
//! Knows nothing of the rest of the crate.

mod circumdisc;
mod expansion;
mod morton;
#[cfg(test)]
mod oracle;
mod point;
mod predicates;

pub use circumdisc::disc_strictly_inside;
pub(crate) use morton::MortonSquare;
pub use point::{Point, Rect};
pub use predicates::{Orientation, in_circle, incircle, orient2d};
