//! The parts of a request.

use std::convert::Infallible;

use axum::extract::{FromRequestParts, MatchedPath, OriginalUri, RawPathParams};
use axum::http::request::Parts;
use axum::http::{HeaderMap, Uri};

use crate::parameters::Parameters;

/// The parts of a request, without its body.
pub struct Input {
    /// The headers.
    pub headers: HeaderMap,
    /// The address as it came, with the prefix of a router around this one.
    pub original: Uri,
    uri: Uri,
    route: String,
    parts: Vec<(String, String)>,
}

impl<S: Send + Sync> FromRequestParts<S> for Input {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Infallible> {
        // A part that is not UTF-8 names nothing, like one that is missing.
        let params = RawPathParams::from_request_parts(parts, state).await.ok();
        let named = params
            .iter()
            .flatten()
            .map(|(name, value)| (name.to_owned(), value.to_owned()));
        let OriginalUri(original) = OriginalUri::from_request_parts(parts, state).await?;
        let route = parts.extensions.get::<MatchedPath>();
        Ok(Self {
            parts: named.collect(),
            route: route.map_or("", MatchedPath::as_str).to_owned(),
            headers: parts.headers.clone(),
            uri: parts.uri.clone(),
            original,
        })
    }
}

impl Input {
    /// Returns a part of the path; empty if it is missing.
    pub fn part(&self, name: &str) -> &str {
        let found = self.parts.iter().find(|(other, _)| other == name);
        found.map_or("", |(_, value)| value)
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
            self.route,
            self.uri.path(),
            self.uri.query().unwrap_or_default()
        )
    }
}
