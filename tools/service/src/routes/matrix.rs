//! Walking distances between all points of two lists, with the answers of `tiletool query matrix`.

use axum::body::{Body, to_bytes};
use axum::http::{StatusCode, header};
use axum::response::Response;
use delaunay_tiles::geometry::Point;
use delaunay_tiles_answers::matrix::{Matrix, NamedPoints};
use delaunay_tiles_answers::values::collection_with;
use futures::TryStreamExt;
use serde::{Deserialize, Deserializer};
use serde_json::{Value, json};
use tokio::time::{Instant, timeout, timeout_at};

use super::context::Context;
use super::features::write;
use super::input::Input;
use super::limits::{Limits, query_limits, within};
use crate::options::Options;
use crate::parameters::number::is_coordinate;
use crate::problem::Problem;
use crate::reply::{GEOJSON, Reply};
use crate::state::Service;

/// The body of a request.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Lists {
    /// The start points.
    from: Vec<[f64; 2]>,
    /// The end points; by default the start points.
    #[serde(default, deserialize_with = "some")]
    to: Option<Vec<[f64; 2]>>,
    /// Whether all sites are the end points.
    #[serde(default)]
    sites: bool,
}

/// Reads a list that is there, which `null` is not.
fn some<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Vec<[f64; 2]>>, D::Error> {
    Vec::deserialize(deserializer).map(Some)
}

/// Answers with the walking distances between all points of two lists.
///
/// # Errors
/// Fails if the request is invalid or too large, or if the file cannot be read.
pub async fn matrix(service: Service, input: Input, body: Body) -> Result<Response, Problem> {
    let mut parameters = input.parameters();
    let context = Context::new(service, &input, &mut parameters).await?;
    let options = context.service.options();
    let limits = query_limits(&mut parameters, options)?;
    parameters.end()?;
    let lists = read(&input, body, options).await?;
    let slot = context.service.slots().enter().await?;
    // Searches have limits each; this one is of all.
    let body = within(limits.time, answer(&context, lists, limits)).await??;
    drop(slot);
    context.send(Reply::new(GEOJSON, body), None).await
}

/// Reads the body of a request.
async fn read(input: &Input, body: Body, options: &Options) -> Result<Lists, Problem> {
    let too_large = || Problem::too_large(StatusCode::PAYLOAD_TOO_LARGE, "body", options.max_body);
    let announced = input.headers.get(header::CONTENT_LENGTH);
    let announced = announced.and_then(|value| value.to_str().ok());
    if announced.is_some_and(|length| length.parse().is_ok_and(|length: u64| length > options.max_body as u64)) {
        return Err(too_large());
    }
    let bytes = timeout(options.read_timeout, to_bytes(body, options.max_body)).await;
    let bytes = bytes.map_err(|_| Problem::too_slow())?.map_err(|_| too_large())?;
    let advice = r#"give {"from": [[x, y], …]}, and either "to": [[x, y], …] or "sites": true"#;
    let wrong = |what: String| Problem::invalid("body", what, advice);
    let lists: Lists = serde_json::from_slice(&bytes).map_err(|error| wrong(format!("it is no such JSON: {error}")))?;
    if lists.sites && lists.to.is_some() {
        return Err(wrong("it has both `to` and `sites`".to_owned()));
    }
    if lists.from.is_empty() || lists.to.as_ref().is_some_and(Vec::is_empty) {
        return Err(wrong("a list has no points".to_owned()));
    }
    let mut points = lists.from.iter().chain(lists.to.iter().flatten());
    if let Some([x, y]) = points.find(|point| !point.iter().all(|value| is_coordinate(*value))) {
        return Err(wrong(format!(
            "({x}, {y}) is no point; a coordinate is 0 or has a magnitude from 1e-40 up to 1e54"
        )));
    }
    check_pairs(lists.from.len(), lists.to.as_ref().map_or(1, Vec::len), options)?;
    Ok(lists)
}

fn check_pairs(from: usize, to: usize, options: &Options) -> Result<(), Problem> {
    match from.saturating_mul(to) > options.max_pairs {
        true => Err(Problem::invalid(
            "body",
            format!("there are {from} times {to} pairs"),
            format!("ask for at most {} pairs at once", options.max_pairs),
        )),
        false => Ok(()),
    }
}

async fn answer(context: &Context<'_>, lists: Lists, limits: Limits) -> Result<Vec<u8>, Problem> {
    let reader = &context.snapshot.reader;
    let points = |list: Vec<[f64; 2]>| list.into_iter().map(|[x, y]| Point::new(x, y)).collect::<Vec<_>>();
    let from = NamedPoints::unnamed(points(lists.from));
    let to = match lists.to {
        Some(list) => NamedPoints::unnamed(points(list)),
        None if lists.sites => sites(context, limits).await?,
        None => from.clone(),
    };
    let options = context.service.options();
    check_pairs(from.points.len(), to.points.len(), options)?;
    let matrix = Matrix { from, to };
    let [from, to] = [&matrix.from, &matrix.to].map(|ends| ends.points.clone());
    let mut pairs = reader.distance_matrix(from, to, limits.options().paths());
    let (mut features, mut points): (Vec<Value>, usize) = (Vec::new(), 0);
    let problem = |error: delaunay_tiles::query::QueryError| Problem::of(context.id(), &error.into());
    let mut status = "ok";
    let deadline = Instant::now() + limits.time;
    loop {
        let Ok(next) = timeout_at(deadline, pairs.try_next()).await else {
            status = "out_of_budget";
            break;
        };
        let Some(found) = next.map_err(problem)? else { break };
        points += 1 + found.path.as_ref().map_or(0, |path| path.points.len());
        features.push(matrix.feature(&found));
        if points >= options.max_points {
            status = "out_of_budget";
            break;
        }
    }
    let head = collection_with(context.snapshot.crs.as_ref(), &json!({"status": status}));
    write(head, features)
}

/// Returns all sites of the file, if they are few.
async fn sites(context: &Context<'_>, limits: Limits) -> Result<NamedPoints, Problem> {
    let (reader, options) = (&context.snapshot.reader, context.service.options());
    let metadata = reader.metadata();
    if metadata.sites == 0 {
        return Err(Problem::missing(
            context.id(),
            "the file has no sites",
            "give end points as `to`",
        ));
    }
    let few = metadata.sites <= options.max_pairs as u64 && u64::from(metadata.tiles) <= limits.tiles;
    if !few {
        return Err(Problem::invalid(
            "body",
            format!(
                "the file has {} sites in {} tiles, which are too many",
                metadata.sites, metadata.tiles
            ),
            "give end points as `to`",
        ));
    }
    NamedPoints::sites(reader)
        .await
        .map_err(|error| Problem::of(context.id(), &error))
}
