//! What drawings ask of a file.

use std::sync::Arc;

use futures::stream;
use futures::stream::{StreamExt, TryStreamExt};

use crate::geometry::Point;
use crate::map_tiles::drawn::{DrawError, DrawLimits};
use crate::map_tiles::grid::TileGrid;
use crate::map_tiles::shapes::Shapes;
use crate::map_tiles::source::{FILE, MapSource};
use crate::map_tiles::window::Window;
use crate::query::{BulkOptions, Ground};
use crate::store::{ReadError, Tile, TileId, spawn};
use crate::terrain::Surface;

/// The number of tiles that are read and worked on at once.
const AT_ONCE: usize = 2;

impl MapSource {
    /// Computes points on a thread of the library.
    pub(super) async fn points(
        &self,
        grid: &TileGrid,
        compute: impl FnOnce(&TileGrid) -> Arc<[Point]> + Send + 'static,
    ) -> Result<Arc<[Point]>, ReadError> {
        let grid = grid.clone();
        spawn(move || compute(&grid)).await
    }

    /// Returns the heights of a level at points, NaN where it has no surface.
    pub(super) async fn heights_at(&self, level: usize, points: Arc<[Point]>) -> Result<Vec<f64>, ReadError> {
        let surface = Surface::default().holes(true);
        self.level(level)
            .surface_z_many(points, surface, BulkOptions::default())
            .await
    }

    /// Returns what is at points of the file.
    pub(super) async fn ground_at(&self, points: Arc<[Point]>) -> Result<Vec<Ground>, ReadError> {
        self.level(FILE).ground_many(points, BulkOptions::default()).await
    }

    /// Returns the lines and sites of tiles of the file, joined.
    pub(super) async fn shapes(
        &self,
        tiles: Vec<TileId>,
        window: &Window,
        curved: bool,
        limits: DrawLimits,
    ) -> Result<Shapes, DrawError> {
        let (mut shapes, window) = (Shapes::default(), window.clone());
        let of = move |tile: &Tile| Shapes::of(tile, &window, curved);
        self.of_tiles(FILE, tiles, limits, of, |part| shapes.append(part))
            .await?;
        let joined = spawn(move || {
            shapes.join();
            shapes
        });
        Ok(joined.await?)
    }

    /// Computes something of each of some tiles of a level, on threads of the library, and passes
    /// it to `take` in the order of the tiles.
    pub(super) async fn of_tiles<T: Send + 'static>(
        &self,
        level: usize,
        tiles: Vec<TileId>,
        limits: DrawLimits,
        compute: impl Fn(&Tile) -> T + Clone + Send + 'static,
        mut take: impl FnMut(T),
    ) -> Result<(), DrawError> {
        let reader = self.level(level);
        let work = stream::iter(tiles).map(|id| {
            let compute = compute.clone();
            async move {
                let tile = reader.tile(id).await?;
                spawn(move || compute(&tile)).await
            }
        });
        let mut work = std::pin::pin!(work.buffered(AT_ONCE));
        while let Some(found) = work.try_next().await? {
            limits.check()?;
            take(found);
        }
        Ok(())
    }
}
