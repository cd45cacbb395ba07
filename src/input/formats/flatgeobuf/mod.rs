//! FlatGeobuf: a header, an optional index, and features, each a FlatBuffer with its length before
//! it.
//!
//! The crate `flatgeobuf` has the tables and verifies them. Its `FgbReader` is not used: it
//! allocates as many bytes as a feature's length claims, and takes a file that is cut short between
//! two features for a whole one.

mod geometry;
mod ids;
mod reader;

pub use reader::open;
