//! The address of the service, as the client sees it.

use axum::http::{HeaderMap, HeaderName, header};

use super::input::Input;
use crate::options::Options;

/// The request headers from which the address comes.
pub const VARIES: &str = "host, x-forwarded-host, x-forwarded-proto, x-forwarded-prefix";

const FORWARDED_PROTO: HeaderName = HeaderName::from_static("x-forwarded-proto");
const FORWARDED_HOST: HeaderName = HeaderName::from_static("x-forwarded-host");
const FORWARDED_PREFIX: HeaderName = HeaderName::from_static("x-forwarded-prefix");

/// Returns the address of the service, without a slash at its end.
pub fn base(input: &Input, options: &Options) -> String {
    if let Some(url) = &options.public_url {
        return url.trim_end_matches('/').to_owned();
    }
    let proto = first(&input.headers, &FORWARDED_PROTO).filter(|proto| matches!(*proto, "http" | "https"));
    let host = |name| first(&input.headers, name).filter(|host| is_host(host));
    let host = host(&FORWARDED_HOST).or_else(|| host(&header::HOST));
    let host = host.or_else(|| input.original.authority().map(|authority| authority.as_str()));
    let before = first(&input.headers, &FORWARDED_PREFIX).filter(|prefix| is_prefix(prefix));
    let before = before.unwrap_or_default().trim_end_matches('/');
    let nested = input.original.path().strip_suffix(input.path()).unwrap_or_default();
    let (proto, host) = (proto.unwrap_or("http"), host.unwrap_or("localhost"));
    format!("{proto}://{host}{before}{nested}")
}

/// Returns the first of the values of a header, which the proxy nearest to the client wrote.
fn first<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Option<&'a str> {
    let text = headers.get(name)?.to_str().ok()?;
    text.split(',').next().map(str::trim).filter(|text| !text.is_empty())
}

/// Returns whether a text is a host, perhaps with a port, and nothing else.
fn is_host(text: &str) -> bool {
    text.len() <= 255
        && text
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_' | ':' | '[' | ']'))
}

fn is_prefix(text: &str) -> bool {
    let is_part = |c: char| c.is_ascii_alphanumeric() || matches!(c, '/' | '.' | '-' | '_' | '~');
    text.starts_with('/') && !text.starts_with("//") && text.len() <= 255 && text.chars().all(is_part)
}
