//! Point location, one point or many at once, and the triangles in a rectangle.

mod at_spot;
mod batch;
#[cfg(feature = "map-tiles")]
mod ground_many;
mod locate;
mod locate_many;
mod location;
mod on_surface;
mod place;
mod sorted_walk;
mod triangles_in;
mod walk;
mod z_many;

pub use batch::BulkOptions;
#[cfg(feature = "map-tiles")]
pub(crate) use ground_many::Ground;
pub use location::{Location, TriangleRef};
pub(crate) use on_surface::{OnSurface, SurfacePart};
pub use place::Place;
pub use triangles_in::triangle_meets;
pub(crate) use walk::Walked;
