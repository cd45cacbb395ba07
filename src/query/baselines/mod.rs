//! Other ways to the same answers: the method of Wu's thesis, and those that it compares with; and what each of them costs.
//!
//! ```text
//!   answers     by any of them
//!     │
//!   visibility ──▶ edges      sites and obstacle edges by CDT distance          (Wu 2004)
//!   zhang ───────▶ nearby     by Euclidean distance, in a disc that grows       (Zhang, Papadias, Mouratidis, Zhu, EDBT 2004)
//!   xia ─────────▶ nearby     those that provisional paths run into             (Xia, Hsu, Tung, BNCOD 2004)
//!     │
//!     └──▶ local ──▶ graph     what all of them ask of the few edges that they have
//! ```
//!
//! Each finds sites, and obstacle edges that paths to them may have to go round, and then shortest paths among these. They are here
//! to be measured against the wavefront, which needs none of it. All of them refuse files with break lines.

mod answers;
mod asked;
mod graph;
mod local;
mod nearby;
mod obstacles;
mod statistics;
mod stretch;
#[cfg(test)]
mod tests;
mod visibility;
mod wave;
mod xia;
mod zhang;

pub use answers::Method;
pub use statistics::{Measured, Statistics, StepTime};
pub use stretch::{LosesAnswers, Stretch};
