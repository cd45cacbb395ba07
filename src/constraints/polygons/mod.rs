//! Each polygon by itself: where its rings run in the wrong direction, and where it covers a place
//! more than once.
//!
//! ```text
//!   segments as they arrive    ──▶ arrivals ──▶ check ──▶ polygons that are inside out: an error
//!                                                 │
//!                                                 └─▶ normalize ──▶ segments that cover 0 or 1
//!   subsegments after a split  ──▶ repair ──▶ subsegments that cover what rings enclose, once
//! ```
//!
//! An *obstacle* is a polygon, or several ones with the same line: a record with a MultiPolygon. It
//! covers what any of its polygons covers. Its rings may be lines of their own; then `lines` finds
//! which belong together.

pub(crate) mod arrivals;
pub(crate) mod check;
pub(crate) mod counter;
pub(crate) mod lines;
pub(crate) mod normalize;
mod pile;
pub(crate) mod repair;
mod segment_ends;
