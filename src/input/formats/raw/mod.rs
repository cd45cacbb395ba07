//! Raw little-endian numbers: points as f64, and pairs of record numbers.

pub(crate) mod pairs;
mod points;
mod records;

pub use points::Points;
