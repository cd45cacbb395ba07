//! An HTTP service of tile files: map tiles, terrain, queries and byte ranges.
//!
//! `tiletool serve` runs it. Programs mount its [`router`] in services of their own. `docs/service.md`
//! describes the paths, and `/openapi.json` each parameter and answer.
//!
//! ```text
//!   server ──▶ routes ──▶ openapi
//!                │
//!     ┌──────────┼──────────┬──────────┐
//!  parameters  finished   reply      state ──▶ catalog, limits, metrics
//!                           │
//!                         etag        problem: the answer to what cannot be answered
//! ```

mod catalog;
mod etag;
mod finished;
mod limits;
mod metrics;
mod openapi;
mod options;
mod parameters;
mod problem;
mod reply;
mod routes;
mod server;
mod state;

pub use catalog::{Catalog, CatalogError};
pub use options::Options;
pub use server::serve;
pub use state::Service;

/// Returns a router with all paths of the service, to be run alone or within another one.
///
/// URLs in its answers are right under a prefix and behind a proxy: they come from the request, its
/// headers `X-Forwarded-Proto`, `X-Forwarded-Host` and `X-Forwarded-Prefix`, or from
/// [`Options::public_url`].
///
/// # Examples
///
/// ```
/// use axum::Router;
/// use delaunay_tiles::Cache;
/// use delaunay_tiles_service::{Catalog, Options, router};
///
/// # use delaunay_tiles::input::PointBatch;
/// # use delaunay_tiles::{BuildOptions, Builder, Point};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("town.tiles");
/// # tokio::runtime::Runtime::new()?.block_on(async {
/// # let mut builder = Builder::new(&path, BuildOptions::default())?;
/// # let points = (0..100).map(|i| Point::new(f64::from(i % 10), f64::from(i / 10))).collect();
/// # builder.push(&PointBatch { records: (0..100).collect(), points, z: vec![] }).await?;
/// # builder.finish().await?;
/// let catalog = Catalog::open([&path], &Cache::new(64 << 20)).await?;
/// let maps = router(catalog, Options::default());
/// // `/maps/town/query/locate?at=3,4` is answered.
/// let service: Router = Router::new().nest("/maps", maps);
/// # drop(service);
/// # Ok(())
/// # })
/// # }
/// ```
pub fn router(catalog: Catalog, options: Options) -> axum::Router {
    Service::new(catalog, options).router()
}
