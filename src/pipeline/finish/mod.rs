//! The phase after the root: finds the regions, assembles the borders in leaf order, and
//! counts the sites in holes.

pub(crate) mod border;
mod border_mesh;
pub(super) mod borders;
mod component_records;
pub(super) mod enclosed_sites;
mod regions;
mod tile_components;
