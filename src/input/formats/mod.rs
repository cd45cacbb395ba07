//! The formats: their layout in files, and a reader for each kind of record that a format has.

pub mod edges;
pub mod ele;
#[cfg(feature = "geojson")]
pub mod geojson;
#[cfg(feature = "las")]
pub mod las;
#[cfg(any(feature = "text", feature = "parquet"))]
pub mod names;
pub mod node;
pub mod obj;
#[cfg(feature = "parquet")]
pub mod parquet;
pub mod ply;
pub mod poly;
pub mod raw;
#[cfg(feature = "text")]
pub mod text;
pub mod text_lines;
