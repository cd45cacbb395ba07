//! Delaunay triangulations larger than memory, kept as tiles in one file.
//!
//! Points go in, in any order, and with them break lines, walls, obstacles and sites if there are any; a `*.tiles` file comes
//! out. It holds *the* (constrained) Delaunay triangulation of the set: exact, ties broken by coordinates alone, so that it is
//! the same to the last triangle whatever the tile size, the number of threads, the order of the input or the in-core engine.
//! Each constraint edge knows the lines that it comes from, and each triangle its region, which may be a hole. The file is cut
//! into tiles by a k-d tree, and a service reads it by byte range, through a cache.
//!
//! ```text
//!   input            pipeline                                    store                          query
//!   ┌──────────┐     ┌──────┐   ┌───────┐   ┌─────┐              ┌──────────────────────┐       ┌──────────────┐
//!   │ LAS text │     │divide│   │conquer│   │merge│   ┌───────┐  │ cores borders        │ cache │ locate, path │
//!   │ f64 node ├────▶│ k-d  ├──▶│ tiles ├──▶│seams├──▶│borders├─▶│ directory superblock ├──────▶│ triangles_in │
//!   │ GeoJSON  │     │ tree │   │       │   │     │   │       │  └──────────┬───────────┘       └──────────────┘
//!   └──────────┘     └──────┘   └───┬───┘   └──┬──┘   └───────┘             │ verify, digest, export
//!                                   └── mesh ──┘                            ▼
//!                        geometry: exact predicates              io: positional reads and writes
//! ```
//!
//! # Example
//!
//! ```
//! use delaunay_tiles::input::PointBatch;
//! use delaunay_tiles::{BuildOptions, Builder, Cache, Location, OpenOptions, Point, Rect, TileReader};
//! use futures::TryStreamExt;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("town.tiles");
//! let runtime = tokio::runtime::Runtime::new()?;
//! runtime.block_on(async {
//!     // A square grid of 10,000 points, in tiles of at most 1,000.
//!     let points: Vec<Point> = (0..10_000).map(|i| Point::new(f64::from(i % 100), f64::from(i / 100))).collect();
//!     let batch = PointBatch { records: (0..10_000).collect(), points, z: Vec::new() };
//!     let options = BuildOptions::default().tile_vertices(1000);
//!     let mut builder = Builder::new(&path, options)?;
//!     builder.push(&batch).await?;
//!     let summary = builder.finish().await?;
//!     assert_eq!(summary.triangles, 2 * 99 * 99);
//!
//!     // Readers are cheap to clone, and may share a cache.
//!     let cache = Cache::new(256 << 20);
//!     let town = TileReader::open(&path, OpenOptions::default().cache(&cache)).await?;
//!     let Location::InTriangle(triangle) = town.locate(3.25, 4.5).await? else { panic!("the grid surrounds it") };
//!     assert!(triangle.vertices.iter().all(|v| (v.point.x - 3.25).abs() < 1.0));
//!
//!     let mut found = 0;
//!     let mut triangles = town.triangles_in(Rect::new(0.5, 0.5, 2.5, 2.5));
//!     while let Some(_triangle) = triangles.try_next().await? {
//!         found += 1;
//!     }
//!     assert_eq!(found, 18);
//!
//!     // Proof that the file is the Delaunay triangulation of its vertices.
//!     town.verify(true).await?;
//!     Ok(())
//! })
//! # }
//! ```
//!
//! # Sources
//!
//! The method extends Wu, "I/O-Efficient Algorithm for Constrained Delaunay Triangulation with Applications to Proximity
//! Search" (National University of Singapore, 2004): divide, conquer, merge, constrain. Modules name the papers that they follow.
//!
//! # Features
//!
//! `spade` (default): a second in-core engine. `text`, `geojson`, `las`: readers. The readers of raw f64 and of Triangle's
//! `.node` and `.poly` files are always there. `object-store`: tile files on web servers and in S3.
//! `serde`: answers and summaries serialise. `baselines`: other methods for the same queries, to measure against.

#![cfg_attr(test, allow(clippy::too_many_lines))]

mod collections;
pub mod constraints;
pub mod edit;
pub mod export;
pub mod geometry;
pub mod input;
pub mod io;
pub mod memory;
pub mod mesh;
pub mod pipeline;
pub mod query;
pub mod shown;
pub mod store;

pub use constraints::{
    ConstraintError, Crossing, Inverted, InvertedPolygons, LinesToSplit, MissingZ, PolygonCheck, PolygonFaults,
    SplitError, SplitLines, VertexWithoutZ, WithoutZ,
};
pub use edit::{EditError, EditSummary, Editor};
pub use export::{ExportError, ExportOptions};
pub use geometry::{Point, Rect};
pub use memory::{MemoryShortage, MemoryUse, default_memory, peak_memory};
pub use pipeline::{
    BuildError, BuildOptions, BuildSummary, Builder, Crossings, Description, Duplicates, LevelSummary, Phase,
    PhaseSummary, Progress, Steiner, UnknownDuplicates, Waits,
};
pub use query::{Distance, Location, Mode, Near, Path, PathOutcome, QueryError, QueryOptions, SiteFound, TriangleRef};
pub use store::{Cache, OpenOptions, ReadError, TileReader, VerifyError};
