//! Limits of one request. A request can lower them only.

use std::future::Future;
use std::time::Duration;

use delaunay_tiles::query::QueryOptions;
use tokio::time::timeout;

use crate::options::Options;
use crate::parameters::{MAX_COUNT, Parameters};
use crate::problem::Problem;

/// The time beyond its limit after which a query that does not end is given up.
const GRACE: Duration = Duration::from_secs(2);

/// What a query may take.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// The number of tiles.
    pub tiles: u64,
    /// The time.
    pub time: Duration,
}

impl Limits {
    /// Returns options of a query with these limits.
    pub fn options(self) -> QueryOptions {
        QueryOptions::default().max_tiles(self.tiles).max_time(self.time)
    }
}

/// Takes the limits of a query.
///
/// # Errors
/// Fails if one is no number.
pub fn query_limits(parameters: &mut Parameters, options: &Options) -> Result<Limits, Problem> {
    let tiles = parameters.count("max-tiles", 0, MAX_COUNT)?.unwrap_or(u64::MAX);
    let time = parameters.count("max-time", 0, MAX_COUNT)?;
    let time = time.map_or(Duration::MAX, Duration::from_millis);
    Ok(Limits {
        tiles: tiles.min(options.max_tiles),
        time: time.min(options.max_time),
    })
}

/// Waits for an answer, but not much longer than `time`.
///
/// # Errors
/// Fails if it takes longer.
pub async fn within<T>(time: Duration, answer: impl Future<Output = T>) -> Result<T, Problem> {
    let answer = timeout(time.saturating_add(GRACE), answer).await;
    answer.map_err(|_| Problem::busy("the answer took longer than it may"))
}
