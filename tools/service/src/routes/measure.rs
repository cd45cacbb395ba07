//! Measures requests.

use std::time::Instant;

use axum::extract::{MatchedPath, Request, State};
use axum::http::StatusCode;
use axum::middleware::Next;
use axum::response::Response;

use crate::metrics::{Kind, Route};
use crate::state::Service;

/// A request in flight, until it is dropped.
struct InFlight<'a>(&'a Service);

impl Drop for InFlight<'_> {
    fn drop(&mut self) {
        self.0.metrics().in_flight.dec();
    }
}

/// Counts and times a request.
pub async fn measure(State(service): State<Service>, request: Request, next: Next) -> Response {
    let metrics = service.metrics();
    metrics.in_flight.inc();
    let _in_flight = InFlight(&service);
    let began = Instant::now();
    let route = request.extensions().get::<MatchedPath>().cloned();
    let method = request.method().clone();
    let response = next.run(request).await;
    let (status, seconds) = (response.status(), began.elapsed().as_secs_f64());
    // Paths of no route are not told apart: there are as many as clients wish.
    let route = route.as_ref().map_or("none", MatchedPath::as_str).to_owned();
    tracing::debug!(%method, route, status = status.as_u16(), seconds, "answered");
    if status == StatusCode::SERVICE_UNAVAILABLE {
        metrics.rejected.inc();
    }
    let route = Route { route };
    metrics.times.get_or_create(&route).observe(seconds);
    let kind = Kind {
        route: route.route,
        status: status.as_u16(),
    };
    metrics.requests.get_or_create(&kind).inc();
    response
}
