//! Queries, with the answers of `tiletool query`.

use std::time::{Duration, Instant};

use axum::http::{HeaderMap, HeaderName, HeaderValue};
use axum::response::Response;
use delaunay_tiles::query::{Mode, QueryOptions, TilesUsed};
use delaunay_tiles_answers::answer::{Answer, Status};
use delaunay_tiles_answers::ask::Ask;
use delaunay_tiles_answers::asked::Asked;
use delaunay_tiles_answers::objects::{features, members};
use delaunay_tiles_answers::question::Question;
use delaunay_tiles_answers::values::collection_with;

use super::context::Context;
use super::features::write;
use super::input::Input;
use super::limits::{query_limits, within};
use crate::options::Options;
use crate::parameters::Parameters;
use crate::problem::Problem;
use crate::reply::{GEOJSON, Reply};
use crate::state::Service;

/// The queries that [`answer`] answers, by their names in paths.
pub const KINDS: [&str; 6] = ["locate", "nearest", "knn", "range", "path", "along"];

/// The response header with the number of tiles that the query used, from the file or from the cache.
pub const TILES_READ: HeaderName = HeaderName::from_static("tiles-read");
const SERVER_TIMING: HeaderName = HeaderName::from_static("server-timing");

/// What a request asks for.
struct Request {
    ask: Ask,
    question: Question,
    options: QueryOptions,
}

/// Answers a query of the kind `kind`.
///
/// # Errors
/// Fails if the request is invalid, or if the file cannot be read.
pub async fn answer(kind: &'static str, service: Service, input: Input) -> Result<Response, Problem> {
    let mut parameters = input.parameters();
    let context = Context::new(service, &input, &mut parameters).await?;
    let request = Request::new(kind, &mut parameters, context.service.options())?;
    parameters.end()?;
    let tag = context.tag(&input.resource());
    if let Some(response) = context.known(&tag) {
        return Ok(response);
    }
    let slot = context.service.slots().enter().await?;
    let reader = &context.snapshot.reader;
    let options = context.service.options();
    let (began, used) = (Instant::now(), TilesUsed::default());
    let limited = request.options.tiles_used(&used);
    let answer = request
        .ask
        .answer_up_to(reader, request.question, limited, options.max_points);
    let answer = within(options.max_time, answer).await?;
    let answer = answer.map_err(|error| Problem::of(context.id(), &error))?;
    let taken = began.elapsed();
    let body = body(&context, request.ask, &answer)?;
    drop(slot);
    // What a limit of time ended may go further the next time.
    let is_stable = !matches!(answer.status, Status::Budget(_));
    let mut response = context
        .send(Reply::new(GEOJSON, body), is_stable.then_some(tag))
        .await?;
    add_cost(response.headers_mut(), taken, &used);
    Ok(response)
}

/// Adds to the headers what the answer took.
fn add_cost(headers: &mut HeaderMap, taken: Duration, used: &TilesUsed) {
    let timing = format!("query;dur={:.3}", taken.as_secs_f64() * 1000.0);
    if let Ok(timing) = HeaderValue::try_from(timing) {
        headers.insert(SERVER_TIMING, timing);
    }
    headers.insert(TILES_READ, used.count().into());
}

fn body(context: &Context<'_>, ask: Ask, answer: &Answer) -> Result<Vec<u8>, Problem> {
    let crs = context.snapshot.crs.as_ref();
    let asked = Asked::new(ask, &context.snapshot.reader, crs);
    let head = collection_with(crs, &members(asked, answer));
    write(head, features(asked, answer))
}

impl Request {
    fn new(kind: &str, parameters: &mut Parameters, options: &Options) -> Result<Self, Problem> {
        let limits = query_limits(parameters, options)?.options();
        let k = |parameters: &mut Parameters, default: u32| {
            let k = parameters.count("k", 1, options.max_k.into())?;
            Ok::<u32, Problem>(k.and_then(|k| u32::try_from(k).ok()).unwrap_or(default))
        };
        let (ask, mode) = match kind {
            "locate" => (Ask::Locate, None),
            "nearest" => {
                let (k, vertices) = (k(parameters, 1)?, parameters.flag("vertices")?);
                (Ask::Nearest { k, vertices }, None)
            }
            "knn" => {
                let (k, search) = (k(parameters, 10)?, parameters.search()?);
                (Ask::Knn { k, search }, Some(parameters.mode()?))
            }
            "range" => {
                let (radius, area) = (parameters.distance("radius")?, parameters.flag("area")?);
                (Ask::Range { radius, area }, Some(parameters.mode()?))
            }
            "path" => (Ask::Path, Some(parameters.mode()?)),
            _ => (Ask::Along { k: k(parameters, 1)? }, None),
        };
        let question = match ask {
            Ask::Path | Ask::Along { .. } => Question::Way(parameters.point("from")?, parameters.point("to")?),
            _ => Question::At(parameters.point("at")?),
        };
        let certify = mode.is_some() && parameters.flag("certify")?;
        let limits = limits.mode(mode.unwrap_or(Mode::Exact));
        let options = if certify { limits.certified() } else { limits.paths() };
        Ok(Self { ask, question, options })
    }
}
