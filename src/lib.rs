//! Delaunay triangulations larger than memory, kept as tiles in one file.

pub mod build;
pub mod export;
pub mod geometry;
pub mod input;
pub mod io;
pub mod mesh;
pub mod query;
pub mod store;
