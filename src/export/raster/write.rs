//! Writing a raster in one of the formats.

use std::io::Write;
use std::path::PathBuf;

use super::asc;
#[cfg(feature = "geotiff")]
use super::geotiff;
use super::job::RasterJob;
use super::samples::{RasterFormat, Samples};
use crate::export::error::ExportError;
use crate::export::output::Output;
use crate::store::TileReader;
use crate::terrain::RasterOptions;

/// How a raster is written.
///
/// ```
/// use delaunay_tiles::export::{RasterFormat, RasterOutput, Samples};
///
/// let output = RasterOutput::new(RasterFormat::Asc).samples(Samples::Float32);
/// # let _ = output;
/// ```
#[derive(Clone, Debug)]
pub struct RasterOutput {
    format: RasterFormat,
    samples: Samples,
    overviews: bool,
    scratch: PathBuf,
}

impl RasterOutput {
    /// Creates the description of an output with numbers of 64 bits and without overviews.
    #[must_use]
    pub fn new(format: RasterFormat) -> Self {
        Self {
            format,
            samples: Samples::default(),
            overviews: false,
            scratch: std::env::temp_dir(),
        }
    }

    /// Sets the numbers in which heights, slopes and aspects are stored. Shades are always stored as
    /// bytes.
    #[must_use]
    pub fn samples(mut self, samples: Samples) -> Self {
        self.samples = samples;
        self
    }

    /// Sets whether a GeoTIFF gets overviews: rasters of the same surface with cells of 2, 4, 8… times
    /// the size, down to one tile of 256 by 256 cells. With them it is a Cloud Optimized GeoTIFF.
    #[must_use]
    pub fn overviews(mut self, overviews: bool) -> Self {
        self.overviews = overviews;
        self
    }

    /// Sets the folder for a temporary file that takes the compressed tiles of a GeoTIFF, which come
    /// behind their index; the system's folder for temporary files by default.
    #[must_use]
    pub fn scratch(mut self, folder: impl Into<PathBuf>) -> Self {
        self.scratch = folder.into();
        self
    }
}

/// The summary and the output of an export of a raster.
#[derive(Debug)]
#[non_exhaustive]
pub struct ExportedRaster<W> {
    /// The number of columns.
    pub columns: u32,
    /// The number of rows.
    pub rows: u32,
    /// The number of bytes.
    pub bytes: u64,
    /// The output, flushed.
    pub output: W,
}

/// Writes a raster of the surface of a file. Must be awaited within a tokio runtime.
///
/// The output gets chunks of one or two mebibytes, on threads for blocking work, so it needs no
/// buffer. `progress` is called with the number of tiles done and the total. A tile is read for each
/// block of cells that it meets; the more memory the reader may use, the fewer blocks there are. The
/// bytes do not depend on it.
///
/// # Errors
/// Fails if the file has no z, cannot be read or is damaged, if the output or the temporary file
/// fails, or if the memory that the reader may use does not suffice.
pub async fn export_raster<W: Write + Send + 'static>(
    reader: &TileReader,
    options: RasterOptions,
    how: &RasterOutput,
    output: W,
    mut progress: impl FnMut(u64, u64) + Send,
) -> Result<ExportedRaster<W>, ExportError> {
    let samples = Samples::of(options.what(), how.samples);
    let mut output = Output::new(output, how.format.suffix());
    let grid = *options.grid();
    let mut job = RasterJob::new(reader.for_passes().await?, options, &mut progress).await?;
    match how.format {
        RasterFormat::Asc => asc::write(&mut job, samples, &mut output).await?,
        #[cfg(feature = "geotiff")]
        RasterFormat::GeoTiff => {
            geotiff::write(&mut job, samples, how.overviews, &how.scratch, &mut output).await?;
        }
        #[cfg(not(feature = "geotiff"))]
        RasterFormat::GeoTiff => return Err(crate::export::write::not_compiled("geotiff")),
    }
    let (output, bytes) = output.finish().await?;
    Ok(ExportedRaster {
        columns: grid.columns(),
        rows: grid.rows(),
        bytes,
        output,
    })
}
