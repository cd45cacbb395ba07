//! Whether the service works, and what it measures.

use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde_json::json;

use super::input::Input;
use crate::problem::Problem;
use crate::reply::Reply;
use crate::state::Service;

/// Answers whether the service takes requests.
///
/// # Errors
/// Fails if the service ends.
pub async fn health(service: Service, input: Input) -> Result<Response, Problem> {
    if service.is_draining() {
        return Err(Problem::busy("draining: the service ends"));
    }
    let reply = Reply::json(&json!({"status": "ok"}));
    reply.send(&input.headers, service.outgoing()).await
}

/// Answers with all measurements, as Prometheus reads them.
///
/// # Errors
/// Never; other paths have errors.
pub async fn metrics(service: Service, _: Input) -> Result<Response, Problem> {
    let media = HeaderValue::from_static("application/openmetrics-text; version=1.0.0; charset=utf-8");
    let mut response = (StatusCode::OK, service.metrics_text()).into_response();
    response.headers_mut().insert(header::CONTENT_TYPE, media);
    response
        .headers_mut()
        .insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    Ok(response)
}
