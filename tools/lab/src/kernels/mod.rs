//! The library's in-core kernel and other triangulators: the evidence for the choice of divide and
//! conquer.
//!
//! The README of this crate has the results. [`Contender`] runs one triangulator on an [`Input`];
//! the bench `triangulate` and the binary `kernel-table` measure with it. [`incremental`] is the
//! kernel that was not chosen.

mod contender;
mod hilbert;
pub mod incremental;

pub use contender::{Contender, Input, KINDS, Outcome, Peer};
