//! The data written to disk while the build runs: extents in leaf order, finished blocks, and the
//! border log.

pub(super) mod border_log;
mod by_tile;
pub(super) mod in_parts;
pub(super) mod ordered;
pub(super) mod writer;
