//! Points, sites and lines arrive. They stay in memory as long as they fit, else go to runs on
//! disk.

pub(super) mod batch;
pub(super) mod drape;
pub(super) mod intake;
pub(super) mod missing_z;
pub(crate) mod point_store;
pub(crate) mod ponds;
pub(super) mod sites;
pub(super) mod spill;
