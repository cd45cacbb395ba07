//! Answers with their headers.

use std::io::Write;

use axum::body::Body;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::Response;
use bytes::Bytes;
use flate2::Compression;
use flate2::write::GzEncoder;

use crate::etag::Tag;
use crate::limits::Outgoing;
use crate::problem::Problem;

/// Shorter answers are not compressed.
const LEAST_COMPRESSED: usize = 1 << 10;
/// Longer answers are compressed on a thread of their own.
const LONG: usize = 64 << 10;

/// The media type of GeoJSON.
pub const GEOJSON: &str = "application/geo+json";
/// The media type of JSON.
pub const JSON: &str = "application/json";

/// How long a client may keep an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// Not without asking whether it changed.
    Ask,
    /// For ever: its URL has its version.
    Forever,
}

/// An answer.
#[derive(Clone, Debug)]
pub struct Reply {
    /// The media type.
    pub media: &'static str,
    /// The body; nothing if the file has nothing there.
    pub bytes: Bytes,
    /// The tag; `None` if the same request may have another answer.
    pub tag: Option<Tag>,
    /// How long a client may keep it.
    pub keep: Keep,
    /// The body compressed with gzip, if that is at hand.
    pub gzipped: Option<Bytes>,
    /// The request headers that it depends on, besides `Accept-Encoding`.
    pub varies: Option<&'static str>,
}

impl Reply {
    /// Creates an answer that depends on nothing but its URL.
    pub fn new(media: &'static str, bytes: impl Into<Bytes>) -> Self {
        Self {
            media,
            bytes: bytes.into(),
            tag: None,
            keep: Keep::Ask,
            gzipped: None,
            varies: None,
        }
    }

    /// Creates an answer of JSON.
    pub fn json(value: &serde_json::Value) -> Self {
        Self::new(JSON, format!("{value}\n"))
    }

    /// Adds a tag, and how long a client may keep the answer.
    pub fn tagged(mut self, tag: Tag, keep: Keep) -> Self {
        (self.tag, self.keep) = (Some(tag), keep);
        self
    }

    /// Returns the response, compressed if the client takes that. Its bytes count as outgoing until they
    /// are sent.
    ///
    /// # Errors
    /// Fails if too many bytes wait for clients.
    pub async fn send(self, request: &HeaderMap, outgoing: &Outgoing) -> Result<Response, Problem> {
        let is_compressible = is_text(self.media);
        let mut response = Response::new(Body::empty());
        let headers = response.headers_mut();
        let mut tag = self.tag;
        if self.bytes.is_empty() {
            *response.status_mut() = StatusCode::NO_CONTENT;
            add_tag(response.headers_mut(), tag.as_ref(), self.keep);
            return Ok(response);
        }
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(self.media));
        if is_compressible {
            headers.insert(header::VARY, HeaderValue::from_static("accept-encoding"));
        }
        if let Some(varies) = self.varies {
            headers.append(header::VARY, HeaderValue::from_static(varies));
        }
        let mut bytes = self.bytes;
        if is_compressible && bytes.len() >= LEAST_COMPRESSED && takes_gzip(request) {
            bytes = match self.gzipped {
                Some(gzipped) => gzipped,
                None => compressed(bytes).await?,
            };
            headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
            tag = tag.map(|tag| tag.compressed());
        }
        add_tag(headers, tag.as_ref(), self.keep);
        headers.insert(header::CONTENT_LENGTH, bytes.len().into());
        *response.body_mut() = outgoing.hold(bytes)?.into();
        Ok(response)
    }
}

/// Returns the response to a client that has the answer.
pub fn not_modified(tag: &Tag, keep: Keep) -> Response {
    let mut response = Response::new(Body::empty());
    *response.status_mut() = StatusCode::NOT_MODIFIED;
    add_tag(response.headers_mut(), Some(tag), keep);
    response
}

/// Adds a tag to headers, and how long the client may keep the answer.
pub fn add_tag(headers: &mut HeaderMap, tag: Option<&Tag>, keep: Keep) {
    if let Some(tag) = tag {
        headers.insert(header::ETAG, tag.value());
    }
    let control = match (keep, tag) {
        (Keep::Forever, Some(_)) => "public, max-age=31536000, immutable",
        (_, Some(_)) => "no-cache",
        (_, None) => "no-store",
    };
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static(control));
}

/// Returns whether answers of a media type become shorter if they are compressed.
fn is_text(media: &str) -> bool {
    media.contains("json") || media.starts_with("text/") || media.contains("vector-tile") || media.contains("mesh")
}

/// Returns whether the client takes gzip.
fn takes_gzip(headers: &HeaderMap) -> bool {
    let values = headers.get_all(header::ACCEPT_ENCODING).iter();
    let texts = values.filter_map(|value| value.to_str().ok());
    texts.flat_map(|text| text.split(',')).any(|coding| {
        let (name, parameter) = coding.split_once(';').unwrap_or((coding, "q=1"));
        let quality = parameter
            .trim()
            .strip_prefix("q=")
            .and_then(|q| q.trim().parse::<f32>().ok());
        name.trim().eq_ignore_ascii_case("gzip") && quality.is_some_and(|quality| quality > 0.0)
    })
}

async fn compressed(bytes: Bytes) -> Result<Bytes, Problem> {
    if bytes.len() < LONG {
        return gzip(&bytes);
    }
    let task = tokio::task::spawn_blocking(move || gzip(&bytes));
    task.await.map_err(|_| Problem::defect())?
}

fn gzip(bytes: &[u8]) -> Result<Bytes, Problem> {
    let mut encoder = GzEncoder::new(Vec::with_capacity(bytes.len() / 4), Compression::fast());
    let written = encoder.write_all(bytes).and_then(|()| encoder.finish());
    written.map(Bytes::from).map_err(|_| Problem::defect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gzip_is_taken_only_if_it_is_asked_for() {
        let takes = |text: &'static str| {
            let mut headers = HeaderMap::new();
            headers.insert(header::ACCEPT_ENCODING, HeaderValue::from_static(text));
            takes_gzip(&headers)
        };
        assert!(takes("gzip") && takes("br, GZIP;q=0.5") && takes("deflate,gzip"));
        assert!(!takes("gzip;q=0") && !takes("br") && !takes("identity, x-gzip"));
        assert!(!takes_gzip(&HeaderMap::new()));
    }
}
