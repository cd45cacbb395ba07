//! Divide, conquer, merge, constrain: threads take tasks from a board and produce triangles.

pub(crate) mod components;
pub(super) mod conquest;
pub(super) mod conquest_state;
pub(super) mod constrain;
mod core_digest;
mod crossings;
pub(super) mod deferral;
mod dividing;
mod growth;
pub(super) mod leaf;
mod merge;
mod node;
pub(super) mod prefetch;
pub(super) mod schedule;
