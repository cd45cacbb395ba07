//! Which function answers which path.

use std::any::Any;
use std::future::Future;

use axum::Router;
use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::{HeaderName, HeaderValue, Method, StatusCode, header};
use axum::middleware::{Next, from_fn, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::{MethodRouter, get, post};
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::cors::{AllowOrigin, CorsLayer};

use super::input::Input;
use super::{facts, health, maps, matrix, measure, page, query, raw, surface, terrain};
use crate::openapi;
use crate::options::Options;
use crate::problem::Problem;
use crate::reply::{JSON, Reply};
use crate::state::Service;

/// The length of the longest address.
const LONGEST_URI: usize = 4 << 10;

impl Service {
    /// Returns a router with all paths of the service.
    pub fn router(&self) -> Router {
        router(self.clone())
    }
}

/// Returns the router of a service.
fn router(service: Service) -> Router {
    let mut router = Router::new()
        .route("/", to(page::index))
        .route("/page/{version}/{*file}", to(page::asset))
        .route("/catalog", to(facts::catalog))
        .route("/health", to(health::health))
        .route("/metrics", to(health::metrics))
        .route("/openapi.json", to(document))
        .route("/{id}", to(facts::file))
        .route("/{id}/raw", get(raw_bytes))
        .route("/{id}/query/z", to(surface::z))
        .route("/{id}/query/profile", to(surface::profile))
        .route("/{id}/query/matrix", post(pairs))
        .route("/{id}/terrain/layer.json", to(terrain::layer_json))
        .route("/{id}/terrain/{z}/{x}/{y}", to(terrain::tile))
        .route("/{id}/{grid}/{layer}", to(maps::tile_json))
        .route("/{id}/{grid}/{layer}/{z}/{x}/{y}", to(maps::tile));
    for kind in query::KINDS {
        let answer = move |service, input| query::answer(kind, service, input);
        router = router.route(&format!("/{{id}}/query/{kind}"), to(answer));
    }
    let panics = CatchPanicLayer::custom({
        let service = service.clone();
        move |panic: Box<dyn Any + Send>| failed(&service, &*panic)
    });
    let options = service.options().clone();
    let router = router
        .fallback(async || Problem::no_route())
        .method_not_allowed_fallback(async || Problem::no_method())
        // In one, because a request passes a box for each call of `layer`.
        .layer((
            from_fn_with_state(service.clone(), measure::measure),
            panics,
            from_fn(short_uri),
        ))
        .with_state(service);
    match options.cors.is_empty() {
        true => router,
        false => router.layer(cors(&options)),
    }
}

/// Returns the route of a function that answers GET and HEAD.
fn to<F, A>(answer: F) -> MethodRouter<Service>
where
    F: Fn(Service, Input) -> A + Clone + Send + Sync + 'static,
    A: Future<Output = Result<Response, Problem>> + Send,
{
    get(move |State(service): State<Service>, input: Input| answer(service, input))
}

async fn raw_bytes(State(service): State<Service>, method: Method, input: Input) -> Result<Response, Problem> {
    raw::raw(service, input, method).await
}

async fn pairs(State(service): State<Service>, input: Input, body: Body) -> Result<Response, Problem> {
    matrix::matrix(service, input, body).await
}

/// Answers with the description of all paths.
async fn document(service: Service, input: Input) -> Result<Response, Problem> {
    let ids: Vec<&str> = service.catalog().ids().collect();
    let document = openapi::document(&ids, service.options());
    Reply::new(JSON, document.to_string())
        .send(&input.headers, service.outgoing())
        .await
}

/// Refuses long addresses.
async fn short_uri(request: Request, next: Next) -> Response {
    let uri = request.uri();
    if uri.path().len() + uri.query().map_or(0, str::len) > LONGEST_URI {
        return Problem::too_large(StatusCode::URI_TOO_LONG, "URL", LONGEST_URI).into_response();
    }
    next.run(request).await
}

/// Counts a panic. Its text may have anything, so no client gets it.
fn failed(service: &Service, panic: &(dyn Any + Send)) -> Response {
    service.metrics().panics.inc();
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
    tracing::error!(panic = text.unwrap_or("unknown"), "a request failed by a defect");
    Problem::defect().into_response()
}

/// Returns the layer that lets pages of other origins read answers.
fn cors(options: &Options) -> CorsLayer {
    let origins = options
        .cors
        .iter()
        .filter_map(|origin| HeaderValue::from_str(origin).ok());
    let origins: Vec<HeaderValue> = origins.collect();
    let origins = match origins.iter().any(|origin| origin == "*") {
        true => AllowOrigin::any(),
        false => AllowOrigin::list(origins),
    };
    let taken: [HeaderName; 5] = [
        header::CONTENT_TYPE,
        header::RANGE,
        header::IF_NONE_MATCH,
        header::IF_MATCH,
        header::IF_RANGE,
    ];
    let shown: [HeaderName; 7] = [
        HeaderName::from_static("server-timing"),
        query::TILES_READ,
        header::ETAG,
        header::CONTENT_RANGE,
        header::ACCEPT_RANGES,
        header::CONTENT_LENGTH,
        header::RETRY_AFTER,
    ];
    CorsLayer::new()
        .allow_origin(origins)
        .allow_methods([Method::GET, Method::HEAD, Method::POST])
        .allow_headers(taken)
        .expose_headers(shown)
}
