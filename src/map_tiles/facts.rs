//! What describes a layer to viewers: bounds and zooms.

use std::collections::HashMap;

use futures::future::FutureExt;

use crate::geometry::{Point, Rect};
use crate::map_tiles::coord::{GridKind, TileCoord};
use crate::map_tiles::drawn::{DrawError, DrawLimits};
use crate::map_tiles::grid::{PIXELS, TileGrid, around};
use crate::map_tiles::layer::{Layer, VectorLayer};
use crate::map_tiles::paint::REACH;
use crate::map_tiles::source::{FILE, MapSource};
use crate::map_tiles::window::PER_PIXEL;
use crate::store::{ReadError, TileReader};

/// The number of map tiles after which no more are counted.
const MANY: usize = 1 << 20;

/// What describes a layer of a file in a grid, as for TileJSON.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LayerFacts {
    /// The grid.
    pub grid: GridKind,
    /// The layer.
    pub layer: Layer,
    /// A rectangle around all vertices, in coordinates of the grid.
    pub bounds: Rect,
    /// The same in degrees of longitude and latitude, if the reference system of the file is known.
    pub lon_lat_bounds: Option<Rect>,
    /// The first zoom from which on no tile is out of budget. In Web Mercator, it may be one zoom later.
    pub min_zoom: u8,
    /// The zoom at which a typical edge is 16 pixels long, at least `min_zoom`. Deeper tiles are
    /// drawn too.
    pub max_zoom: u8,
    /// The layers of vector tiles.
    pub vector_layers: &'static [VectorLayer],
}

impl MapSource {
    /// Returns what describes a layer. `limits` are those with which tiles will be drawn.
    ///
    /// This reads the directory of levels that have more tiles than a drawing may need.
    ///
    /// # Errors
    /// If the file has no tiles in the grid or no such layer, or if the directory cannot be read.
    pub fn facts(
        &self,
        grid: GridKind,
        layer: Layer,
        limits: DrawLimits,
    ) -> impl Future<Output = Result<LayerFacts, DrawError>> + Send {
        async move {
            let tiles = self.grid(grid)?;
            if !self.layers().contains(&layer) {
                return Err(DrawError::NoLayer(layer));
            }
            let min_zoom = self.min_zoom(grid, layer, limits).await?;
            Ok(LayerFacts {
                grid,
                layer,
                bounds: tiles.bounds(),
                lon_lat_bounds: tiles.lon_lat_bounds(),
                min_zoom,
                max_zoom: tiles.max_zoom().max(min_zoom),
                vector_layers: layer.vector_layers(),
            })
        }
        .boxed()
    }

    /// Returns the first zoom from which on no tile is out of budget.
    async fn min_zoom(&self, kind: GridKind, layer: Layer, limits: DrawLimits) -> Result<u8, DrawError> {
        // Vector tiles leave out what is too much.
        if layer == Layer::Mesh {
            return Ok(0);
        }
        let grid = self.grid(kind)?;
        let has_heights = self.heights().is_some();
        let mut bounds: Option<(usize, Vec<Rect>)> = None;
        let mut first = 0;
        for zoom in 0..TileCoord::MAX_ZOOM {
            let level = if has_heights {
                self.level_for(grid.pixel_size(zoom))
            } else {
                FILE
            };
            let mut fits = self.level(level).metadata().tiles <= limits.max_tiles;
            if !fits {
                let known = match bounds.take() {
                    Some((known, bounds)) if known == level => bounds,
                    _ => bounds_of(self.level(level)).await?,
                };
                fits = most_tiles(grid, kind, zoom, &known) <= limits.max_tiles;
                bounds = Some((level, known));
            }
            match fits {
                false => first = zoom + 1,
                // Deeper tiles are parts of those of this zoom, and of the same level.
                true if level == FILE => break,
                true => {}
            }
        }
        Ok(first)
    }
}

/// Returns a rectangle of the grid, in shares of its side, around all map tiles that meet a rectangle of
/// the file with their margin. `side` is the number of map tiles along the grid's side.
fn reach(grid: &TileGrid, kind: GridKind, side: f64, rect: Rect) -> Rect {
    let (around, margin) = match kind {
        GridKind::Native => {
            let corners = [(rect.min_x, rect.min_y), (rect.max_x, rect.max_y)].map(|(x, y)| Point::new(x, y));
            let places = corners.iter().filter_map(|&corner| grid.fraction(corner));
            let pixels = REACH / PER_PIXEL + 1;
            (
                Rect::around(places.map(|[x, y]| Point::new(x, y))),
                f64::from(pixels) / f64::from(PIXELS),
            )
        }
        // The rectangle around a map tile in coordinates of the file is somewhat larger than the map tile.
        GridKind::WebMercatorQuad => (around(rect, |p| grid.fraction(p)), 0.1),
    };
    let margin = margin / side;
    Rect::new(
        around.min_x - margin,
        around.min_y - margin,
        around.max_x + margin,
        around.max_y + margin,
    )
}

/// Returns the bounds of all tiles of a level.
async fn bounds_of(level: &TileReader) -> Result<Vec<Rect>, ReadError> {
    let mut bounds = Vec::new();
    for tile in level.tiles_in(level.metadata().bounds, usize::MAX).await? {
        bounds.push(level.entry(tile).await?.bounds);
    }
    Ok(bounds)
}

/// Returns the largest number of tiles with these bounds that a tile of a zoom meets, with its
/// margin.
fn most_tiles(grid: &TileGrid, kind: GridKind, zoom: u8, bounds: &[Rect]) -> u32 {
    let mut counts: HashMap<[u32; 2], u32> = HashMap::new();
    let side = f64::from(1u32 << zoom);
    for rect in bounds {
        let reach = reach(grid, kind, side, *rect);
        let number = |share: f64| (share * side).clamp(0.0, side - 1.0) as u32;
        for x in number(reach.min_x)..=number(reach.max_x) {
            for y in number(reach.min_y)..=number(reach.max_y) {
                *counts.entry([x, y]).or_default() += 1;
            }
        }
        // From here on, a tile of the file is larger than many map tiles, and the answer is near.
        if counts.len() > MANY {
            break;
        }
    }
    counts.into_values().max().unwrap_or(0)
}
