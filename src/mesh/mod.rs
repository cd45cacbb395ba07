//! In-core Delaunay triangulation: flat arrays, the engines that fill them, and constraints.
//!
//! Input: distinct points. Output: a [`Triangulation`] that is canonical, that is, a function of
//! the set of points alone; or a [`Constrained`] mesh, a function of points and segments. The
//! pipeline in [`crate::pipeline`] runs an engine on every leaf and on every seam of the merge
//! tree. This module does no I/O.

mod boundary;
mod cavity;
mod chain;
mod constrained;
mod divide_conquer;
mod engine;
mod engine_kind;
mod inserter;
mod leaving;
pub(crate) mod point_table;
#[cfg(feature = "spade")]
mod spade_engine;
mod topology;
mod triangulation;
mod walk;
pub(crate) mod windings;

pub(crate) use cavity::Cavity;
pub use constrained::Constrained;
pub(crate) use constrained::WALLS;
pub use engine::Engine;
pub use engine_kind::{EngineKind, UnknownEngine};
pub(crate) use inserter::LineStep;
pub use inserter::{Crossing, Inserter};
pub(crate) use leaving::Stars;
pub use topology::{Embedded, Star, StarEnd, StarError, Topology, Twin};
pub(crate) use triangulation::smallest_first;
pub use triangulation::{Mesh, Triangulation};
pub use walk::{EndlessWalk, Walk, WalkEnd};

// Needed until its last users take `HalfEdge`.
pub(crate) const NONE: u32 = u32::MAX;

#[cfg(test)]
mod tests;
