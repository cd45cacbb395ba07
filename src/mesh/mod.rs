//! In-core Delaunay triangulation: flat arrays, the engines that fill them, and constraints.
//!
//! Comes in: distinct points. Goes out: a [`Triangulation`] that is canonical, that is, a function of the set of
//! points alone; or [`Constrained`], a function of points and segments. The pipeline in [`crate::pipeline`] runs an engine on every leaf and on every seam of the merge tree.
//! Knows no files.

mod boundary;
mod cavity;
mod constrained;
mod divide_conquer;
mod engine;
#[cfg(feature = "spade")]
mod spade_engine;
mod topology;
mod triangulation;
pub(crate) mod vertex_index;

pub(crate) use cavity::Cavity;
pub use constrained::{Constrained, Crossing, Inserter};
pub(crate) use constrained::{Stars, Step, WALLS};
pub use engine::{Engine, EngineKind, UnknownEngine};
pub use topology::{Topology, Twin};
pub(crate) use triangulation::smallest_first;
pub use triangulation::{NONE, Triangulation, next_side, prev_side};

#[cfg(test)]
mod tests;
