//! After the root: regions are told apart, and borders put together in leaf order.

pub(crate) mod border;
mod border_mesh;
pub(super) mod borders;
mod regions;
