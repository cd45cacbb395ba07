//! Lines, polygons and hole points before they become edges. Builds and edits share this module.
//!
//! In: segments as they come from the input. Out: all segments, spooled; their crossings, and the
//! subsegments that they are split into; the polygons that are inside out; the positions of hole
//! points.

pub(crate) mod crossings;
pub(crate) mod error;
pub(crate) mod polygons;
pub(crate) mod seeds;
pub(crate) mod segment;
pub(crate) mod segments;
pub(crate) mod split_lines;
pub(crate) mod without_z;

pub use crate::input::MissingZ;
pub use crossings::first::Crossing;
pub use error::{ConstraintError, SplitError};
pub use polygons::check::{Inverted, InvertedPolygons, Overlapping, PolygonCheck, PolygonFaults};
pub use polygons::normalize::PolygonNormalizer;
pub use split_lines::{LinesToSplit, SplitLines};
pub use without_z::{VertexWithoutZ, WithoutZ};
