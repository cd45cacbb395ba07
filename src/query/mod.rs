//! Questions to a triangulation on disk.
//!
//! A query is a state machine without I/O that asks for tiles; a thin async driver feeds it through the cache.

mod locate;
mod star;
mod triangles_in;

pub use locate::{Location, TriangleRef};
