//! Verifies tile files.
//!
//! [`TileReader::verify`] reads every tile once and checks checksums, ranges and adjacency. A deep
//! check proves the triangulation. Its memory grows with the number of tiles only. It checks that
//!
//! - each triangle is counter-clockwise, and the circle of each edge that is no constraint is
//!   empty, with ties broken by the rule;
//! - both half-edges of an edge agree on whether it is a constraint;
//! - around each vertex the triangles close once, or form a fan of at most a half-turn on the hull;
//! - the hull, which turns left everywhere, goes round once: it has a single lexicographic minimum;
//! - the counts, the bounds and the digest in the directory are those of the tiles;
//! - a point of the input, a site or an end of a segment is at each vertex, unless lines were split,
//!   and lines go on where they pass a vertex;
//! - constraints have sources and change the depth accordingly, regions end at constraints only,
//!   and each hole has a reason, if the file has regions;
//! - the component tables say what their components are and which share triangles;
//! - each polygon covers each point 0 or 1 times, if the file lists its lines;
//! - each triangle is stored in all tiles of its vertices, and is the same in each: for each pair
//!   of tiles, the hashes of the triangles that one tile owns and the other shares cancel out.
//!
//! Triangles that fit together around every vertex cover the plane like a sheet without folds. A
//! closed convex curve bounds the sheet and is passed once, so the sheet is flat: the file is a
//! triangulation of the convex hull. By the circle checks, it is the unique constrained Delaunay
//! triangulation.
//!
//! [`TileReader::verify_points`], [`TileReader::verify_lines`] and [`TileReader::verify_sites`]
//! compare a file with its input.

mod components;
mod edge_entry;
mod error;
mod held;
mod line;
mod lines;
mod points;
mod polygons;
mod regions;
mod shared_vertices;
mod sites;
mod star;
#[cfg(test)]
mod tests;
mod tile;
mod tile_bits;
mod whole;

pub use error::{VerifyError, VerifyReport};
pub use lines::LineBatch;
pub use points::PointOrigin;
