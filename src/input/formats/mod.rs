//! The formats: what their files look like, and a reader for each kind of record that they may have.

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
