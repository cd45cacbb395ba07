//! Export of the triangulation to formats that other programs read.
//!
//! In: an open tile file. Out: its vertices and triangles, tile by tile, to anything that takes
//! bytes. Memory is bounded by the reader's [limit](crate::store::OpenOptions::memory): it holds a
//! few tiles, a few parts of them as bytes, and eight bytes for each tile of the file.
//!
//! ```text
//! reader ──▶ numbering ──▶ part ──▶ ply, obj, geo_parquet, … ──▶ output ──▶ io::Write
//!            one number     of a     a part's bytes at a time,   order, buffer,
//!            per vertex     tile     on blocking threads          blocking thread
//! ```
//!
//! Where a header needs what the directory does not say (how many triangles are in a polygon), a
//! `survey` of all tiles comes first.
//!
//! Vertices are numbered over the whole file: in the order of the tiles, and in stored order within
//! a tile. All formats list every vertex once, in this order. They list every triangle once,
//! counter-clockwise, in the order of the tiles that own them; triangles in holes only if they are
//! [requested](ExportOptions::holes). Whatever a file contains, an export ends with a complete
//! output or an error. After an error, what was written so far must be discarded.

#[cfg(any(feature = "flatgeobuf", feature = "parquet"))]
mod columns;
mod contours;
#[cfg(feature = "parquet")]
mod crs_member;
mod error;
mod feature;
#[cfg(feature = "flatgeobuf")]
mod flat_geobuf;
mod format;
#[cfg(feature = "parquet")]
mod geo_parquet;
mod geojson;
mod glb;
mod json;
mod node;
mod numbering;
mod obj;
mod options;
mod output;
mod ply;
mod raster;
mod spool;
mod survey;
mod text;
mod tile_part;
mod tiles_done;
mod what;
mod write;

#[cfg(test)]
mod edge_tests;
#[cfg(test)]
mod hole_tests;
#[cfg(test)]
mod tests;

pub use contours::{ContourOutput, ExportedContours, export_contours};
pub use error::ExportError;
pub use format::{Format, UnknownFormat};
pub use options::ExportOptions;
pub use raster::{ExportedRaster, RasterFormat, RasterOutput, Samples, UnknownRasterFormat, export_raster};
pub use what::{UnknownWhat, What};
pub use write::{Exported, export};
