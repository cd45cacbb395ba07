//! The parts of a request.

use std::convert::Infallible;

use axum::extract::{FromRequestParts, MatchedPath, OriginalUri, RawPathParams};
use axum::http::request::Parts;
use axum::http::{HeaderMap, Uri};

use crate::parameters::Parameters;

/// The parts of a request, without its body. It takes the headers from the request.
pub struct Input {
    /// The headers.
    pub headers: HeaderMap,
    /// The address as it came, with the prefix of a router around this one.
    pub original: Uri,
    uri: Uri,
    route: Option<MatchedPath>,
    parts: Option<RawPathParams>,
}

impl<S: Send + Sync> FromRequestParts<S> for Input {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Infallible> {
        // A part that is not UTF-8 names nothing, like one that is missing.
        let of_path = RawPathParams::from_request_parts(parts, state).await.ok();
        let OriginalUri(original) = OriginalUri::from_request_parts(parts, state).await?;
        Ok(Self {
            parts: of_path,
            route: parts.extensions.get().cloned(),
            headers: std::mem::take(&mut parts.headers),
            uri: parts.uri.clone(),
            original,
        })
    }
}

impl Input {
    /// Returns a part of the path; empty if it is missing.
    pub fn part(&self, name: &str) -> &str {
        let mut parts = self.parts.iter().flatten();
        parts.find(|(other, _)| *other == name).map_or("", |(_, value)| value)
    }

    /// Returns the parameters.
    pub fn parameters(&self) -> Parameters {
        Parameters::new(self.uri.query())
    }

    /// Returns the path within this service.
    pub fn path(&self) -> &str {
        self.uri.path()
    }

    /// Returns a text that names the resource: the path within a file and all parameters.
    pub fn resource(&self) -> String {
        format!(
            "{} {} {}",
            self.route.as_ref().map_or("", MatchedPath::as_str),
            self.uri.path(),
            self.uri.query().unwrap_or_default()
        )
    }
}
