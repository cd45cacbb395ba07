//! Options of the service.

use std::thread::available_parallelism;
use std::time::Duration;

/// Limits and options of the service. Its fields may be set after [`Options::default`].
///
/// Memory is bounded by these and by the cache of the [catalogue](crate::Catalog).
///
/// # Examples
///
/// ```
/// use delaunay_tiles_service::Options;
///
/// let mut options = Options::default();
/// options.raw = true;
/// options.cors = vec!["https://maps.example.org".to_owned()];
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Options {
    /// Memory for finished map tiles, in bytes.
    pub finished_bytes: usize,
    /// Whether `/{id}/raw` serves the bytes of the files.
    pub raw: bool,
    /// The origins of pages that may read answers, such as `https://maps.example.org`, or `*` for all.
    pub cors: Vec<String>,
    /// The address of the service as clients see it, such as `https://maps.example.org/tiles`. By
    /// default, it is found from the request and its headers `X-Forwarded-*`.
    pub public_url: Option<String>,
    /// The number of tiles that a query may read.
    pub max_tiles: u64,
    /// The number of tiles that a map tile may be drawn from.
    pub max_picture_tiles: u32,
    /// The time that a request may compute.
    pub max_time: Duration,
    /// The number of requests that compute at once.
    pub at_once: usize,
    /// The number of requests that may wait to compute.
    pub queue: usize,
    /// The number of points that an answer may have.
    pub max_points: usize,
    /// The largest number of sites that a query may ask for.
    pub max_k: u32,
    /// The largest number of pairs of a matrix.
    pub max_pairs: usize,
    /// The number of bytes of a request's body.
    pub max_body: usize,
    /// The number of bytes of answers that wait to be read by their clients.
    pub outgoing_bytes: usize,
    /// The number of connections.
    pub max_connections: usize,
    /// The time for a client to send the head of a request, or its body.
    pub read_timeout: Duration,
    /// The time in which a client must read a part of an answer.
    pub write_timeout: Duration,
    /// The time for running requests when the service ends.
    pub drain: Duration,
}

impl Default for Options {
    fn default() -> Self {
        let processors = available_parallelism().map_or(1, usize::from);
        Self {
            finished_bytes: 64 << 20,
            raw: false,
            cors: Vec::new(),
            public_url: None,
            max_tiles: 500,
            max_picture_tiles: 64,
            max_time: Duration::from_secs(10),
            at_once: processors * 2,
            queue: 64,
            max_points: 100_000,
            max_k: 1000,
            max_pairs: 10_000,
            max_body: 1 << 20,
            outgoing_bytes: 32 << 20,
            max_connections: 1000,
            read_timeout: Duration::from_secs(10),
            write_timeout: Duration::from_secs(10),
            drain: Duration::from_secs(10),
        }
    }
}
