//! The formats: their layout in files, and a reader for each kind of record that a format has.

pub mod edges;
pub mod ele;
#[cfg(feature = "flatgeobuf")]
pub mod flatgeobuf;
#[cfg(feature = "geojson")]
pub mod geojson;
#[cfg(feature = "geopackage")]
pub mod geopackage;
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
#[cfg(feature = "shapefile")]
pub mod shapefile;
#[cfg_attr(
    not(any(feature = "geojson", feature = "flatgeobuf", feature = "shapefile", feature = "wkb")),
    allow(dead_code, unused_imports, reason = "no format has shapes")
)]
pub mod shapes;
#[cfg(feature = "text")]
pub mod text;
pub mod text_lines;
pub mod vector;
#[cfg(feature = "wkb")]
pub mod wkb;
