//! The formats: their layout in files, and a reader for each kind of record that a format has.

#[cfg(feature = "geojson")]
pub mod geojson;
#[cfg(feature = "las")]
pub mod las;
pub mod node;
pub mod poly;
pub mod raw;
#[cfg(feature = "text")]
pub mod text;
pub mod text_lines;
