//! Other methods for the same answers: that of Wu's thesis and those that the thesis compares with,
//! with the cost of each.
//!
//! ```text
//!   answers     by any method
//!     │
//!   visibility ──▶ edges     sites and obstacle edges by CDT distance     (Wu 2004)
//!   zhang ───────▶ nearby    by Euclidean distance, in a growing disc     (Zhang et al. 2004)
//!   xia ─────────▶ nearby    those that provisional paths cross           (Xia et al. 2004)
//!     │
//!     └──▶ local ──▶ graph   the local visibility graph that all of them use
//! ```
//!
//! Zhang et al. are Zhang, Papadias, Mouratidis and Zhu (EDBT 2004); Xia et al. are Xia, Hsu and
//! Tung (BNCOD 2004).
//!
//! Each method finds sites, and the obstacle edges that paths to them may have to pass round, and
//! then shortest paths among these. They are here for comparison with the wavefront, which needs
//! none of this. All of them refuse files with break lines.

mod answers;
mod context;
mod graph;
mod local;
mod nearby;
mod obstacles;
mod statistics;
mod stretch;
#[cfg(test)]
mod tests;
mod visibility;
mod wavefront;
mod xia;
mod zhang;

pub use answers::Method;
pub use statistics::{Measured, Statistics, StepTime};
pub use stretch::{LosesAnswers, Stretch};
