//! The compiled part of the Python package `delaunay_tiles`: the module `delaunay_tiles._core`.
//!
//! In: numpy arrays, Arrow streams, names of files. Out: tuples of numpy arrays, Arrow streams, and
//! text. The Python part (`python/delaunay_tiles`) has the public classes and their documentation; it
//! checks and converts arguments, and gives the answers names.
//!
//! ```text
//!   build             Builder: points, lines and sites from arrays, tables and files
//!   editor            Editor: a file that is locked for edits
//!   edit              Transaction: changes of a file
//!   reader            Reader: a file, its metadata and its verification
//!     ▲
//!     ├── elements    tiles as arrays, and where points lie
//!     ├── tables      triangles, vertices and edges as Arrow streams
//!     ├── surface     heights, rasters, contours, profiles, volumes
//!     ├── proximity   sites, paths and distances
//!     └── outputs     exports and maps
//!   mesh              triangulations in memory
//!   tool              the command
//!
//!   columns, views    answers as numpy arrays, and memory that Python reads without a copy
//!   runtime, error    waiting with Ctrl-C, asyncio, forks; Python's exceptions
//! ```
#![allow(missing_docs, reason = "the Python part documents what is public")]

mod build;
mod columns;
mod edit;
mod editor;
mod elements;
mod error;
mod mesh;
mod outputs;
mod proximity;
mod reader;
mod runtime;
mod surface;
mod tables;
mod tool;
mod views;

use pyo3::prelude::*;

/// The compiled part of `delaunay_tiles`.
#[pymodule]
mod _core {
    #[pymodule_export]
    use super::build::{Builder, conquer, distribute, identity};

    #[pymodule_export]
    use super::edit::Transaction;

    #[pymodule_export]
    use super::editor::Editor;

    #[pymodule_export]
    use super::elements::Tile;

    #[pymodule_export]
    use super::mesh::triangulate;

    #[pymodule_export]
    use super::proximity::{
        along::along,
        area::{in_polygons, reach},
        distances::{edge_distances, matrix},
        euclidean::nearest,
        footing::footing,
        paths::paths,
        sites::{nearest_sites, sites_within},
    };

    #[pymodule_export]
    use super::reader::{Cache, Reader, open};

    #[pymodule_export]
    use super::runtime::in_child_of_fork;

    #[pymodule_export]
    use super::tool::tiletool;

    #[pymodule_export]
    #[allow(non_upper_case_globals, reason = "Python's name")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
