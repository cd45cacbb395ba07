//! What the service knows of its files: the catalogue, and a page about each file.

use axum::response::Response;
use delaunay_tiles::crs::{Crs, Unit};
use delaunay_tiles::geometry::Rect;
use delaunay_tiles::map_tiles::{GridKind, Layer, MapSource};
use delaunay_tiles::store::{LineKind, Metadata};
use serde_json::{Map, Value, json};

use super::context::Context;
use super::input::Input;
use super::query::KINDS;
use crate::problem::Problem;
use crate::reply::{JSON, Reply};
use crate::state::Service;

/// Answers with the list of all files and their layers, in the form of the server martin.
///
/// # Errors
/// Fails if too many bytes wait for clients.
pub async fn catalog(service: Service, input: Input) -> Result<Response, Problem> {
    input.parameters().end()?;
    let mut tiles = Map::new();
    for file in service.catalog().files() {
        // What cannot be read at present is left out.
        let Ok(snapshot) = file.snapshot().await else { continue };
        let Ok(maps) = snapshot.maps().await else { continue };
        let about = json!({"content_type": JSON, "description": format!("What is known of the file {}", file.id)});
        tiles.insert(file.id.clone(), about);
        tiles.extend(sources(&file.id, maps));
    }
    let reply = Reply::json(&json!({ "tiles": tiles }));
    reply.send(&input.headers, service.outgoing()).await
}

/// Returns the paths of a file's layers, and what martin says of a source.
fn sources(id: &str, maps: &MapSource) -> Vec<(String, Value)> {
    let grids = GridKind::ALL.into_iter().filter(|grid| maps.grid(*grid).is_ok());
    let of = |grid: GridKind, layer: Layer| {
        let about = json!({"content_type": layer.media_type(), "description": layer.description()});
        (format!("{id}/{grid}/{layer}"), about)
    };
    grids
        .flat_map(|grid| maps.layers().iter().map(move |layer| of(grid, *layer)))
        .collect()
}

/// Answers with what is known of a file.
///
/// # Errors
/// Fails if there is no such file, or if it cannot be read.
pub async fn file(service: Service, input: Input) -> Result<Response, Problem> {
    let mut parameters = input.parameters();
    let context = Context::new(service, &input, &mut parameters).await?;
    parameters.end()?;
    let tag = context.tag(&input.resource());
    if let Some(response) = context.known(&tag) {
        return Ok(response);
    }
    let slot = context.service.slots().enter().await?;
    let maps = context.maps().await?;
    let document = document(&context, maps);
    drop(slot);
    context.send(Reply::json(&document), Some(tag)).await
}

fn document(context: &Context<'_>, maps: &MapSource) -> Value {
    let (id, reader) = (context.id(), &context.snapshot.reader);
    let metadata = reader.metadata();
    let layers: Vec<&str> = maps.layers().iter().map(|layer| layer.name()).collect();
    let grids = GridKind::ALL.into_iter().map(|kind| {
        let value = match maps.grid(kind) {
            Ok(grid) => json!({
                "bounds": bounds(grid.bounds()),
                "lon_lat_bounds": grid.lon_lat_bounds().and_then(bounds),
                "tile_0": bounds(grid.square()),
                "max_zoom": grid.max_zoom(),
                "layers": layers.iter().map(|layer| (*layer, format!("{id}/{kind}/{layer}.json"))).collect::<std::collections::BTreeMap<_, _>>(),
            }),
            Err(error) => json!({"missing": error.to_string()}),
        };
        (kind.name().to_owned(), value)
    });
    let terrain = match maps.terrain_facts() {
        Ok(_) => json!({"layer": format!("{id}/terrain/layer.json")}),
        Err(error) => json!({"missing": error.to_string()}),
    };
    let [plane, height] = units(context.snapshot.crs.as_ref());
    let mut queries: Vec<&str> = KINDS.to_vec();
    if metadata.has_z {
        queries.extend(["z", "profile"]);
    }
    json!({
        "id": id,
        "version": *context.version,
        "generation": reader.generation(),
        "bytes": reader.file_length(),
        "bounds": bounds(metadata.bounds),
        "crs": context.snapshot.crs.as_ref().map(crs),
        "unit": unit(plane),
        "z_unit": unit(height),
        "has_z": metadata.has_z,
        "line_kinds": line_kinds(metadata),
        "coloured_heights": maps.coloured_heights(),
        "lowest_height": maps.lowest_height(),
        "counts": {
            "tiles": metadata.tiles,
            "vertices": metadata.vertices,
            "triangles": metadata.triangles,
            "constraint_edges": metadata.constraint_edges,
            "regions": metadata.regions,
            "hole_regions": metadata.hole_regions,
            "hole_triangles": metadata.hole_triangles,
            "sites": metadata.sites,
            "overviews": reader.overviews().len(),
        },
        "layers": layers,
        "grids": grids.collect::<Map<_, _>>(),
        "terrain": terrain,
        "queries": queries,
        "matrix": format!("{id}/query/matrix"),
        "raw": context.service.options().raw.then(|| format!("{id}/raw")),
    })
}

/// Returns what is known of a coordinate reference system.
fn crs(crs: &Crs) -> Value {
    json!({"name": crs.name(), "epsg": crs.epsg(), "summary": crs.summary(), "wkt": crs.wkt()})
}

/// Returns the names of the kinds of lines that a file has; all of them if it does not state them.
fn line_kinds(metadata: &Metadata) -> Vec<String> {
    let kinds = [LineKind::BreakLine, LineKind::Wall, LineKind::Obstacle].into_iter();
    kinds
        .filter(|kind| metadata.has_lines(*kind).unwrap_or(true))
        .map(|kind| kind.to_string())
        .collect()
}

/// Returns the units of x and y, and of z.
fn units(crs: Option<&Crs>) -> [Unit; 2] {
    crs.map_or([Unit::Unknown; 2], |crs| [crs.unit(), crs.z_unit()])
}

/// Returns the name of a unit, and its length in metres if it has one.
fn unit(unit: Unit) -> Value {
    json!({"name": unit.name(), "metres": unit.metres()})
}

/// Returns a rectangle as JSON: west, south, east and north; `None` if it is empty.
fn bounds(rect: Rect) -> Option<Value> {
    (!rect.is_empty()).then(|| json!([rect.min_x, rect.min_y, rect.max_x, rect.max_y]))
}
