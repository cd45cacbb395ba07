//! Points, rectangles, exact predicates with the tie rule, and the circumdisc certificate.
//!
//! This module does not depend on the rest of the crate.

mod area;
mod chord;
mod circumdisc;
mod crossing;
mod expansion;
mod half_edge;
mod ids;
mod morton;
#[cfg(test)]
mod oracle;
mod point;
mod predicates;

pub use area::area_sign;
pub(crate) use chord::{BoxFilter, Chord, View};
pub use circumdisc::disc_strictly_inside;
pub(crate) use crossing::{ExactCrossing, cross_outside, segment_meets};
pub use crossing::{crossing_point, segments_cross};
pub use half_edge::{HalfEdge, PackedHalfEdge};
pub use ids::{TriangleId, VertexIndex};
pub(crate) use morton::MortonSquare;
pub use morton::curve_order;
pub use point::{Point, Rect};
pub use predicates::{Orientation, in_circle, incircle, orient2d};
pub(crate) use predicates::{compare_lines, doubled_area};
