//! Rasters of a surface, block by block.
//!
//! In: an open tile file and a grid. Out: the values of the cells in a block of the grid, from one
//! pass over the tiles that meet it. Threads fill the block together.

use std::ops::Range;
use std::sync::Arc;

use futures::future::FutureExt;
use futures::stream::StreamExt;

use super::cells::Cells;
use super::clip::Clip;
use super::error::TerrainError;
use super::grid::{Grid, Window};
use super::measure::{Measure, Measuring};
use super::surface::{FileSurface, Surface};
#[cfg(feature = "geotiff")]
use crate::crs::Crs;
use crate::memory::FileShares;
use crate::store::{Needs, PassReader, ReadError, TileId, TileReader};

/// What a raster shows, and where.
///
/// The [example of `TileReader::raster`](crate::store::TileReader::raster) uses it.
#[derive(Clone, Debug)]
pub struct RasterOptions {
    grid: Grid,
    measure: Measure,
    z_factor: f64,
    surface: Surface,
    clip: Option<Arc<Clip>>,
}

impl RasterOptions {
    /// Creates the options of a raster of heights in the cells of `grid`.
    #[must_use]
    pub fn new(grid: Grid) -> Self {
        Self {
            grid,
            measure: Measure::Z,
            z_factor: 1.0,
            surface: Surface::default(),
            clip: None,
        }
    }

    /// Sets what the raster shows; heights by default.
    #[must_use]
    pub fn measure(mut self, measure: Measure) -> Self {
        self.measure = measure;
        self
    }

    /// Multiplies all heights by a factor first, for instance to convert feet to metres, or metres to
    /// degrees; 1 by default.
    #[must_use]
    pub fn z_factor(mut self, factor: f64) -> Self {
        self.z_factor = factor;
        self
    }

    /// Sets the triangles that count; by default those that are in no hole.
    #[must_use]
    pub fn surface(mut self, surface: Surface) -> Self {
        self.surface = surface;
        self
    }

    /// Leaves cells whose centres are outside of polygons without a value.
    #[must_use]
    pub fn clip(mut self, clip: Option<Arc<Clip>>) -> Self {
        self.clip = clip;
        self
    }

    /// Returns the grid.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Returns what the raster shows.
    pub(crate) fn what(&self) -> Measure {
        self.measure
    }

    /// Returns these options for cells that are `factor` times as large.
    #[cfg(feature = "geotiff")]
    fn coarser(&self, factor: u32) -> Self {
        Self {
            grid: self.grid.coarser(factor),
            ..self.clone()
        }
    }
}

/// A raster of a file, to be computed.
#[derive(Clone)]
pub(crate) struct Raster {
    reader: PassReader,
    options: RasterOptions,
    surface: FileSurface,
}

/// The number of columns and rows of the blocks of a raster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BlockSize {
    pub(crate) columns: u32,
    pub(crate) rows: u32,
}

/// The values of a block, row by row from the north.
pub(crate) struct Block {
    cells: Arc<Cells>,
    clip: Option<Arc<Clip>>,
}

impl Raster {
    /// The largest number of bytes of a block.
    const LARGEST_BLOCK: u64 = 256 << 20;
    /// The memory of a thread for each vertex of its tile, where some values are found in two steps.
    const CANDIDATES: u64 = 64;

    /// Prepares a raster. Calls `advance` after each tile that it must read before.
    ///
    /// # Errors
    /// Fails if the file has no z, or as [`FileSurface::of`].
    pub(crate) async fn new(
        reader: PassReader,
        options: RasterOptions,
        advance: impl FnMut() + Send,
    ) -> Result<Self, TerrainError> {
        if !reader.metadata().has_z {
            return Err(TerrainError::no_z(&reader));
        }
        let surface = FileSurface::of(&reader, options.surface, advance).await?;
        Ok(Self {
            reader,
            options,
            surface,
        })
    }

    pub(crate) fn options(&self) -> &RasterOptions {
        &self.options
    }

    /// Returns the coordinate reference system of the file.
    #[cfg(feature = "geotiff")]
    pub(crate) fn crs(&self) -> Option<Crs> {
        self.reader.directory().lists.crs.as_deref().map(Crs::new)
    }

    /// Returns a raster of the same surface with cells that are `factor` times as large.
    #[cfg(feature = "geotiff")]
    pub(crate) fn coarser(&self, factor: u32) -> Self {
        Self {
            reader: self.reader.clone(),
            options: self.options.coarser(factor),
            surface: self.surface.clone(),
        }
    }

    fn needs(&self, fixed: u64) -> Needs {
        let needs = Needs {
            fixed,
            per_thread: 0,
            per_vertex: match self.options.measure {
                Measure::Z => 0,
                _ => Self::CANDIDATES,
            },
        };
        needs.and(self.surface.needs())
    }

    /// Returns the size of blocks that fit into the memory that the reader may use, beside
    /// `others` bytes. They have a multiple of `unit` rows, and all columns or, if `may_split`, a
    /// multiple of `unit` of them.
    ///
    /// # Errors
    /// Fails if the memory does not suffice for the smallest block.
    pub(crate) fn block_size(&self, unit: u32, may_split: bool, others: u64) -> Result<BlockSize, ReadError> {
        let grid = &self.options.grid;
        let least = self.needs(others).least(self.reader.directory());
        let share = FileShares(self.reader.memory()).pass().unwrap_or(u64::MAX);
        // Half of what is left is for further tiles.
        let bytes = (share.saturating_sub(least) / 2).min(Self::LARGEST_BLOCK);
        let lanes = bytes / Cells::BYTES / u64::from(unit);
        let up = |count: u32| count.div_ceil(unit).saturating_mul(unit);
        let (columns, rows) = (u64::from(grid.columns()), u64::from(up(grid.rows())));
        if columns <= lanes {
            return Ok(BlockSize {
                columns: grid.columns(),
                rows: (lanes / columns * u64::from(unit)).min(rows) as u32,
            });
        }
        let smallest = if may_split { u64::from(unit) } else { columns };
        if lanes < smallest {
            let needed = least + 2 * smallest * u64::from(unit) * Cells::BYTES;
            return Err(self.reader.too_little_memory(needed + needed / 15));
        }
        Ok(BlockSize {
            columns: (lanes / u64::from(unit) * u64::from(unit)) as u32,
            rows: unit,
        })
    }

    /// Returns the tiles that have triangles at the centres of a window.
    fn tiles(&self, window: &Window) -> Vec<(TileId, ())> {
        let (around, directory) = (window.around_centres(), self.reader.directory());
        let meets = |id: &TileId| directory.tiles[id.0 as usize].bounds.intersects(around);
        directory.tile_ids().filter(meets).map(|id| (id, ())).collect()
    }

    /// Returns how many tiles are read for a block.
    pub(crate) fn tiles_for(&self, columns: Range<u32>, rows: Range<u32>) -> u64 {
        self.tiles(&Window::new(&self.options.grid, columns, rows)).len() as u64
    }

    /// Computes a block. `others` bytes are in use beside it. Calls `advance` after each tile.
    pub(crate) async fn block(
        &self,
        columns: Range<u32>,
        rows: Range<u32>,
        others: u64,
        mut advance: impl FnMut() + Send,
    ) -> Result<Block, ReadError> {
        let RasterOptions {
            grid,
            measure,
            z_factor,
            ref clip,
            ..
        } = self.options;
        let window = Window::new(&grid, columns, rows);
        let tiles = self.tiles(&window);
        let cells = Arc::new(Cells::new(
            window,
            self.surface.clone(),
            Measuring::new(measure, z_factor),
        ));
        let plan = self.reader.plan(self.needs(others + cells.bytes()))?;
        let filled = Arc::clone(&cells);
        let mut passes = self
            .reader
            .for_some_tiles(tiles, plan, move |tile, ()| filled.fill(&tile));
        while let Some(done) = passes.next().await {
            done?;
            advance();
        }
        drop(passes);
        cells.settle();
        Ok(Block {
            cells,
            clip: clip.clone(),
        })
    }
}

impl Block {
    pub(crate) fn columns(&self) -> usize {
        self.cells.window().columns()
    }

    pub(crate) fn rows(&self) -> usize {
        self.cells.window().rows()
    }

    /// Returns the values of some columns of a row; NaN where there is none.
    pub(crate) fn row(&self, row: usize, columns: Range<usize>) -> impl Iterator<Item = f64> {
        columns.map(move |column| {
            let value = self.cells.value(column, row);
            let is_covered = |clip: &Arc<Clip>| clip.covers(self.cells.window().centre(column, row));
            match value.is_nan() || self.clip.as_ref().is_none_or(is_covered) {
                true => value,
                false => f64::NAN,
            }
        })
    }
}

/// Rasters of the surface.
impl TileReader {
    /// Returns the values of a raster in some columns and rows, row by row from the north; NaN where
    /// there is none: outside of the hull, in holes, and where no triangle counts.
    ///
    /// A height is that of the plane of the triangle at the centre of a cell. The values do not depend
    /// on tiles, threads and memory, to the last bit. Must be awaited within a tokio runtime.
    ///
    /// # Errors
    /// Fails if the file has no z, if a tile cannot be read, or if the memory that the reader may use
    /// does not suffice.
    ///
    /// # Panics
    /// Panics if the columns or rows are not in the grid.
    ///
    /// # Examples
    ///
    /// ```
    /// # use delaunay_tiles::{BuildOptions, Builder, OpenOptions, Point, TileReader, input::PointBatch};
    /// use delaunay_tiles::geometry::Rect;
    /// use delaunay_tiles::terrain::{Grid, Measure, RasterOptions};
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("slope.tiles");
    /// # tokio::runtime::Runtime::new()?.block_on(async {
    /// # let points: Vec<Point> = (0..2500).map(|i| Point::new(f64::from(i % 50), f64::from(i / 50))).collect();
    /// # let z = points.iter().map(|p| p.x + 2.0 * p.y).collect();
    /// # let options = BuildOptions::default().tile_vertices(100);
    /// # let mut builder = Builder::new(&path, options)?;
    /// # builder.push(&PointBatch { records: (0..2500).collect(), points, z }).await?;
    /// # builder.finish().await?;
    /// let slope = TileReader::open(&path, OpenOptions::default()).await?;
    /// let grid = Grid::covering(Rect::new(0.0, 0.0, 52.0, 49.0), 2.0, Point::default())?;
    /// let options = RasterOptions::new(grid);
    /// // The northern row: its centres have y = 49, and the last one is outside.
    /// let row = slope.raster(&options, 0..26, 0..1).await?;
    /// assert_eq!((row[0], row[24]), (1.0 + 2.0 * 49.0, 49.0 + 2.0 * 49.0));
    /// assert!(row[25].is_nan());
    ///
    /// let steepness = slope.raster(&options.measure(Measure::Slope), 0..1, 0..1).await?;
    /// assert!((steepness[0] - 5f64.sqrt().atan().to_degrees()).abs() < 1e-9);
    /// # Ok(())
    /// # })
    /// # }
    /// ```
    pub fn raster<'a>(
        &'a self,
        options: &'a RasterOptions,
        columns: Range<u32>,
        rows: Range<u32>,
    ) -> impl Future<Output = Result<Vec<f64>, TerrainError>> + Send + 'a {
        async move {
            let grid = options.grid;
            assert!(
                columns.end <= grid.columns() && rows.end <= grid.rows(),
                "{columns:?} and {rows:?}"
            );
            let raster = Raster::new(self.for_passes().await?, options.clone(), || {}).await?;
            // The copy.
            let bytes = columns.len() as u64 * rows.len() as u64 * size_of::<f64>() as u64;
            let block = raster.block(columns, rows, bytes, || {}).await?;
            let rows = 0..block.rows();
            Ok(rows.flat_map(|row| block.row(row, 0..block.columns())).collect())
        }
        .boxed()
    }
}
