//! Delaunay triangulations larger than memory, kept as tiles in one file.

pub mod geometry;
pub mod input;
