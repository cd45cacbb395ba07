//! Lines, polygons and hole points, before they are edges: what builds and edits share.
//!
//! In: segments as they come from the input. Out: all of them, spooled; where they cross, and the pieces that they are split
//! into; which polygons are inside out; where hole points lie.

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
pub use polygons::check::{Inverted, InvertedPolygons, PolygonCheck, PolygonFaults};
pub use split_lines::{LinesToSplit, SplitLines};
pub use without_z::{VertexWithoutZ, WithoutZ};
