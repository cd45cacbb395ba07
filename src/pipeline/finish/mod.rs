//! The phase after the root: finds the regions and assembles the borders in leaf order.

pub(crate) mod border;
mod border_mesh;
pub(super) mod borders;
mod regions;
