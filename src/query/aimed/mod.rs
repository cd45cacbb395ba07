//! Searches that aim: exact distances from one point to many targets, by wavefronts that are
//! directed towards groups of targets.
//!
//! A wavefront to all targets passes every triangle up to the farthest one. A wavefront to one
//! target passes those near an ellipse round the two points, which is much less, but there are as
//! many ellipses as targets, and they overlap. Between the two are wavefronts to groups of targets
//! that are near each other. Targets are in a k-d tree ([`tree`]), and the groups are the nodes
//! of the tree for which the expected work is least ([`cost`]). Which groups there are decides
//! about the time only.
//!
//! The expectation may be wrong: in a labyrinth, each wavefront passes all of it. So the detour is
//! measured on the way, and if a group takes far more work than expected, all targets that are left
//! are one group ([`run`]).
//!
//! Zhao, Taniar and Harabor, "Fast k-nearest neighbor on a navigation mesh" (SoCS 2018), compare a
//! wavefront to all targets with one for each target in the order of their Euclidean distances; the
//! groups are the middle way.

mod cost;
mod run;
mod tree;

pub(crate) use cost::{Expectation, passes};
pub(crate) use run::AimedRun;
pub(crate) use tree::Targets;
