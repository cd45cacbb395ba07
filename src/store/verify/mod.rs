//! Proves that a file is what it claims to be.
//!
//! [`TileReader::verify`] reads every tile once: checksums, ranges, adjacency. A deep check proves the triangulation in
//! memory that grows with the number of tiles only:
//!
//! - each triangle is counter-clockwise, and the circle of each edge that is no constraint is empty, ties broken by the rule;
//! - both sides of an edge say the same about whether it is a constraint;
//! - around each vertex the triangles close once, or make a fan of at most a half-turn on the hull;
//! - the hull, which turns left everywhere, goes round once: it has a single lexicographic minimum;
//! - counts and bounds of the directory are those of the tiles;
//! - constraints have sources, which change the depth as they say; regions end at constraints only, and holes are holes for a
//!   reason, where the file knows of any;
//! - each triangle stands in all tiles of its vertices, and is the same there: for each pair of tiles the hashes of
//!   the triangles that the one owns and the other shares cancel.
//!
//! Triangles that fit round every vertex cover the plane like a sheet without folds, a closed convex curve round it is
//! passed once, so the sheet lies flat: the file is a triangulation of the convex hull, and by the circles the one
//! constrained Delaunay triangulation.
//!
//! [`TileReader::verify_points`], [`TileReader::verify_lines`] and [`TileReader::verify_sites`] compare it with its input.

mod error;
mod line;
mod lines;
mod marks;
mod points;
mod regions;
mod sites;
mod star;
#[cfg(test)]
mod tests;
mod tile;
mod whole;

pub use error::{VerifyError, VerifyReport};
pub use lines::LineBatch;
