//! Raw little-endian numbers: points as f64, and pairs of record numbers.

mod pairs;
mod points;
mod records;

pub use pairs::Pairs;
pub use points::Points;
