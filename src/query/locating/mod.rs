//! Point location, and the triangles in a rectangle.

mod locate;
mod location;
mod triangles_in;
mod walk;

pub use location::{Location, TriangleRef};
pub(crate) use walk::Walked;
