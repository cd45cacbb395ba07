//! Queries of the surface, with the answers of `tiletool query z` and `tiletool query profile`.

use axum::response::Response;
use delaunay_tiles::geometry::Point;
use delaunay_tiles_answers::height::{Counted, Height};
use delaunay_tiles_answers::profile::{feature, object};
use delaunay_tiles_answers::values::{collection_with, position};
use serde_json::json;

use super::context::Context;
use super::features::write;
use super::input::Input;
use super::limits::{query_limits, within};
use crate::parameters::Parameters;
use crate::problem::Problem;
use crate::reply::{GEOJSON, Reply};
use crate::state::Service;

/// Answers with the height of the surface at a point.
///
/// # Errors
/// Fails if the request is invalid, if the file has no z, or if it cannot be read.
pub async fn z(service: Service, input: Input) -> Result<Response, Problem> {
    let mut parameters = input.parameters();
    let context = Context::new(service, &input, &mut parameters).await?;
    let (at, counted) = (parameters.point("at")?, counted(&mut parameters)?);
    parameters.end()?;
    let tag = context.tag(&input.resource());
    if let Some(response) = context.known(&tag) {
        return Ok(response);
    }
    let slot = context.service.slots().enter().await?;
    let time = context.service.options().max_time;
    let height = within(time, Height::find(&context.snapshot.reader, at, counted)).await?;
    let height = height.map_err(|error| Problem::of(context.id(), &error.into()))?;
    let head = collection_with(context.snapshot.crs.as_ref(), &height.object());
    let body = write(head, [height.feature()])?;
    drop(slot);
    context.send(Reply::new(GEOJSON, body), Some(tag)).await
}

/// Answers with the heights of the surface along a line.
///
/// # Errors
/// Fails if the request is invalid, if the file has no z, or if it cannot be read.
pub async fn profile(service: Service, input: Input) -> Result<Response, Problem> {
    let mut parameters = input.parameters();
    let context = Context::new(service, &input, &mut parameters).await?;
    let limits = query_limits(&mut parameters, context.service.options())?;
    let line = [parameters.point("from")?, parameters.point("to")?];
    let counted = counted(&mut parameters)?;
    parameters.end()?;
    let tag = context.tag(&input.resource());
    if let Some(response) = context.known(&tag) {
        return Ok(response);
    }
    let slot = context.service.slots().enter().await?;
    let found = within(limits.time, find(&context, line, counted, limits.tiles)).await;
    let (body, is_stable) = match found {
        Ok(found) => (found?, true),
        // The line may be read to its end the next time.
        Err(_) => (out_of_budget(&context, line)?, false),
    };
    drop(slot);
    context.send(Reply::new(GEOJSON, body), is_stable.then_some(tag)).await
}

/// Returns the body of the profile along a line, for which at most `tiles` tiles are read.
async fn find(context: &Context<'_>, line: [Point; 2], counted: Counted, tiles: u64) -> Result<Vec<u8>, Problem> {
    let reader = &context.snapshot.reader;
    if line[0] == line[1] && reader.metadata().has_z {
        return without_length(context, line[0]);
    }
    let problem = |error: delaunay_tiles::terrain::TerrainError| Problem::of(context.id(), &error.into());
    if reader.metadata().has_z && reader.profile_tiles(&line).await.map_err(problem)? > tiles {
        return out_of_budget(context, line);
    }
    let profile = reader.profile(&line, counted.surface()).await.map_err(problem)?;
    let mut members = object(&profile);
    members.as_object_mut().map(|members| members.remove("parts"));
    members["from"] = position(line[0]);
    members["to"] = position(line[1]);
    members["status"] = "ok".into();
    let head = collection_with(context.snapshot.crs.as_ref(), &members);
    write(
        head,
        profile
            .parts
            .iter()
            .zip(0..)
            .map(|(part, number)| feature(part, number)),
    )
}

/// Returns the body of an answer that a limit ended before its line was read.
fn out_of_budget(context: &Context<'_>, [from, to]: [Point; 2]) -> Result<Vec<u8>, Problem> {
    let members = json!({"from": position(from), "to": position(to), "status": "out_of_budget"});
    write(collection_with(context.snapshot.crs.as_ref(), &members), [])
}

/// Returns the body of the profile along a line whose ends are one point.
fn without_length(context: &Context<'_>, at: Point) -> Result<Vec<u8>, Problem> {
    let members = json!({
        "from": position(at),
        "to": position(at),
        "status": "ok",
        "length": 0.0,
        "gaps": [],
        "note": "the line has no length",
    });
    write(collection_with(context.snapshot.crs.as_ref(), &members), [])
}

/// Takes which triangles count.
fn counted(parameters: &mut Parameters) -> Result<Counted, Problem> {
    Ok(Counted {
        all: parameters.flag("all")?,
        max_edge: parameters.length("max-edge")?,
    })
}
