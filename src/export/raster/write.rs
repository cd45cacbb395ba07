//! Writing a raster in one of the formats.

use std::io::Write;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread::available_parallelism;

use futures::stream::{self, StreamExt};

use super::asc;
#[cfg(feature = "geotiff")]
use super::geotiff;
use super::samples::{RasterFormat, Samples};
use crate::export::error::ExportError;
use crate::export::output::{Output, Sink};
use crate::store::{TileReader, spawn};
use crate::terrain::{Block, BlockSize, Grid, Raster, RasterOptions};

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
    let mut job = RasterJob {
        raster: Raster::new(reader.for_passes().await?, options)?,
        progress: &mut progress,
        done: 0,
        total: 0,
    };
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

/// The blocks that a format takes.
#[derive(Clone, Copy)]
pub(super) struct Unit {
    /// Blocks have a multiple of this number of rows, except the last ones.
    pub(super) rows: u32,
    /// Whether blocks may have a multiple of that number of columns instead of all columns.
    pub(super) may_split: bool,
}

/// The state of an export.
pub(super) struct RasterJob<'a> {
    pub(super) raster: Raster,
    progress: &'a mut (dyn FnMut(u64, u64) + Send),
    done: u64,
    total: u64,
}

impl RasterJob<'_> {
    /// The memory for encoding: chunks on their way, a few for each thread.
    const ENCODING: u64 = 32 << 20;

    pub(super) fn grid(&self) -> &Grid {
        self.raster.options().grid()
    }

    /// Calls `take` with each block of the raster: rows of blocks from the north, blocks from the west.
    pub(super) async fn for_each_block(
        &mut self,
        unit: Unit,
        mut take: impl AsyncFnMut(&mut Self, Arc<Block>) -> Result<(), ExportError>,
    ) -> Result<(), ExportError> {
        let size = self.raster.block_size(unit.rows, unit.may_split, Self::ENCODING)?;
        let blocks = blocks(self.grid(), size);
        let tiles = |(columns, rows): &(Range<u32>, Range<u32>)| self.raster.tiles_for(columns.clone(), rows.clone());
        self.total += blocks.iter().map(tiles).sum::<u64>();
        for (columns, rows) in blocks {
            let Self {
                raster,
                progress,
                done,
                total,
            } = self;
            let advance = || {
                *done += 1;
                progress(*done, *total);
            };
            let block = raster.block(columns, rows, Self::ENCODING, advance).await?;
            take(self, Arc::new(block)).await?;
        }
        Ok(())
    }

    /// Passes the encoded parts of a block to a sink, in order.
    pub(super) async fn encode<P: Send + 'static, S: Sink>(
        &self,
        block: &Arc<Block>,
        parts: Vec<P>,
        encode: impl Fn(&Block, P) -> Vec<u8> + Clone + Send + 'static,
        sink: &mut S,
    ) -> Result<(), ExportError> {
        let threads = available_parallelism().map_or(1, usize::from);
        let chunks = stream::iter(parts).map(|part| {
            let (block, encode) = (Arc::clone(block), encode.clone());
            spawn(move || encode(&block, part))
        });
        let mut chunks = chunks.buffered(threads + 1);
        while let Some(chunk) = chunks.next().await {
            sink.push(chunk?).await?;
        }
        Ok(())
    }
}

/// Returns the columns and rows of all blocks.
fn blocks(grid: &Grid, size: BlockSize) -> Vec<(Range<u32>, Range<u32>)> {
    let cut = |count: u32, step: u32| {
        let starts = (0..count).step_by(step as usize);
        starts.map(move |start| start..count.min(start.saturating_add(step)))
    };
    let rows = cut(grid.rows(), size.rows);
    rows.flat_map(|rows| cut(grid.columns(), size.columns).map(move |columns| (columns, rows.clone())))
        .collect()
}
