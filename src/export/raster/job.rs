//! An export of a raster in progress: block by block, encoded by threads.

use std::ops::Range;
use std::sync::Arc;
use std::thread::available_parallelism;

use futures::stream::{self, StreamExt};

use crate::export::error::ExportError;
use crate::export::output::Sink;
use crate::export::tiles_done::TilesDone;
use crate::store::{PassReader, spawn};
use crate::terrain::{Block, BlockSize, Grid, Raster, RasterOptions};

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
    progress: TilesDone<'a>,
}

impl<'a> RasterJob<'a> {
    /// The memory for encoding: chunks on their way, a few for each thread.
    const ENCODING: u64 = 32 << 20;

    /// Prepares an export.
    ///
    /// # Errors
    /// As [`Raster::new`].
    pub(super) async fn new(
        reader: PassReader,
        options: RasterOptions,
        progress: &'a mut (dyn FnMut(u64, u64) + Send),
    ) -> Result<Self, ExportError> {
        let mut progress = TilesDone::new(progress, &reader);
        let raster = Raster::new(reader, options, || progress.advance()).await?;
        progress.end_of_surface();
        Ok(Self { raster, progress })
    }

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
        self.progress.add(blocks.iter().map(tiles).sum::<u64>());
        for (columns, rows) in blocks {
            let Self { raster, progress } = self;
            let block = raster
                .block(columns, rows, Self::ENCODING, || progress.advance())
                .await?;
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
