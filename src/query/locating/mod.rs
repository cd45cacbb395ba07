//! Where points lie, and which triangles lie where.

mod locate;
mod location;
mod triangles_in;
mod walk;

pub use location::{Location, TriangleRef};
pub(crate) use walk::Walked;
