//! What an archive says of itself: its header, and its metadata for viewers.

use pmtiles::{Compression, PmTilesWriter, TileType};
use serde_json::{Map, Value, json};

use crate::crs::Crs;
use crate::geometry::Rect;
use crate::map_archive::error::ArchiveError;
use crate::map_archive::plan::ArchivePlan;
use crate::map_tiles::{GridKind, Layer, MapSource, TileGrid};

/// Returns a writer with the header and the metadata of an archive.
pub(super) async fn writer(source: &MapSource, plan: &ArchivePlan) -> Result<PmTilesWriter, ArchiveError> {
    let grid = source.grid(plan.options.grid)?;
    let (kind, compression) = match plan.options.layer {
        Layer::Mesh => (TileType::Mvt, Compression::Gzip),
        Layer::Shade | Layer::Terrarium => (TileType::Png, Compression::None),
    };
    let crs = source.reader().crs().await?.map(|text| Crs::new(&text).summary());
    let place = Place::of(grid, plan);
    let metadata = Value::Object(metadata(source, plan, grid, &place, crs));
    let Rect {
        min_x,
        min_y,
        max_x,
        max_y,
    } = place.bounds;
    let [lon, lat] = place.centre;
    Ok(PmTilesWriter::new(kind)
        .precompressed(compression)
        .min_zoom(plan.zooms.first())
        .max_zoom(plan.zooms.last())
        .bounds(min_x, min_y, max_x, max_y)
        .center(lon, lat)
        .center_zoom(place.zoom)
        .metadata(metadata.to_string()))
}

/// Where a viewer shows an archive, in degrees of longitude and latitude.
struct Place {
    bounds: Rect,
    centre: [f64; 2],
    /// The zoom at which the longer side of the bounds is one to two tiles long.
    zoom: u8,
}

impl Place {
    fn of(grid: &TileGrid, plan: &ArchivePlan) -> Self {
        let shown = grid.shown_bounds();
        // In the header there are ten millionths of a degree, and a viewer must find all of the tiles.
        let (down, up) = (|v: f64| (v * 1e7).floor() / 1e7, |v: f64| (v * 1e7).ceil() / 1e7);
        let bounds = Rect::new(down(shown.min_x), down(shown.min_y), up(shown.max_x), up(shown.max_y));
        let (all, _) = grid.square().size();
        let (width, height) = grid.bounds().size();
        let zoom = (all / width.max(height)).log2().ceil();
        Self {
            bounds,
            centre: [bounds.min_x.midpoint(bounds.max_x), bounds.min_y.midpoint(bounds.max_y)],
            // Of a single vertex it is infinite.
            zoom: zoom.clamp(plan.zooms.first().into(), plan.zooms.last().into()) as u8,
        }
    }
}

fn metadata(
    source: &MapSource,
    plan: &ArchivePlan,
    grid: &TileGrid,
    place: &Place,
    crs: Option<String>,
) -> Map<String, Value> {
    let (options, reader) = (&plan.options, source.reader());
    let rect = |rect: Rect| json!([rect.min_x, rect.min_y, rect.max_x, rect.max_y]);
    let [lon, lat] = place.centre;
    let mut entries = vec![
        ("name", json!(options.name)),
        ("description", json!(options.layer.description())),
        ("type", json!("overlay")),
        ("minzoom", json!(plan.zooms.first())),
        ("maxzoom", json!(plan.zooms.last())),
        ("bounds", rect(place.bounds)),
        ("center", json!([lon, lat, place.zoom])),
        ("layer", json!(options.layer.name())),
        ("grid", json!(options.grid.name())),
        ("grid_bounds", rect(grid.bounds())),
        ("crs", json!(crs)),
        ("file", json!(reader.file_id().to_string())),
        ("generation", json!(reader.generation())),
        (
            "generator",
            json!(concat!("delaunay-tiles ", env!("CARGO_PKG_VERSION"))),
        ),
    ];
    if let Some(attribution) = &options.attribution {
        entries.push(("attribution", json!(attribution)));
    }
    if options.grid == GridKind::Native {
        let note = "The coordinates are those of the file: viewers show the square grid_square in place of the world";
        entries.extend([("grid_square", rect(grid.square())), ("note", json!(note))]);
    }
    match options.layer {
        Layer::Terrarium => entries.push(("encoding", json!("terrarium"))),
        Layer::Mesh => entries.push(("vector_layers", vector_layers(plan))),
        Layer::Shade => {}
    }
    entries
        .into_iter()
        .map(|(key, value)| (key.to_owned(), value))
        .collect()
}

fn vector_layers(plan: &ArchivePlan) -> Value {
    let layers = plan.facts.vector_layers.iter().map(|layer| {
        let fields: Map<String, Value> = layer
            .fields
            .iter()
            .map(|(name, kind)| ((*name).to_owned(), json!(kind)))
            .collect();
        json!({
            "id": layer.id,
            "description": layer.description,
            "fields": fields,
            "minzoom": plan.zooms.first(),
            "maxzoom": plan.zooms.last(),
        })
    });
    Value::Array(layers.collect())
}
