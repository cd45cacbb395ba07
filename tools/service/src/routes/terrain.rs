//! Terrain for Cesium.

use axum::response::Response;
use delaunay_tiles::map_tiles::{TerrainCoord, TerrainFacts};
use serde_json::json;

use super::context::Context;
use super::input::Input;
use super::maps::{finished, lowered, no_tile, numbers};
use crate::finished::What;
use crate::problem::Problem;
use crate::reply::Reply;
use crate::state::Service;

/// Answers with the document that describes the terrain.
///
/// # Errors
/// Fails if the file has no terrain, or if it cannot be read.
pub async fn layer_json(service: Service, input: Input) -> Result<Response, Problem> {
    let mut parameters = input.parameters();
    let context = Context::new(service, &input, &mut parameters).await?;
    let tag = context.tag("terrain/layer.json");
    if let Some(response) = context.known(&tag) {
        return Ok(response);
    }
    let slot = context.service.slots().enter().await?;
    let maps = context.maps().await?;
    let facts = maps
        .terrain_facts()
        .map_err(|error| Problem::of_grid(context.id(), &error))?;
    drop(slot);
    let available = facts.available.iter().map(
        |range| json!([{"startX": range.start_x, "startY": range.start_y, "endX": range.end_x, "endY": range.end_y}]),
    );
    let bounds = facts.bounds;
    let document = json!({
        "tilejson": "2.1.0",
        "name": context.id(),
        "description": "Terrain of a tile file",
        // Viewers insert it as {version}.
        "version": *context.version,
        "format": TerrainFacts::FORMAT,
        "scheme": "tms",
        "projection": TerrainFacts::PROJECTION,
        "tiles": ["{z}/{x}/{y}.terrain?v={version}"],
        "minzoom": 0,
        "maxzoom": facts.max_zoom,
        "bounds": [bounds.min_x, bounds.min_y, bounds.max_x, bounds.max_y],
        "available": available.collect::<Vec<_>>(),
    });
    context.send(Reply::json(&document), Some(tag)).await
}

/// Answers with a terrain tile.
///
/// # Errors
/// Fails if there is no such tile, if it needs more than it may, or if the file cannot be read.
pub async fn tile(service: Service, input: Input) -> Result<Response, Problem> {
    let mut parameters = input.parameters();
    let context = Context::new(service, &input, &mut parameters).await?;
    let numbers = numbers(&input, TerrainFacts::ENDING);
    let at = numbers.and_then(|[z, x, y]| TerrainCoord::new(u8::try_from(z).ok()?, x, y));
    let at = at.ok_or_else(|| no_tile(TerrainFacts::ENDING))?;
    let lowered = lowered(&mut parameters)?;
    let tag = context.tag(&format!("terrain/{at}"));
    if let Some(response) = context.known(&tag) {
        return Ok(response);
    }
    let draw = async |limits| {
        let maps = context.maps().await?;
        let drawn = maps.terrain(at, limits).await;
        drawn
            .map_err(|error| Problem::of_drawing(context.id(), &error))
            .map(|drawn| drawn.bytes)
    };
    let bytes = finished(&context, What::Terrain(at), lowered, draw).await?;
    if bytes.is_empty() {
        return Err(Problem::missing(
            context.id(),
            "the file has nothing there",
            "see terrain/layer.json",
        ));
    }
    context
        .send(Reply::new(TerrainFacts::MEDIA_TYPE, bytes), Some(tag))
        .await
}
