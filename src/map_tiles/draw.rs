//! Draws a map tile: from the levels, the samples and the tiles of the file to bytes.

use futures::future::FutureExt;

use crate::map_tiles::budget::Budget;
use crate::map_tiles::coord::{GridKind, TileCoord};
use crate::map_tiles::drawn::{DrawError, DrawLimits, Drawn};
use crate::map_tiles::grid::{TileGrid, fractions_of};
use crate::map_tiles::layer::Layer;
use crate::map_tiles::samples::centres;
use crate::map_tiles::source::MapSource;
use crate::map_tiles::terrarium::terrarium;
use crate::store::spawn;

impl MapSource {
    /// Draws a map tile. Must be awaited within a tokio runtime.
    ///
    /// The result is empty where the file has nothing. Heights are those of the triangulation at
    /// the centres of pixels; triangles in holes count, because holes say where paths go, not where
    /// the ground is, and overviews have no holes.
    ///
    /// # Errors
    /// If the file has no tiles in the grid or no such layer, if it cannot be read, or if the
    /// drawing takes more than the limits allow.
    pub fn draw(
        &self,
        grid: GridKind,
        layer: Layer,
        at: TileCoord,
        limits: DrawLimits,
    ) -> impl Future<Output = Result<Drawn, DrawError>> + Send {
        async move {
            let grid = self.grid(grid)?;
            if !self.layers().contains(&layer) {
                return Err(DrawError::NoLayer(layer));
            }
            if !fractions_of(at, 0.0).intersects(grid.extent()) {
                return Ok(Drawn::NOTHING);
            }
            limits.check()?;
            match layer {
                Layer::Terrarium => self.draw_terrarium(grid, at, limits, 0).await,
                Layer::Shade => self.draw_shade(grid, at, limits).await,
                Layer::Mesh => self.draw_mesh(grid, at, limits).await,
            }
        }
        .boxed()
    }

    /// Draws a map tile of [`Layer::Terrarium`] whose pixels are all opaque: without a surface, they
    /// have the [lowest height](Self::lowest_height). Browsers forget the colours of transparent pixels.
    ///
    /// # Errors
    /// As [`draw`](Self::draw).
    pub async fn draw_opaque_heights(
        &self,
        grid: GridKind,
        at: TileCoord,
        limits: DrawLimits,
    ) -> Result<Drawn, DrawError> {
        let grid = self.grid(grid)?;
        if !self.layers().contains(&Layer::Terrarium) {
            return Err(DrawError::NoLayer(Layer::Terrarium));
        }
        limits.check()?;
        self.draw_terrarium(grid, at, limits, u8::MAX).await
    }

    /// `opacity` is that of pixels without a surface.
    async fn draw_terrarium(
        &self,
        grid: &TileGrid,
        at: TileCoord,
        limits: DrawLimits,
        opacity: u8,
    ) -> Result<Drawn, DrawError> {
        let mut budget = Budget::new(limits);
        let level = self.level_for(grid.pixel_size(at.z()));
        budget.claim(self.level(level), grid.rect_of(at, 1.0)).await?;
        let points = self.points(grid, move |grid| centres(grid, at, 0)).await?;
        let heights = self.heights_at(level, points).await?;
        limits.check()?;
        let lowest = self.heights().map_or(0.0, |range| range.all[0]);
        let unit = self.units().z;
        let bytes = spawn(move || terrarium(&heights, unit, lowest, opacity)).await?;
        Ok(Drawn {
            bytes,
            tiles: budget.used(),
        })
    }
}
