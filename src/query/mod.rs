//! Queries on a triangulation on disk.
//!
//! A query is a state machine without I/O. It requests tiles, and a thin async driver reads them
//! through the cache.
//!
//! ```text
//!   walking · matrix · along · area    sites and paths; many to many; along a line; within reach
//!       │
//!       ├──▶ funnel ──▶ edges          answers with bounds: a path along edges, then shortened
//!       ├──▶ aimed                     wavefronts directed towards groups of targets
//!       ├──▶ wavefront ──▶ route       exact search, nearest first; the path, and its proof
//!       │
//!       └──▶ free_space ──▶ locating   where a query starts and ends, and which space is free
//!                │
//!                └──▶ request, answer  options, tiles within their limits; the types of answers
//!
//!   euclidean                          Euclidean nearest neighbours
//!   baselines                          methods from the literature (feature `baselines`)
//! ```
//!
//! # Examples
//!
//! A town with a wall, and a shop on each side of the wall:
//!
//! ```
//! use std::f64::consts::PI;
//!
//! use delaunay_tiles::input::{PointBatch, SegmentBatch, SiteBatch, SiteId};
//! use delaunay_tiles::query::{AreaCover, DistanceOutcome, Footing, PathOutcome, Progress, QueryOptions, Search};
//! use delaunay_tiles::store::LineKind;
//! use delaunay_tiles::{BuildOptions, Builder, OpenOptions, Point, TileReader};
//! use futures::TryStreamExt;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("town.tiles");
//! # tokio::runtime::Runtime::new()?.block_on(async {
//! let mut builder = Builder::new(&path, BuildOptions::default())?;
//! let wall = [Point::new(10.0, 0.0), Point::new(10.0, 14.0)];
//! let walls = SegmentBatch { ends: vec![wall], lines: vec![0], ..SegmentBatch::default() };
//! builder.push_lines(LineKind::Wall, 0, &walls)?;
//! let shops = [Point::new(2.0, 8.0), Point::new(18.0, 8.0)];
//! let ids = (0..2).map(SiteId::Number).collect();
//! builder.push_sites(&SiteBatch { points: shops.to_vec(), ids, ..SiteBatch::default() })?;
//! let points = (0..441).map(|i| Point::new(f64::from(i % 21), f64::from(i / 21))).collect();
//! builder.push(&PointBatch { records: (0..441).collect(), points, z: Vec::new() }).await?;
//! builder.finish().await?;
//! let town = TileReader::open(&path, OpenOptions::default()).await?;
//! let options = QueryOptions::default;
//! let home = Point::new(8.5, 8.0);
//! assert_eq!(town.footing(home, options()).await?, Footing::Free);
//!
//! // The nearest sites, by walking distance and by Euclidean distance.
//! let sites: Vec<_> = town.nearest_sites(home, options()).try_collect().await?;
//! let near: Vec<_> = town.sites_by_euclidean_distance(home, options()).try_collect().await?;
//! let aimed = options().first(1).search("aimed".parse::<Search>()?);
//! assert_eq!(town.nearest_sites(home, aimed).try_collect::<Vec<_>>().await?, sites[..1]);
//! assert_eq!([sites[1].number, near[1].site.unwrap()], [1, 1]);
//! assert!(near[1].distance == 9.5 && sites[1].distance.lower > 16.0);
//!
//! // A proved path that bends round the end of the wall, and a short path along edges.
//! let way = town.shortest_path(home, shops[1], options().certified()).await?;
//! let PathOutcome::Found(way) = way else { panic!("it is free") };
//! assert_eq!(way.points, [home, wall[1], shops[1]]);
//! let along_edges = town.cdt_distance(home, shops[1], options()).await?;
//! assert!(along_edges.is_some_and(|edges| edges.distance.upper >= way.distance.lower));
//!
//! // A fast path with bounds, before the exact one.
//! let mut answers = town.shortest_path_progressive(home, shops[1], options());
//! while let Some(Progress::Fast { answer: PathOutcome::Found(fast), exact }) = answers.try_next().await? {
//!     assert!(fast.distance.upper >= way.distance.lower && exact.tiles > 0);
//! }
//!
//! // Distances between all pairs of points from two lists.
//! let pairs: Vec<_> = town.distance_matrix(vec![home], shops.to_vec(), options()).try_collect().await?;
//! let DistanceOutcome::Found(distance) = pairs[1].outcome else { panic!("it is free") };
//! assert!((distance.value - way.distance.value).abs() < 1e-9);
//!
//! // The nearest site along a street, and the area within reach.
//! let street = [Point::new(0.0, 8.0), Point::new(20.0, 8.0)];
//! let along: Vec<_> = town.nearest_along(street[0], street[1], 1, options()).try_collect().await?;
//! assert!(along.len() == 2 && (along[0].to_t - 0.5).abs() < 1e-9);
//! let area: Vec<_> = town.area_within(home, 5.0, options()).try_collect().await?;
//! let is_near = |point| area.iter().any(|piece| piece.contains(point));
//! assert!(is_near(Point::new(8.0, 4.0)) && !is_near(Point::new(11.0, 8.0)));
//!
//! // The same area as polygons. Their edges are at most 1e-4 of the radius away from arcs.
//! let mut cover = AreaCover::default();
//! town.cover_area(home, 5.0, options(), &mut cover).await?;
//! let polygons = cover.polygons(1e-4);
//! assert!(polygons.len() == 1 && polygons[0].area() < PI * 5.0 * 5.0);
//! # Ok(())
//! # })
//! # }
//! ```

mod aimed;
mod along;
mod answer;
mod area;
#[cfg(feature = "baselines")]
pub mod baselines;
mod edges;
mod euclidean;
mod free_space;
mod funnel;
mod locating;
mod matrix;
mod request;
mod route;
mod walking;
mod wavefront;

pub use along::{AlongInterval, SiteAlong};
pub use answer::{Bend, Distance, Path, PathOutcome, SiteFound, VertexFound};
pub use area::{AreaCover, AreaPiece, AreaPolygon};
pub use edges::{CdtPath, CdtVertex};
pub use euclidean::Near;
pub use free_space::Footing;
#[cfg(feature = "map-tiles")]
pub(crate) use locating::Ground;
pub use locating::{BulkOptions, Location, Place, TriangleRef, triangle_meets};
pub(crate) use locating::{OnSurface, SurfacePart};
pub use matrix::{DistanceOutcome, PairDistance};
pub use request::{Explored, Mode, QueryError, QueryOptions, Search, TilesUsed, UnknownMode, UnknownSearch};
pub use walking::{Cost, Progress};
