//! Draws a picture: samples of heights and of the ground, with lines and sites over them.

use std::sync::Arc;

use crate::map_tiles::budget::Budget;
use crate::map_tiles::coord::TileCoord;
use crate::map_tiles::drawn::{DrawError, DrawLimits, Drawn};
use crate::map_tiles::edges::Marks;
use crate::map_tiles::grid::{PIXELS, TileGrid, pixels_of};
use crate::map_tiles::paint::{Density, REACH, paint};
use crate::map_tiles::samples::{centres, within};
use crate::map_tiles::shade::{Relief, Samples, shade};
use crate::map_tiles::shapes::Shapes;
use crate::map_tiles::source::{FILE, MapSource};
use crate::map_tiles::window::Window;
use crate::query::Ground;
use crate::store::{TileId, spawn};

/// The number of samples along a side of a pixel, where one does not suffice, and where very many
/// pixels need more.
const PARTS: [u32; 2] = [4, 2];
/// From so many pixels on, they get fewer samples.
const MANY: usize = 12_000;

/// The tiles that a picture needs.
struct Plan {
    /// The level of the heights; `None` without heights.
    heights: Option<usize>,
    /// The tiles of the file, if its holes and lines are drawn.
    file: Option<Vec<TileId>>,
}

impl MapSource {
    /// Draws the layer [`Shade`](crate::map_tiles::layer::Layer::Shade).
    pub(super) async fn draw_shade(
        &self,
        grid: &TileGrid,
        at: TileCoord,
        limits: DrawLimits,
    ) -> Result<Drawn, DrawError> {
        let mut budget = Budget::new(limits);
        let window = Window::new(grid, at, REACH);
        let plan = self.plan(grid, at, &window, &mut budget).await?;
        let shapes = self.shapes_of(plan.file.as_deref(), &window, limits).await?;
        let points = self.points(grid, move |grid| centres(grid, at, 1)).await?;
        let has_holes = self.reader().metadata().hole_triangles > 0;
        let ground = match plan.heights.is_none() || has_holes && plan.file.is_some() {
            true => Some(self.ground_at(Arc::clone(&points)).await?),
            false => None,
        };
        limits.check()?;
        let heights = match plan.heights {
            Some(level) => Some(self.heights_at(level, points).await?),
            None => None,
        };
        limits.check()?;
        let marks = spawn(move || {
            (
                marks(&shapes, ground.as_deref(), heights.as_deref()),
                shapes,
                ground,
                heights,
            )
        });
        let (pixels, shapes, ground, heights) = marks.await?;
        let parts = PARTS[usize::from(pixels.len() > MANY)];
        let marked = pixels.clone();
        let points = self.points(grid, move |grid| within(grid, at, &marked, parts)).await?;
        let ground_within = match ground {
            Some(_) => self.ground_at(Arc::clone(&points)).await?,
            None => Vec::new(),
        };
        let heights_within = match plan.heights {
            Some(level) => self.heights_at(level, points).await?,
            None => Vec::new(),
        };
        limits.check()?;
        let samples = Samples {
            heights: heights.and_then(|z| self.relief(grid, at, z)),
            ground,
            pixels,
            parts: (parts * parts) as usize,
            heights_within,
            ground_within,
        };
        let density = self.density(grid, at.z());
        let bytes = spawn(move || paint(&shade(&samples), &shapes, density)).await?;
        Ok(Drawn {
            bytes,
            tiles: budget.used(),
        })
    }

    /// Finds the tiles that a picture needs. Of files with heights, holes and lines are left out if
    /// they take too many tiles.
    async fn plan(
        &self,
        grid: &TileGrid,
        at: TileCoord,
        window: &Window,
        budget: &mut Budget,
    ) -> Result<Plan, DrawError> {
        let metadata = self.reader().metadata();
        if self.heights().is_none() || metadata.triangles == 0 {
            let file = budget.claim(self.reader(), window.rect()).await?;
            return Ok(Plan {
                heights: None,
                file: Some(file),
            });
        }
        let level = self.level_for(grid.pixel_size(at.z()));
        let tiles = budget.claim(self.level(level), window.rect()).await?;
        let has_more = metadata.constraint_edges > 0 || metadata.sites > 0 || metadata.hole_triangles > 0;
        let file = match level {
            FILE => Some(tiles),
            _ if has_more => budget.try_claim(self.reader(), window.rect()).await?.ok(),
            _ => None,
        };
        Ok(Plan {
            heights: Some(level),
            file,
        })
    }

    /// Returns the lines and sites of tiles of the file.
    async fn shapes_of(
        &self,
        tiles: Option<&[TileId]>,
        window: &Window,
        limits: DrawLimits,
    ) -> Result<Shapes, DrawError> {
        let metadata = self.reader().metadata();
        let has_shapes = metadata.constraint_edges > 0 || metadata.sites > 0 || metadata.triangles == 0;
        let tiles = tiles.filter(|_| has_shapes).unwrap_or_default().to_vec();
        self.shapes(tiles, window, true, limits).await
    }

    fn density(&self, grid: &TileGrid, zoom: u8) -> Density {
        let metadata = self.reader().metadata();
        let edge = grid.edge_pixels(zoom);
        let site = edge * (metadata.vertices as f64 / metadata.sites.max(1) as f64).sqrt();
        Density { edge, site }
    }

    fn relief(&self, grid: &TileGrid, at: TileCoord, z: Vec<f64>) -> Option<Relief> {
        let units = self.units();
        let steepness = (0..PIXELS).map(|row| {
            let y = (f64::from(at.y()) * f64::from(PIXELS) + f64::from(row) + 0.5) / pixels_of(at.z());
            grid.pixel_metres(at.z(), y, units.plane).map(|metres| units.z / metres)
        });
        Some(Relief {
            z,
            coloured: self.heights()?.coloured,
            steepness: steepness.collect(),
        })
    }
}

/// Returns the pixels that need more than one sample: those along holes, and where something
/// begins.
fn marks(shapes: &Shapes, ground: Option<&[Ground]>, heights: Option<&[f64]>) -> Vec<u32> {
    let mut marks = Marks::new();
    if let Some(ground) = ground {
        shapes.at_holes().for_each(|ends| marks.line(ends));
        marks.changes(ground);
    }
    if let Some(heights) = heights {
        marks.changes(&heights.iter().map(|z| z.is_nan()).collect::<Vec<_>>());
    }
    marks.pixels()
}
