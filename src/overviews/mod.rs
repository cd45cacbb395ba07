//! Overviews: coarser triangulations of the same surface, for those who look at it from afar.
//!
//! In: a tile file. Out: the same file with levels of detail, or unchanged. Each level is the Delaunay
//! triangulation of about a quarter of the vertices of the level below it, down to one tile. It is a
//! whole tile file, made by a [`Builder`](crate::Builder) in a work folder, and lies in the file behind
//! its tiles. [`TileReader::overviews`](crate::TileReader::overviews) lists the levels, and
//! [`TileReader::overview`](crate::TileReader::overview) opens one.
//!
//! ```text
//!   the file ──▶ level 1 ──▶ level 2 ──▶ … one tile      levels: each chosen from the one before
//!      │            │            │
//!      │         seeds ─▶ candidates ─▶ build ─┐         choose: rounds, until a quarter is chosen
//!      │                      ▲                │
//!      │                      └────────────────┘
//!      └──────────▶ errors of all levels ──▶ the file    errors, publish
//! ```
//!
//! **What is chosen.** With z, the surface should stay. A level begins with the corners of the hull and a
//! few vertices that a hash chooses. In each round, every other vertex is compared with the triangulation
//! of those chosen so far. Of neighbours, the one that is farthest from it is a candidate: its difference
//! in z counts more where the triangles are large. The largest candidates are chosen, and the next round
//! begins. So rough ground gets dense in few rounds, and flat ground stays sparse. Without z, a hash
//! chooses. All of this is a function of the set of vertices with their z: neither tiles nor threads,
//! memory or order matter.
//!
//! **How good it is.** Each level knows its largest and its root mean square error over all vertices of
//! the file. `tools/lab/terrain/overviews.py` compares them with those of greedy insertion.
//!
//! An edit makes the overviews of a file stale, because they belong to one generation of it. Whoever
//! [makes](make) them again replaces them.
//!
//! # Example
//!
//! ```
//! use delaunay_tiles::input::PointBatch;
//! use delaunay_tiles::overviews::{OverviewOptions, make};
//! use delaunay_tiles::{BuildOptions, Builder, OpenOptions, Point, TileReader};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("hill.tiles");
//! # tokio::runtime::Runtime::new()?.block_on(async {
//! # let points: Vec<Point> = (0..2500).map(|i| Point::new(f64::from(i % 50), f64::from(i / 50))).collect();
//! # let z = points.iter().map(|p| (p.x / 9.0).sin() + (p.y / 11.0).cos()).collect();
//! # let mut builder = Builder::new(&path, BuildOptions::default().tile_vertices(200))?;
//! # builder.push(&PointBatch { records: (0..2500).collect(), points, z }).await?;
//! # builder.finish().await?;
//! // A file of 2,500 vertices, in tiles of at most 200.
//! make(&path, OverviewOptions::default()).await?;
//! let hill = TileReader::open(&path, OpenOptions::default()).await?;
//! let coarsest = hill.overviews().len() - 1;
//! assert!(hill.overviews()[coarsest].rms_error < 0.2);
//! assert_eq!(hill.overview(coarsest).await?.metadata().tiles, 1);
//! # Ok(())
//! # })
//! # }
//! ```

mod candidates;
mod choose;
mod chosen;
mod error;
mod errors;
mod hash;
mod hull;
mod levels;
mod make;
mod options;
mod publish;
mod verify;
mod work;

pub use error::OverviewError;
pub use make::{OverviewSummary, make, remove};
pub use options::{OverviewOptions, OverviewProgress};
pub use verify::verify;
