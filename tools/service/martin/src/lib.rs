//! Tile files as a source of tiles for the server [martin](https://maplibre.org/martin/).
//!
//! A [`DelaunaySource`] serves one layer of one file in the grid of web maps.

use async_trait::async_trait;
use delaunay_tiles::map_tiles::{DrawError, DrawLimits, GridKind, Layer, MapSource, TileCoord as Place};
use martin_core::CacheZoomRange;
use martin_core::tiles::{BoxedSource, MartinCoreError, MartinCoreResult, Source, UrlQuery};
use martin_tile_utils::{Encoding, Format, TileCoord, TileData, TileInfo};
use tilejson::{Bounds, TileJSON, VectorLayer, tilejson};

/// A layer of a tile file.
#[derive(Clone)]
pub struct DelaunaySource {
    id: String,
    layer: Layer,
    maps: MapSource,
    limits: DrawLimits,
    tilejson: TileJSON,
}

impl std::fmt::Debug for DelaunaySource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("DelaunaySource").field("id", &self.id).finish_non_exhaustive()
    }
}

impl DelaunaySource {
    /// Creates a source of this id. Each tile is drawn within `limits`.
    ///
    /// # Errors
    /// Fails if the file has no such layer, or if its reference system is not known.
    pub async fn new(id: String, maps: MapSource, layer: Layer, limits: DrawLimits) -> Result<Self, DrawError> {
        let facts = maps.facts(GridKind::WebMercatorQuad, layer, limits).await?;
        // martin replaces the address.
        let mut tilejson = tilejson! {
            tiles: Vec::new(),
            name: id.clone(),
            minzoom: facts.min_zoom,
            maxzoom: facts.max_zoom.max(facts.min_zoom),
        };
        let bounds = facts.lon_lat_bounds;
        tilejson.bounds = bounds.map(|bounds| Bounds::new(bounds.min_x, bounds.min_y, bounds.max_x, bounds.max_y));
        let layers = facts.vector_layers.iter().map(|layer| {
            let fields = layer.fields.iter().map(|(name, kind)| ((*name).to_owned(), (*kind).to_owned()));
            VectorLayer::new(layer.id.to_owned(), fields.collect())
        });
        tilejson.vector_layers = (layer == Layer::Mesh).then(|| layers.collect());
        Ok(Self {
            id,
            layer,
            maps,
            limits,
            tilejson,
        })
    }
}

#[async_trait]
impl Source for DelaunaySource {
    fn get_id(&self) -> &str {
        &self.id
    }

    fn get_tilejson(&self) -> &TileJSON {
        &self.tilejson
    }

    fn get_tile_info(&self) -> TileInfo {
        match self.layer {
            Layer::Mesh => TileInfo::new(Format::Mvt, Encoding::Uncompressed),
            Layer::Shade | Layer::Terrarium => TileInfo::new(Format::Png, Encoding::Internal),
        }
    }

    fn clone_source(&self) -> BoxedSource {
        Box::new(self.clone())
    }

    fn get_version(&self) -> Option<String> {
        let reader = self.maps.reader();
        Some(format!("{}-{}", reader.file_id(), reader.generation()))
    }

    fn cache_zoom(&self) -> CacheZoomRange {
        CacheZoomRange::default()
    }

    async fn get_tile(&self, xyz: TileCoord, _: Option<&UrlQuery>) -> MartinCoreResult<TileData> {
        let Some(at) = Place::new(xyz.z, xyz.x, xyz.y) else {
            return Ok(TileData::new());
        };
        let drawn = self.maps.draw(GridKind::WebMercatorQuad, self.layer, at, self.limits).await;
        let drawn = drawn.map_err(|error| MartinCoreError::OtherError(Box::new(error)))?;
        Ok(drawn.bytes.to_vec())
    }
}
