//! GeoPackage: feature tables in an SQLite database. Source: OGC 12-128r18, version 1.3.1.
//!
//! SQLite reads the database (crate `rusqlite`, with SQLite compiled in), read-only and without
//! creating any file beside it; the crate `wkb` decodes geometries. Views are refused, and the
//! schema of the file is not trusted, so that a file cannot make SQLite compute.
//!
//! **Memory**: SQLite's page cache of 2 MiB, and a few features, at least one.

mod database;
mod geometry;
mod layers;
mod reader;

pub use layers::ListedLayer;
pub use reader::{list, no_stream, open, open_layer};
