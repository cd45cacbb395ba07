//! Terrain for Cesium: meshes in the format quantized-mesh.

use crate::geometry::Rect;
use crate::map_tiles::coord::TerrainCoord;
use crate::map_tiles::drawn::{DrawError, DrawLimits, Drawn, NoGrid};
use crate::map_tiles::source::MapSource;

/// What describes the terrain of a file, as for `layer.json`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TerrainFacts {
    /// A rectangle around all vertices, in degrees of longitude and latitude.
    pub bounds: Rect,
    /// The deepest zoom that viewers should ask for.
    pub max_zoom: u8,
    /// The tiles of each zoom, from 0 up to `max_zoom`.
    pub available: Vec<TerrainRange>,
}

/// The tiles of a zoom, in columns from the west and rows from the south, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct TerrainRange {
    /// The first column.
    pub start_x: u32,
    /// The first row.
    pub start_y: u32,
    /// The last column.
    pub end_x: u32,
    /// The last row.
    pub end_y: u32,
}

impl TerrainFacts {
    /// The reference system of tiles, as `layer.json` names it.
    pub const PROJECTION: &'static str = "EPSG:4326";
    /// The format of tiles, as `layer.json` names it.
    pub const FORMAT: &'static str = "quantized-mesh-1.0";
    /// The media type of tiles.
    pub const MEDIA_TYPE: &'static str = "application/vnd.quantized-mesh";
    /// The ending of names of tiles, without the dot.
    pub const ENDING: &'static str = "terrain";
}

impl MapSource {
    /// Returns what describes the terrain.
    ///
    /// # Errors
    /// If the file has no z, or is not known to be on Earth.
    pub fn terrain_facts(&self) -> Result<TerrainFacts, NoGrid> {
        Err(NoGrid::NoHeights)
    }

    /// Draws a terrain tile in the format quantized-mesh-1.0, without compression. Must be awaited
    /// within a tokio runtime.
    ///
    /// # Errors
    /// As [`draw`](Self::draw).
    #[expect(clippy::unused_async, reason = "it will draw")]
    pub async fn terrain(&self, at: TerrainCoord, limits: DrawLimits) -> Result<Drawn, DrawError> {
        let _ = (at, limits);
        Ok(Drawn::NOTHING)
    }
}
