//! Resolving an address to a store and a path in it.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use object_store::aws::AmazonS3Builder;
use object_store::http::HttpBuilder;
use object_store::path::Path;
use object_store::{BackoffConfig, ClientOptions, ObjectStore, RetryConfig};

use crate::io::object::guard::Guard;

/// The time that a request may take.
pub(super) const PATIENCE: Duration = Duration::from_secs(30);
/// How often a failed request is repeated if the server is at fault.
const RETRIES: usize = 3;

/// Returns the store that an address names, and the path in it. A request that takes longer than
/// `timeout` fails and is not repeated.
pub(super) fn resolve(url: &str, timeout: Duration) -> io::Result<(Arc<dyn ObjectStore>, Path)> {
    let invalid = |reason: String| io::Error::new(io::ErrorKind::InvalidInput, format!("{url}: {reason}"));
    let Some((scheme, rest)) = url.split_once("://") else {
        return Err(invalid("this is not an address".to_owned()));
    };
    if rest.contains(['?', '#']) {
        return Err(invalid("addresses with ? or # cannot be read".to_owned()));
    }
    let (host, path) = rest.split_once('/').unwrap_or((rest, ""));
    let path = Path::from_url_path(path).map_err(|error| invalid(error.to_string()))?;
    let retry = RetryConfig {
        backoff: BackoffConfig {
            init_backoff: Duration::from_millis(50),
            max_backoff: Duration::from_secs(5),
            base: 2.0,
        },
        max_retries: RETRIES,
        retry_timeout: timeout,
    };
    // A server that is addressed by https must not redirect to http.
    let client = ClientOptions::new()
        .with_allow_http(scheme == "http")
        .with_timeout(timeout);
    let built: object_store::Result<Arc<dyn ObjectStore>> = match scheme {
        "http" | "https" => HttpBuilder::new()
            .with_url(format!("{scheme}://{host}"))
            .with_client_options(client)
            .with_http_connector(Guard)
            .with_retry(retry)
            .build()
            .map(|store| Arc::new(store) as Arc<dyn ObjectStore>),
        "s3" => AmazonS3Builder::from_env()
            .with_bucket_name(host)
            .with_http_connector(Guard)
            .with_retry(retry)
            .build()
            .map(|store| Arc::new(store) as Arc<dyn ObjectStore>),
        _ => return Err(invalid(format!("{scheme} is none of http, https and s3"))),
    };
    Ok((built.map_err(|error| invalid(error.to_string()))?, path))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOON: Duration = Duration::from_secs(1);

    #[test]
    fn addresses_name_a_store_and_a_path() {
        for (url, path) in [
            ("http://localhost:1234/maps/town%20hall.tiles", "maps/town hall.tiles"),
            ("https://example.org/town.tiles", "town.tiles"),
            ("s3://maps/of/town.tiles", "of/town.tiles"),
        ] {
            assert_eq!(resolve(url, SOON).unwrap().1.as_ref(), path);
        }
        for (url, part) in [
            ("town.tiles", "not an address"),
            ("ftp://example.org/town.tiles", "none of http, https and s3"),
            ("http://example.org/town.tiles?key=1", "?"),
            ("http://example.org/a//b", "empty"),
        ] {
            let error = resolve(url, SOON).unwrap_err().to_string();
            assert!(error.contains(url) && error.contains(part), "{error}");
        }
    }
}
