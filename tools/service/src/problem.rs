//! Why a request has no answer.

use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use delaunay_tiles::map_tiles::{DrawError, NoGrid};
use delaunay_tiles::query::QueryError;
use delaunay_tiles::store::ReadError;
use delaunay_tiles::terrain::TerrainError;
use serde::Serialize;

/// The number of seconds after which a client may ask again.
const RETRY_SECONDS: u32 = 1;

/// Why a request has no answer: the body of each error, as JSON.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Problem {
    /// The status code.
    #[serde(serialize_with = "number")]
    pub status: StatusCode,
    /// What is wrong.
    pub what: String,
    /// Which part of the request, or which file, is wrong.
    #[serde(rename = "where")]
    pub place: String,
    /// What to do about it.
    pub advice: String,
    /// The length of the file whose range is wrong.
    #[serde(skip)]
    pub length: Option<u64>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde calls it")]
fn number<S: serde::Serializer>(status: &StatusCode, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_u16(status.as_u16())
}

impl Problem {
    fn new(status: StatusCode, place: impl Into<String>, what: impl Into<String>, advice: impl Into<String>) -> Self {
        Self {
            status,
            what: what.into(),
            place: place.into(),
            advice: advice.into(),
            length: None,
        }
    }

    /// Returns that a part of the request is invalid.
    pub fn invalid(place: impl Into<String>, what: impl Into<String>, advice: impl Into<String>) -> Self {
        Self::new(StatusCode::BAD_REQUEST, place, what, advice)
    }

    /// Returns that there is no such thing.
    pub fn missing(place: impl Into<String>, what: impl Into<String>, advice: impl Into<String>) -> Self {
        Self::new(StatusCode::NOT_FOUND, place, what, advice)
    }

    /// Returns that a path of a URL names nothing.
    pub fn no_route() -> Self {
        Self::missing(
            "path",
            "there is nothing at this path",
            "see /openapi.json for all paths",
        )
    }

    /// Returns that a path has no such method.
    pub fn no_method() -> Self {
        Self::new(
            StatusCode::METHOD_NOT_ALLOWED,
            "method",
            "the path does not have this method",
            "use a method of the header Allow",
        )
    }

    /// Returns that the file cannot be served at present.
    pub fn unavailable(place: impl Into<String>, what: impl Into<String>) -> Self {
        Self::new(StatusCode::SERVICE_UNAVAILABLE, place, what, "try again later")
    }

    /// Returns that the service has too much to do.
    pub fn busy(what: &str) -> Self {
        Self::unavailable("service", what)
    }

    /// Returns that a request or its part is too large.
    pub fn too_large(status: StatusCode, place: &str, most: usize) -> Self {
        Self::new(
            status,
            place,
            format!("it has more than {most} bytes"),
            "send less at once",
        )
    }

    /// Returns that the client was too slow.
    pub fn too_slow() -> Self {
        Self::new(
            StatusCode::REQUEST_TIMEOUT,
            "body",
            "the body of the request did not come in time",
            "send it faster",
        )
    }

    /// Returns that the client expects another version of the file.
    pub fn changed(place: impl Into<String>) -> Self {
        Self::new(
            StatusCode::PRECONDITION_FAILED,
            place,
            "the file is not the one of If-Match",
            "begin again with the new version",
        )
    }

    /// Returns that a range of bytes is not in the file.
    pub fn no_range(what: impl Into<String>, length: u64) -> Self {
        let advice = format!("the file has {length} bytes; ask for one range of them");
        Self {
            length: Some(length),
            ..Self::new(StatusCode::RANGE_NOT_SATISFIABLE, "Range", what, advice)
        }
    }

    /// Returns that the service has a defect.
    pub fn defect() -> Self {
        Self::new(
            StatusCode::INTERNAL_SERVER_ERROR,
            "service",
            "the service failed",
            "report it with the request",
        )
    }

    /// Returns what an error of an answer says of the file `id`.
    pub fn of(id: &str, error: &anyhow::Error) -> Self {
        if let Some(error) = error.downcast_ref::<QueryError>() {
            return Self::of_query(id, error);
        }
        if let Some(error) = error.downcast_ref::<TerrainError>() {
            return Self::of_terrain(id, error);
        }
        match error.downcast_ref::<ReadError>() {
            Some(error) => Self::of_read(id, error),
            None => {
                tracing::error!(file = id, error = format!("{error:#}"), "unexpected");
                Self::defect()
            }
        }
    }

    /// Returns that a file cannot be read. Readers are opened with the file's id as its name, so no
    /// message has its path.
    pub fn of_read(id: &str, error: &ReadError) -> Self {
        tracing::warn!(file = id, %error, "cannot read");
        Self::unavailable(id, error.to_string())
    }

    /// Returns why a map tile of the file `id` was not drawn.
    pub fn of_drawing(id: &str, error: &DrawError) -> Self {
        match error {
            DrawError::Read(error) => Self::of_read(id, error),
            DrawError::OutOfBudget { .. } => Self::missing(
                id,
                error.to_string(),
                "zoom in; the TileJSON says from which zoom on there are tiles",
            ),
            DrawError::NoGrid(error) => Self::of_grid(id, error),
            DrawError::NoLayer(_) => Self::missing(id, error.to_string(), "ask for another layer"),
            DrawError::TimedOut => Self::busy("the drawing took longer than it may"),
            _ => {
                tracing::error!(file = id, %error, "unexpected");
                Self::defect()
            }
        }
    }

    /// Returns why the file `id` has no tiles in a grid.
    pub fn of_grid(id: &str, error: &NoGrid) -> Self {
        Self::missing(id, error.to_string(), "ask for the grid native")
    }

    fn of_query(id: &str, error: &QueryError) -> Self {
        match error {
            QueryError::Read(error) => Self::of_read(id, error),
            QueryError::NotAPoint { .. } => Self::invalid("point", error.to_string(), "give another point"),
            QueryError::NoTolerance { .. } => Self::invalid("mode", error.to_string(), "give another tolerance"),
            QueryError::NoTriangles { .. } | QueryError::BreakLines { .. } => {
                Self::missing(id, error.to_string(), "query another file")
            }
            _ => {
                tracing::error!(file = id, %error, "unexpected");
                Self::defect()
            }
        }
    }

    fn of_terrain(id: &str, error: &TerrainError) -> Self {
        match error {
            TerrainError::Read(error) => Self::of_read(id, error),
            TerrainError::NoZ { .. } => Self::missing(id, error.to_string(), "query another file"),
            TerrainError::Line { .. } => Self::invalid("from, to", error.to_string(), "give two points that differ"),
            _ => {
                tracing::error!(file = id, %error, "unexpected");
                Self::defect()
            }
        }
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let body = serde_json::to_vec(&self).unwrap_or_default();
        let mut response = (self.status, body).into_response();
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/json"));
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
        let range = self
            .length
            .map(|length| HeaderValue::try_from(format!("bytes */{length}")));
        if let Some(Ok(range)) = range {
            headers.insert(header::CONTENT_RANGE, range);
        }
        if self.status == StatusCode::SERVICE_UNAVAILABLE {
            headers.insert(header::RETRY_AFTER, RETRY_SECONDS.into());
        }
        response
    }
}
