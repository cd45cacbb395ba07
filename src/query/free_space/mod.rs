//! The free space: which edges block, the sectors round vertices, and the points where queries
//! start and end.
//!
//! Walls *block*, and so do the edges that separate free triangles from holes.

mod footing;
mod marks;
mod nearest_free;
mod passages;
mod position;
mod query_point;
mod sight;
mod space;
mod wedges;

pub use footing::Footing;
pub(crate) use marks::Mark;
#[cfg(feature = "baselines")]
pub(crate) use nearest_free::nearest_on;
pub(crate) use passages::{Passage, Passages};
pub(crate) use position::Position;
pub(crate) use query_point::QueryPoint;
pub(crate) use space::{FreeSpace, FreeTwin};
pub(crate) use wedges::Wedge;
