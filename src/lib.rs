//! Delaunay triangulations larger than memory, kept as tiles in one file.
//!
//! A [`Builder`] takes points in any order, and optionally break lines, walls, obstacles and sites.
//! It writes a `*.tiles` file with *the* (constrained) Delaunay triangulation of this input. The
//! triangulation is exact, and ties are broken by coordinates alone. So it is the same to the last
//! triangle, whatever the tile size, the number of threads, the order of the input or the in-core
//! engine. Each constraint edge records the lines that it comes from, and each triangle its region,
//! which may be a hole. A k-d tree cuts the triangulation into tiles. A [`TileReader`] reads them
//! by byte range, through a cache.
//!
//! # Examples
//!
//! Build a file from points: a square grid of 10,000 points, in tiles of at most 1,000 vertices.
//!
//! ```
//! use delaunay_tiles::input::PointBatch;
//! use delaunay_tiles::{BuildOptions, Builder, Point};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("town.tiles");
//! # tokio::runtime::Runtime::new()?.block_on(async {
//! let grid = (0..10_000).map(|i| Point::new(f64::from(i % 100), f64::from(i / 100)));
//! let batch = PointBatch { records: (0..10_000).collect(), points: grid.collect(), z: vec![] };
//! let mut builder = Builder::new(&path, BuildOptions::default().tile_vertices(1000))?;
//! builder.push(&batch).await?;
//! let summary = builder.finish().await?;
//! assert_eq!(summary.triangles, 2 * 99 * 99);
//! # Ok(())
//! # })
//! # }
//! ```
//!
//! Open the file, locate a point and list the triangles in a rectangle. Readers are cheap to clone
//! and may share a cache. [`TileReader::verify`] proves that the file is the Delaunay triangulation
//! of its vertices.
//!
//! ```
//! use delaunay_tiles::{Cache, Location, OpenOptions, Rect, TileReader};
//! use futures::TryStreamExt;
//!
//! # use delaunay_tiles::input::PointBatch;
//! # use delaunay_tiles::{BuildOptions, Builder, Point};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("town.tiles");
//! # tokio::runtime::Runtime::new()?.block_on(async {
//! # let grid = (0..10_000).map(|i| Point::new(f64::from(i % 100), f64::from(i / 100)));
//! # let batch = PointBatch { records: (0..10_000).collect(), points: grid.collect(), z: vec![] };
//! # let mut builder = Builder::new(&path, BuildOptions::default().tile_vertices(1000))?;
//! # builder.push(&batch).await?;
//! # builder.finish().await?;
//! let cache = Cache::new(256 << 20);
//! let town = TileReader::open(&path, OpenOptions::default().cache(&cache)).await?;
//! let Location::InTriangle(triangle) = town.locate(3.25, 4.5).await? else { panic!("outside") };
//! assert!(triangle.vertices.iter().all(|v| (v.point.x - 3.25).abs() < 1.0));
//!
//! let rect = Rect::new(0.5, 0.5, 2.5, 2.5);
//! let triangles: Vec<_> = town.triangles_in(rect).try_collect().await?;
//! assert_eq!(triangles.len(), 18);
//! town.verify(true).await?;
//! # Ok(())
//! # })
//! # }
//! ```
//!
//! Push lines and obstacles before the points, and find a shortest path. Paths may cross break
//! lines. They bend around walls and obstacles. The interior of an obstacle lies on the left of its
//! ring.
//!
//! ```
//! # use delaunay_tiles::input::{PointBatch, SegmentBatch};
//! # use delaunay_tiles::store::LineKind;
//! # use delaunay_tiles::{BuildOptions, Builder, OpenOptions, PathOutcome, Point, QueryOptions};
//! # use delaunay_tiles::TileReader;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("town.tiles");
//! # tokio::runtime::Runtime::new()?.block_on(async {
//! # let mut builder = Builder::new(&path, BuildOptions::default())?;
//! let c = [[8.0, 6.0], [12.0, 6.0], [12.0, 14.0], [8.0, 14.0]].map(|[x, y]| Point::new(x, y));
//! let ends = vec![[c[0], c[1]], [c[1], c[2]], [c[2], c[3]], [c[3], c[0]]];
//! let house = SegmentBatch { ends, lines: vec![0; 4], ..SegmentBatch::default() };
//! builder.push_segments(&[[Point::new(0.0, 8.0), Point::new(6.0, 8.0)]])?; // a break line
//! builder.push_lines(LineKind::Obstacle, 1, &house)?;
//! # let points = (0..441).map(|i| Point::new(f64::from(i % 21), f64::from(i / 21))).collect();
//! # builder.push(&PointBatch { records: (0..441).collect(), points, z: vec![] }).await?;
//! # builder.finish().await?;
//! # let town = TileReader::open(&path, OpenOptions::default()).await?;
//! // … push points, finish, open
//! let (from, to) = (Point::new(4.0, 10.0), Point::new(16.0, 9.0));
//! let outcome = town.shortest_path(from, to, QueryOptions::default()).await?;
//! let PathOutcome::Found(path) = outcome else { panic!("no path") };
//! assert_eq!(path.points, [from, c[0], c[1], to]);
//! # Ok(())
//! # })
//! # }
//! ```
//!
//! Push sites before the points, and find the `k` nearest sites by walking distance.
//!
//! ```
//! # use delaunay_tiles::input::PointBatch;
//! use delaunay_tiles::input::{SiteBatch, SiteId};
//! use futures::{StreamExt, TryStreamExt};
//!
//! # use delaunay_tiles::{BuildOptions, Builder, OpenOptions, Point, QueryOptions, TileReader};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("town.tiles");
//! # tokio::runtime::Runtime::new()?.block_on(async {
//! # let mut builder = Builder::new(&path, BuildOptions::default())?;
//! let points = [[2.0, 8.0], [18.0, 8.0], [9.0, 1.0]].map(|[x, y]| Point::new(x, y)).to_vec();
//! let ids = (0..3).map(SiteId::Number).collect();
//! builder.push_sites(&SiteBatch { points, ids, ..SiteBatch::default() })?;
//! # let points = (0..441).map(|i| Point::new(f64::from(i % 21), f64::from(i / 21))).collect();
//! # builder.push(&PointBatch { records: (0..441).collect(), points, z: vec![] }).await?;
//! # builder.finish().await?;
//! # let town = TileReader::open(&path, OpenOptions::default()).await?;
//! // … push points, finish, open
//! let (home, k) = (Point::new(3.5, 8.0), 2);
//! let sites = town.nearest_sites(home, QueryOptions::default());
//! let nearest: Vec<_> = sites.take(k).try_collect().await?;
//! assert_eq!([nearest[0].number, nearest[1].number], [0, 2]);
//! # Ok(())
//! # })
//! # }
//! ```
//!
//! Edit a file on disk: the segments of a wall become constraints. Open readers keep the state that
//! they opened.
//!
//! ```
//! use delaunay_tiles::{EditOptions, Editor};
//! use delaunay_tiles::input::SegmentBatch;
//! use delaunay_tiles::store::LineKind;
//!
//! # use delaunay_tiles::input::PointBatch;
//! # use delaunay_tiles::{BuildOptions, Builder, OpenOptions, PathOutcome, Point, QueryOptions};
//! # use delaunay_tiles::TileReader;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("town.tiles");
//! # tokio::runtime::Runtime::new()?.block_on(async {
//! # let mut builder = Builder::new(&path, BuildOptions::default())?;
//! # let points = (0..441).map(|i| Point::new(f64::from(i % 21), f64::from(i / 21))).collect();
//! # builder.push(&PointBatch { records: (0..441).collect(), points, z: vec![] }).await?;
//! # builder.finish().await?;
//! let wall = [Point::new(10.0, 0.0), Point::new(10.0, 14.0)];
//! let walls = SegmentBatch { ends: vec![wall], lines: vec![0], ..SegmentBatch::default() };
//! let mut transaction = Editor::open(&path, EditOptions::default()).await?.begin().await?;
//! transaction.constrain(LineKind::Wall, 0, &walls)?;
//! let summary = transaction.commit().await?;
//! assert_eq!(summary.constraint_edges, 14);
//! # let town = TileReader::open(&path, OpenOptions::default()).await?;
//! # let (from, to) = (Point::new(8.5, 8.0), Point::new(18.0, 8.0));
//! # let outcome = town.shortest_path(from, to, QueryOptions::default()).await?;
//! # let PathOutcome::Found(path) = outcome else { panic!("no path") };
//! # assert_eq!(path.points, [from, wall[1], to]);
//! # Ok(())
//! # })
//! # }
//! ```
//!
//! # Modules
//!
//! | module | contents |
//! | --- | --- |
//! | [`pipeline`] | builds: [`Builder`], its options, progress and summary |
//! | [`input`] | readers of points, lines, polygons and sites |
//! | [`store`] | tile files: [`TileReader`], [`Cache`], verification and digests |
//! | [`query`] | locating points, shortest paths, nearest sites, distance matrices |
//! | [`editor`] | changes of a file on disk: [`Editor`], [`Transaction`] |
//! | [`edit`] | how tiles are changed, and what comes of it |
//! | [`export`] | the triangulation in other programs' formats |
//! | [`terrain`] | the triangulation as a surface: rasters, contours, profiles, volumes |
//! | `map_tiles` | map tiles, drawn (feature `map-tiles`) |
//! | `map_archive` | map tiles as one file, PMTiles (feature `pmtiles`) |
//! | [`constraints`] | checks of polygons, and splitting of lines where they cross |
//! | [`mesh`] | in-core triangulations, with and without constraints |
//! | [`geometry`] | points, rectangles and exact predicates |
//! | [`memory`] | memory budgets |
//! | [`io`] | positional reads and writes, and their backends |
//! | [`shown`] | text from outside, made safe for messages |
//!
//! ```text
//!  input          pipeline                              store               query
//!
//!  LAS  text      divide ▶ conquer ▶ merge ▶ borders    cores  borders      locate
//!  f64  node   ▶   k-d      tiles    seams          ▶   directory       ▶   triangles_in
//!  GeoJSON         tree       │        │                superblock  cache   paths, sites
//!                             └─ mesh ─┘                    │
//!                                                           ▼
//!                  geometry: exact predicates           verify, digest, export
//!                  io: positional reads and writes
//! ```
//!
//! # Cargo features
//!
//! | feature | adds |
//! | --- | --- |
//! | `spade` (default) | crate `spade` as a second in-core engine |
//! | `text` | the reader of text separated by commas, blanks or tabs, and gzip |
//! | `geojson` | the reader of GeoJSON |
//! | `flatgeobuf` | the reader of FlatGeobuf, and the export to it |
//! | `shapefile` | the reader of shapefiles |
//! | `geopackage` | the reader of GeoPackage, with SQLite compiled in; it needs a C compiler |
//! | `wkb` | lines and polygons from memory |
//! | `las` | the reader of LAS and LAZ |
//! | `parquet` | the reader of Parquet and GeoParquet, and the export to GeoParquet |
//! | `geotiff` | the export of rasters to GeoTIFF |
//! | `epsg` | the definitions of EPSG codes |
//! | `map-tiles` | drawing of map tiles: pictures, heights, vector tiles, terrain meshes |
//! | `pmtiles` | map tiles as one file: PMTiles |
//! | `object-store` | tile files on web servers and in S3 |
//! | `serde` | `serde::Serialize` for answers and summaries |
//! | `baselines` | other methods for the same queries, for comparison |
//!
//! The readers of raw f64, of Triangle's `.node` and `.poly` files, of PLY and of OBJ are always
//! available.
//!
//! # Sources
//!
//! The method extends Wu, "I/O-Efficient Algorithm for Constrained Delaunay Triangulation with
//! Applications to Proximity Search" (National University of Singapore, 2004): divide, conquer,
//! merge, constrain. Modules name the papers that they follow.

#![cfg_attr(test, allow(clippy::too_many_lines))]

/// Compiles the examples of the pages.
#[cfg(doctest)]
mod pages {
    #[doc = include_str!("../README.md")]
    struct Readme;
    #[doc = include_str!("../docs/library.md")]
    struct Library;
}

mod collections;
pub mod constraints;
pub mod crs;
pub mod edit;
pub mod editor;
pub mod export;
pub mod geometry;
pub mod input;
pub mod io;
#[cfg(feature = "pmtiles")]
pub mod map_archive;
#[cfg(feature = "map-tiles")]
pub mod map_tiles;
pub mod memory;
pub mod mesh;
pub mod overviews;
pub mod pipeline;
pub mod query;
pub mod shown;
pub mod store;
pub mod terrain;

pub use constraints::{
    ConstraintError, Crossing, Inverted, InvertedPolygons, LinesToSplit, MissingZ, Overlapping, PolygonCheck,
    PolygonFaults, PolygonNormalizer, SplitError, SplitLines, VertexWithoutZ, WithoutZ,
};
pub use edit::{EditError, EditSummary, LineCounts, PointCounts, SiteCounts};
pub use editor::{Durability, EditOptions, Editor, Transaction};
pub use export::{ExportError, ExportOptions};
pub use geometry::{Point, Rect};
pub use memory::{MemoryShortage, MemoryUse, default_memory, peak_memory};
pub use pipeline::{
    BlockTasks, BuildError, BuildOptions, BuildSummary, Builder, ConqueredBlock, Crossings, Description,
    DistributedInput, Duplicates, InputPlan, InputTask, InputTasks, LevelSummary, Phase, PhaseSummary, Planned,
    Progress, Steiner, TaskOptions, TaskStore, UnknownDuplicates, Waits,
};
pub use query::{Distance, Location, Mode, Near, Path, PathOutcome, QueryError, QueryOptions, SiteFound, TriangleRef};
pub use store::{Cache, OpenOptions, ReadError, TileReader, VerifyError};
