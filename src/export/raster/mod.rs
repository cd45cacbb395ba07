//! Export of a surface as a raster: heights, slopes, aspects or shades in square cells.
//!
//! In: an open tile file with z and the cells. Out: one file, to anything that takes bytes. Blocks of
//! cells are computed one after the other, as large as the memory allows, and encoded by threads.
//!
//! ```text
//! terrain::Raster ──▶ block ──▶ asc:     rows of text ──▶ Output
//!                        └────▶ geotiff: tiles ──▶ scratch file ──▶ header, scratch ──▶ Output
//! ```

mod asc;
#[cfg(feature = "geotiff")]
mod geotiff;
mod job;
mod samples;
#[cfg(feature = "geotiff")]
mod tiff;
mod write;

pub use samples::{RasterFormat, Samples, UnknownRasterFormat};
pub use write::{ExportedRaster, RasterOutput, export_raster};
