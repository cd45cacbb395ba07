//! Map tiles, and the documents that describe them to viewers.

use std::collections::BTreeMap;
use std::time::Instant;

use axum::response::Response;
use bytes::Bytes;
use delaunay_tiles::map_tiles::{DrawLimits, GridKind, Layer, LayerFacts, TileCoord};
use serde_json::json;
use tilejson::{Bounds, TileJSON, VectorLayer, tilejson};

use super::base::{VARIES, base};
use super::context::Context;
use super::input::Input;
use super::limits::within;
use crate::finished::{Key, What};
use crate::options::Options;
use crate::parameters::{MAX_COUNT, Parameters};
use crate::problem::Problem;
use crate::reply::{JSON, Reply};
use crate::state::Service;

/// Answers with a map tile.
///
/// # Errors
/// Fails if there is no such tile, if it needs more than it may, or if the file cannot be read.
pub async fn tile(service: Service, input: Input) -> Result<Response, Problem> {
    let mut parameters = input.parameters();
    let context = Context::new(service, &input, &mut parameters).await?;
    let (grid, layer) = (grid(&input)?, layer(input.part("layer"))?);
    let at = coord(&input, layer.ending())?;
    let lowered = lowered(&mut parameters)?;
    // The layer shade takes the parameter too, and is the same with it.
    let wants_opaque = layer != Layer::Mesh && parameters.flag("opaque")?;
    let is_opaque = wants_opaque && layer == Layer::Terrarium;
    let (what, tag) = match is_opaque {
        true => (What::OpaqueHeights(grid, at), format!("{grid}/{layer}/{at} opaque")),
        false => (What::Map(grid, layer, at), format!("{grid}/{layer}/{at}")),
    };
    let tag = context.tag(&tag);
    if let Some(response) = context.known(&tag) {
        return Ok(response);
    }
    let draw = async |limits| {
        let maps = context.maps().await?;
        let drawn = match is_opaque {
            true => maps.draw_opaque_heights(grid, at, limits).await,
            false => maps.draw(grid, layer, at, limits).await,
        };
        drawn
            .map_err(|error| Problem::of_drawing(context.id(), &error))
            .map(|drawn| drawn.bytes)
    };
    let bytes = finished(&context, what, lowered, draw).await?;
    context.send(Reply::new(layer.media_type(), bytes), Some(tag)).await
}

/// Returns a map tile: a finished one, or one that is drawn now. `lowered` is a limit of tiles that the
/// request asks for.
///
/// # Errors
/// Returns the errors of `draw`, and fails if the service is busy.
pub async fn finished(
    context: &Context<'_>,
    what: What,
    lowered: Option<u32>,
    draw: impl AsyncFnOnce(DrawLimits) -> Result<Bytes, Problem>,
) -> Result<Bytes, Problem> {
    let service = &context.service;
    let options = service.options();
    let max_tiles = lowered.map_or(options.max_picture_tiles, |tiles| tiles.min(options.max_picture_tiles));
    let key = Key {
        snapshot: context.snapshot.number,
        what,
    };
    let work = async || {
        let _slot = service.slots().enter().await?;
        let deadline = Instant::now().checked_add(options.max_time);
        // Boxed: drawing has a large future, which finished tiles should not pay for.
        Box::pin(within(options.max_time, draw(DrawLimits { max_tiles, deadline }))).await?
    };
    if max_tiles == options.max_picture_tiles {
        return service.finished().get(&key, work).await;
    }
    match service.finished().peek(&key) {
        Some(tile) => Ok(tile),
        None => work().await,
    }
}

/// Takes a limit of tiles that is lower than the service's. Other parameters are ignored: viewers add
/// some of their own.
pub fn lowered(parameters: &mut Parameters) -> Result<Option<u32>, Problem> {
    let tiles = parameters.count("max-tiles", 0, MAX_COUNT)?;
    Ok(tiles.map(|tiles| u32::try_from(tiles).unwrap_or(u32::MAX)))
}

/// Answers with the TileJSON of a layer.
///
/// # Errors
/// Fails if there is no such layer, or if the file cannot be read.
pub async fn tile_json(service: Service, input: Input) -> Result<Response, Problem> {
    let mut parameters = input.parameters();
    let context = Context::new(service, &input, &mut parameters).await?;
    // martin has no ending there.
    let name = input.part("layer");
    let (grid, layer) = (grid(&input)?, layer(name.strip_suffix(".json").unwrap_or(name))?);
    let base = base(&input, context.service.options());
    let tag = context.tag(&format!("{base} {grid}/{layer}.json"));
    if let Some(response) = context.known(&tag) {
        return Ok(response);
    }
    let options = context.service.options();
    let slot = context.service.slots().enter().await?;
    let maps = context.maps().await?;
    let facts = within(options.max_time, maps.facts(grid, layer, limits(options))).await?;
    let facts = facts.map_err(|error| Problem::of_drawing(context.id(), &error))?;
    drop(slot);
    let document = document(&context, &base, &facts);
    let body = serde_json::to_vec(&document).map_err(|_| Problem::defect())?;
    let mut reply = Reply::new(JSON, body);
    reply.varies = Some(VARIES);
    context.send(reply, Some(tag)).await
}

/// Returns the limits of drawing with these options.
pub fn limits(options: &Options) -> DrawLimits {
    DrawLimits {
        max_tiles: options.max_picture_tiles,
        deadline: Instant::now().checked_add(options.max_time),
    }
}

fn document(context: &Context<'_>, base: &str, facts: &LayerFacts) -> TileJSON {
    let (id, grid, layer) = (context.id(), facts.grid, facts.layer);
    let url = format!(
        "{base}/{id}/{grid}/{layer}/{{z}}/{{x}}/{{y}}.{}?v={}",
        layer.ending(),
        context.version
    );
    let mut document = tilejson! {
        tiles: vec![url],
        name: format!("{id} {layer}"),
        description: layer.description().to_owned(),
        minzoom: facts.min_zoom,
        maxzoom: facts.max_zoom.max(facts.min_zoom),
        scheme: "xyz".to_owned(),
    };
    // Of the grid of the file itself, longitudes and latitudes would say nothing to viewers.
    if let (GridKind::WebMercatorQuad, Some(bounds)) = (grid, facts.lon_lat_bounds) {
        document.bounds = Some(Bounds::new(bounds.min_x, bounds.min_y, bounds.max_x, bounds.max_y));
    }
    let of = |bounds: delaunay_tiles::Rect| json!([bounds.min_x, bounds.min_y, bounds.max_x, bounds.max_y]);
    document.other.insert("grid".to_owned(), json!(grid.name()));
    document.other.insert("grid_bounds".to_owned(), of(facts.bounds));
    document
        .other
        .insert("version_of_file".to_owned(), json!(*context.version));
    match layer {
        Layer::Terrarium => {
            document.other.insert("encoding".to_owned(), json!("terrarium"));
        }
        Layer::Mesh => {
            let layers = facts.vector_layers.iter().map(|layer| {
                let fields = layer
                    .fields
                    .iter()
                    .map(|(name, kind)| ((*name).to_owned(), (*kind).to_owned()));
                let mut of = VectorLayer::new(layer.id.to_owned(), fields.collect::<BTreeMap<_, _>>());
                of.description = Some(layer.description.to_owned());
                of
            });
            document.vector_layers = Some(layers.collect());
        }
        Layer::Shade => {}
    }
    document
}

fn grid(input: &Input) -> Result<GridKind, Problem> {
    let grid = input.part("grid").parse();
    grid.map_err(|error: delaunay_tiles::map_tiles::UnknownGrid| {
        Problem::missing("path", error.to_string(), "see /openapi.json for all paths")
    })
}

fn layer(name: &str) -> Result<Layer, Problem> {
    let layer = name.parse();
    layer.map_err(|error: delaunay_tiles::map_tiles::UnknownLayer| {
        Problem::missing("path", error.to_string(), "see /openapi.json for all paths")
    })
}

fn coord(input: &Input, ending: &str) -> Result<TileCoord, Problem> {
    let parts = numbers(input, ending);
    let coord = parts.and_then(|[z, x, y]| TileCoord::new(u8::try_from(z).ok()?, x, y));
    coord.ok_or_else(|| no_tile(ending))
}

/// Returns `z`, `x` and `y` of a path whose last part has this ending.
pub fn numbers(input: &Input, ending: &str) -> Option<[u32; 3]> {
    let y = input.part("y").strip_suffix(ending)?.strip_suffix('.')?;
    let number = |text: &str| {
        let is_number = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        text.parse().ok().filter(|_| is_number)
    };
    Some([number(input.part("z"))?, number(input.part("x"))?, number(y)?])
}

/// Returns that there is no tile of these numbers.
pub fn no_tile(ending: &str) -> Problem {
    Problem::missing(
        "path",
        "there is no tile of these numbers, or of this ending",
        format!("ask for /z/x/y.{ending} with x and y within the zoom"),
    )
}
