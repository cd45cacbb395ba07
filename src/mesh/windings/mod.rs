//! The windings of a polygon beside its edges: how many times it covers what lies there.

mod status;
pub(crate) mod sweep;
