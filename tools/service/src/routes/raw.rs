//! The bytes of a file, for readers that read it from afar.

use std::ops::Range;
use std::sync::Arc;

use axum::body::Body;
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use axum::response::Response;
use futures::stream;

use super::context::Context;
use super::input::Input;
use crate::catalog::Snapshot;
use crate::limits::Outgoing;
use crate::problem::Problem;
use crate::reply::not_modified;
use crate::state::Service;

/// The number of bytes that are read at once.
const PART: u64 = 256 << 10;

/// Answers with bytes of the file, in one state of it.
///
/// # Errors
/// Fails if the range is not in the file, if the client expects another state, or if the file cannot be
/// read.
pub async fn raw(service: Service, input: Input, method: Method) -> Result<Response, Problem> {
    let mut parameters = input.parameters();
    if !service.options().raw {
        return Err(Problem::no_route());
    }
    let context = Context::new(service, &input, &mut parameters).await?;
    parameters.end()?;
    let tag = context.tag("raw");
    if tag.is_in(&input.headers, &header::IF_MATCH) == Some(false) {
        return Err(Problem::changed(context.id()));
    }
    if tag.is_known(&input.headers) {
        return Ok(not_modified(&tag, context.keep()));
    }
    let length = context.snapshot.reader.file_length();
    // A range of another state is no use; the client gets all.
    let is_current = tag.is_in(&input.headers, &header::IF_RANGE) != Some(false);
    let range = match input
        .headers
        .get(header::RANGE)
        .filter(|_| is_current && method == Method::GET)
    {
        Some(value) => range(value, length)?,
        None => None,
    };
    let mut response = Response::new(Body::empty());
    let headers = response.headers_mut();
    context.add_to(headers, &tag);
    headers.insert(header::ACCEPT_RANGES, HeaderValue::from_static("bytes"));
    headers.insert(
        header::CONTENT_TYPE,
        HeaderValue::from_static("application/octet-stream"),
    );
    let wanted = range.clone().unwrap_or(0..length);
    headers.insert(header::CONTENT_LENGTH, (wanted.end - wanted.start).into());
    if let Some(Range { start, end }) = range {
        let text = format!("bytes {start}-{}/{length}", end - 1);
        add(headers, header::CONTENT_RANGE, &text);
        *response.status_mut() = StatusCode::PARTIAL_CONTENT;
    }
    if method == Method::GET {
        *response.body_mut() = body(&context, wanted).await?;
    }
    Ok(response)
}

fn add(headers: &mut HeaderMap, name: header::HeaderName, text: &str) {
    if let Ok(value) = HeaderValue::from_str(text) {
        headers.insert(name, value);
    }
}

/// Returns the body: bytes that are at hand if they are few, else a stream of parts.
async fn body(context: &Context<'_>, wanted: Range<u64>) -> Result<Body, Problem> {
    let first = wanted.start..wanted.end.min(wanted.start + PART);
    let slot = context.service.slots().enter().await?;
    let bytes = context.snapshot.bytes(first.clone()).await.map_err(|error| {
        tracing::warn!(file = context.id(), %error, "cannot read");
        Problem::unavailable(context.id(), "the file cannot be read")
    })?;
    drop(slot);
    let bytes = context.service.outgoing().hold(bytes)?;
    if first.end == wanted.end {
        return Ok(bytes.into());
    }
    let (service, snapshot) = (context.service.clone(), Arc::clone(&context.snapshot));
    let rest = stream::try_unfold(first.end, move |start| {
        let (service, snapshot) = (service.clone(), Arc::clone(&snapshot));
        let end = wanted.end.min(start + PART);
        async move {
            if start == end {
                return Ok(None);
            }
            let bytes = part(&snapshot, service.outgoing(), start..end).await?;
            Ok::<_, std::io::Error>(Some((bytes, end)))
        }
    });
    let first = stream::iter([Ok(bytes)]);
    Ok(Body::from_stream(futures::StreamExt::chain(first, rest)))
}

/// Reads a part after the first one. An error ends the connection, since the status was sent.
async fn part(snapshot: &Snapshot, outgoing: &Outgoing, range: Range<u64>) -> std::io::Result<bytes::Bytes> {
    let room = outgoing.reserve((range.end - range.start) as usize).await?;
    Ok(room.fill(snapshot.bytes(range).await?))
}

/// Returns the range that a header asks for; `None` if all bytes answer it.
///
/// # Errors
/// Fails if the range is not in the file.
fn range(value: &HeaderValue, length: u64) -> Result<Option<Range<u64>>, Problem> {
    // What is no range of bytes is ignored, as RFC 9110 says.
    let Some(text) = value.to_str().ok().and_then(|text| text.strip_prefix("bytes=")) else {
        return Ok(None);
    };
    // Several ranges are answered with all bytes, as the RFC allows.
    let Some((first, last)) = text.trim().split_once('-') else {
        return Ok(None);
    };
    let number = |text: &str| {
        let is_number = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        // A number that is too large is beyond any end.
        is_number.then(|| text.parse::<u64>().unwrap_or(u64::MAX))
    };
    let range = match (number(first), number(last)) {
        (Some(first), Some(last)) if last < first => return Ok(None),
        (Some(first), Some(last)) => first..last.saturating_add(1).min(length),
        (Some(first), None) if last.is_empty() => first..length,
        (None, Some(count)) if first.is_empty() => length.saturating_sub(count)..length,
        _ => return Ok(None),
    };
    match range.start < range.end {
        true => Ok(Some(range)),
        false => Err(Problem::no_range("it is not in the file", length)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_those_of_rfc_9110() {
        let of = |text: &'static str| range(&HeaderValue::from_static(text), 100).map_err(|problem| problem.status);
        assert_eq!(of("bytes=0-9"), Ok(Some(0..10)));
        assert_eq!(of("bytes=90-"), Ok(Some(90..100)));
        assert_eq!(of("bytes=-5"), Ok(Some(95..100)));
        assert_eq!(of("bytes=-500"), Ok(Some(0..100)));
        assert_eq!(of("bytes=50-99999999999999999999999"), Ok(Some(50..100)));
        for ignored in [
            "lines=1-2",
            "bytes=9-3",
            "bytes=a-b",
            "bytes=",
            "bytes=-",
            "bytes 0-1",
            "bytes=0-1,4-5",
            "bytes=0-,4-5",
        ] {
            assert_eq!(of(ignored), Ok(None), "{ignored}");
        }
        for wrong in ["bytes=100-", "bytes=200-300", "bytes=-0"] {
            assert_eq!(of(wrong), Err(StatusCode::RANGE_NOT_SATISFIABLE), "{wrong}");
        }
    }
}
