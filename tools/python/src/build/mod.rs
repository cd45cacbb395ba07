//! Builds: points, lines and sites from arrays, Arrow streams and files, passed to the library's
//! builder.
//!
//! ```text
//!   builder ──▶ options      the keyword arguments
//!      │  └───▶ work         a build in progress: numbering, sources, reference systems
//!      ├──────▶ batches      rows of arrays and of record batches, as the library's batches
//!      └ ─ ─ ─▶ tasks        inputs and blocks that other processes distribute and conquer
//! ```

pub mod batches;
mod builder;
mod options;
mod tasks;
mod work;

pub use builder::{Builder, identity};
pub use options::{MISSING_Z, Role, choice};
pub use tasks::{conquer, distribute};
