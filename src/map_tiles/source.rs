//! A file to draw: its reader, its levels of detail, and its grids.

use std::sync::Arc;

use crate::crs::{Crs, Unit};
use crate::geometry::Rect;
use crate::map_tiles::coord::GridKind;
use crate::map_tiles::drawn::NoGrid;
use crate::map_tiles::grid::TileGrid;
use crate::map_tiles::heights::HeightRange;
use crate::map_tiles::layer::Layer;
use crate::map_tiles::projection::Projection;
use crate::store::{Metadata, ReadError, TileReader};

/// The number of the level that is the file itself.
pub(super) const FILE: usize = 0;

/// A tile file to draw. Clones share it.
///
/// What is drawn depends on the file, the grid, the tile and the limits alone.
///
/// # Levels of detail
///
/// A zoom is drawn from the coarsest level, an overview or the file itself, in which a typical
/// edge, √(area of the bounds / vertices), is not longer than a pixel in pictures and 12 pixels in
/// vector tiles. So all tiles of a zoom are drawn from one level and agree where they meet.
///
/// # Threads
///
/// Drawing is computed on threads of the library, which are started as needed, and not on those of
/// the runtime. The caller limits how many drawings there are at once. If a future is dropped,
/// nothing more is read; a step that computes ends within milliseconds.
///
/// # Examples
///
/// ```
/// # use delaunay_tiles::{BuildOptions, Builder, OpenOptions, Point, TileReader, input::PointBatch};
/// use delaunay_tiles::map_tiles::{DrawLimits, GridKind, Layer, MapSource, TileCoord};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("hill.tiles");
/// # tokio::runtime::Runtime::new()?.block_on(async {
/// # let points: Vec<Point> = (0..2500).map(|i| Point::new(f64::from(i % 50), f64::from(i / 50))).collect();
/// # let z = points.iter().map(|p| p.x).collect();
/// # let mut builder = Builder::new(&path, BuildOptions::default().tile_vertices(500))?;
/// # builder.push(&PointBatch { records: (0..2500).collect(), points, z }).await?;
/// # builder.finish().await?;
/// let hill = MapSource::open(TileReader::open(&path, OpenOptions::default()).await?).await?;
/// let all = TileCoord::new(0, 0, 0).unwrap();
/// let picture = hill.draw(GridKind::Native, Layer::Shade, all, DrawLimits::default()).await?;
/// assert!(picture.bytes.starts_with(b"\x89PNG"));
/// // The file does not say where it is.
/// assert!(hill.grid(GridKind::WebMercatorQuad).is_err());
/// # Ok(())
/// # })
/// # }
/// ```
#[derive(Clone)]
pub struct MapSource {
    inner: Arc<Inner>,
}

struct Inner {
    /// The file, and its overviews from the finest to the coarsest.
    levels: Vec<TileReader>,
    native: Result<TileGrid, NoGrid>,
    mercator: Result<TileGrid, NoGrid>,
    units: Units,
    heights: Option<HeightRange>,
}

/// The units of a file in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Units {
    /// The unit of x and y; `None` if it is a degree.
    pub(super) plane: Option<f64>,
    /// The unit of z.
    pub(super) z: f64,
}

impl MapSource {
    /// Opens a file with all of its overviews that are up to date. Reads the tiles of the coarsest
    /// level, or 64 of them, to learn the range of heights.
    ///
    /// # Errors
    /// If an overview or a tile cannot be read.
    pub async fn open(reader: TileReader) -> Result<Self, ReadError> {
        let mut levels = Vec::new();
        for level in 0..reader.overviews().len() {
            levels.push(reader.overview(level).await?);
        }
        let error = reader.overviews().last().map_or(0.0, |overview| overview.largest_error);
        Self::create(reader, levels, error).await
    }

    /// Creates the source of a file with levels of detail from elsewhere: triangulations of ever
    /// fewer of its vertices.
    ///
    /// # Errors
    /// If a tile cannot be read.
    pub async fn with_levels(reader: TileReader, levels: Vec<TileReader>) -> Result<Self, ReadError> {
        Self::create(reader, levels, 0.0).await
    }

    /// `error` is how far heights of the file may be outside the range of those of the coarsest
    /// level.
    async fn create(reader: TileReader, overviews: Vec<TileReader>, error: f64) -> Result<Self, ReadError> {
        let levels: Vec<TileReader> = std::iter::once(reader).chain(overviews).collect();
        let (file, coarsest) = (&levels[0], &levels[levels.len() - 1]);
        let crs = file.crs().await?.map(|text| Crs::new(&text));
        let heights = match file.metadata().has_z {
            true => HeightRange::of(coarsest, error).await?,
            false => None,
        };
        let bounds = file.metadata().bounds;
        let spacing = spacing(file.metadata(), bounds);
        let projection = match &crs {
            None => Err(NoGrid::NoCrs),
            Some(crs) => Projection::of(crs, bounds).map(Arc::new),
        };
        let name = crs.as_ref().map(Crs::summary).unwrap_or_default();
        let known = projection.as_ref().ok().map(Arc::clone);
        let inner = Inner {
            native: TileGrid::native(bounds, spacing, known),
            mercator: projection.and_then(|projection| TileGrid::mercator(bounds, spacing, &projection, name)),
            units: Units::of(crs.as_ref()),
            heights,
            levels,
        };
        Ok(Self { inner: Arc::new(inner) })
    }

    /// Returns the reader of the file.
    #[must_use]
    pub fn reader(&self) -> &TileReader {
        &self.inner.levels[FILE]
    }

    /// Returns a grid over the file.
    ///
    /// # Errors
    /// If the file has no tiles in the grid. The error says why.
    pub fn grid(&self, kind: GridKind) -> Result<&TileGrid, NoGrid> {
        let grid = match kind {
            GridKind::Native => &self.inner.native,
            GridKind::WebMercatorQuad => &self.inner.mercator,
        };
        grid.as_ref().map_err(Clone::clone)
    }

    /// Returns the layers of the file. Only files with z have [`Layer::Terrarium`].
    #[must_use]
    pub fn layers(&self) -> &'static [Layer] {
        const WITH_Z: &[Layer] = &[Layer::Shade, Layer::Terrarium, Layer::Mesh];
        const WITHOUT_Z: &[Layer] = &[Layer::Shade, Layer::Mesh];
        if self.reader().metadata().has_z {
            WITH_Z
        } else {
            WITHOUT_Z
        }
    }

    /// Returns the heights that the first and the last colour of [`Layer::Shade`] mean, in metres as
    /// [`Layer::Terrarium`] has them. `None` without z, and without vertices.
    #[must_use]
    pub fn coloured_heights(&self) -> Option<[f64; 2]> {
        let heights = self.inner.heights?;
        Some(heights.coloured.map(|z| z * self.inner.units.z))
    }

    /// Returns the height in metres that [`Layer::Terrarium`] has where there is no surface: the lowest
    /// of the file, or a lower one. `None` without z, and without vertices.
    #[must_use]
    pub fn lowest_height(&self) -> Option<f64> {
        Some(self.inner.heights?.all[0] * self.inner.units.z)
    }

    /// Returns the number of the coarsest level in which a typical edge is not longer than this, in
    /// units of the file; 0 is the file.
    pub(super) fn level_for(&self, length: f64) -> usize {
        (0..self.level_count())
            .rfind(|&level| self.spacing_of(level) <= length)
            .unwrap_or(FILE)
    }

    /// Returns the typical length of an edge of a level, in units of the file.
    pub(super) fn spacing_of(&self, level: usize) -> f64 {
        spacing(self.level(level).metadata(), self.reader().metadata().bounds)
    }

    /// Returns the number of levels, the file among them.
    pub(super) fn level_count(&self) -> usize {
        self.inner.levels.len()
    }

    /// Returns the reader of a level.
    pub(super) fn level(&self, number: usize) -> &TileReader {
        &self.inner.levels[number]
    }

    /// Returns the range of heights, in the file's unit of z. `None` without z, and without
    /// vertices.
    pub(super) fn heights(&self) -> Option<HeightRange> {
        self.inner.heights
    }

    pub(super) fn units(&self) -> Units {
        self.inner.units
    }
}

impl Units {
    /// Returns the units of a reference system. z has the unit of the vertical system, else that of
    /// x and y, else metres.
    fn of(crs: Option<&Crs>) -> Self {
        let plane = crs.map_or(Unit::Unknown, Crs::unit);
        let z = crs.map_or(Unit::Unknown, Crs::z_unit).metres();
        let is_degrees = plane == Unit::Degree || crs.is_some_and(|crs| crs.is_geographic() == Some(true));
        Self {
            plane: (!is_degrees).then(|| plane.metres().unwrap_or(1.0)),
            z: z.unwrap_or(1.0),
        }
    }
}

/// Returns the typical length of an edge: the side of the square that a vertex has for itself.
fn spacing(metadata: &Metadata, bounds: Rect) -> f64 {
    let (width, height) = bounds.size();
    // Of vertices on a line, the distance.
    let least = width.max(height) / metadata.vertices.max(1) as f64;
    let square = (width / metadata.vertices.max(1) as f64 * height).sqrt();
    square.max(least)
}
