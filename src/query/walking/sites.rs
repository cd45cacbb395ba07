//! Sites and vertices by walking distance.

use std::collections::VecDeque;

use futures::stream::{Stream, StreamExt};

use super::fast;
use super::nearest::{self, Outcome};
use crate::geometry::Point;
use crate::query::answer::{Distance, SiteFound, VertexFound};
use crate::query::free_space::QueryPoint;
use crate::query::request::{QueryError, QueryOptions, Tiles, unfold};
use crate::query::wavefront::{Goal, Target, WavefrontRun};
use crate::store::TileReader;

/// Sites in the exact order.
enum ExactSites {
    /// Sites that were found, and the error that ended the search for more.
    Nearest(VecDeque<SiteFound>, Option<QueryError>),
    Wavefront(Box<WavefrontRun>),
}

impl ExactSites {
    async fn next(&mut self) -> Result<Option<SiteFound>, QueryError> {
        let run = match self {
            Self::Nearest(sites, failed) => {
                return match (sites.pop_front(), failed.take()) {
                    (Some(site), error) => {
                        *failed = error;
                        Ok(Some(site))
                    }
                    (None, Some(error)) => Err(error),
                    (None, None) => Ok(None),
                };
            }
            Self::Wavefront(run) => run,
        };
        let Some(found) = run.next().await? else {
            return Ok(None);
        };
        let Target::Site { number, id, vertex } = found.target.clone() else {
            return Ok(None);
        };
        let distance = Distance::of_legs(found.length, run.legs(&found));
        let path = if run.options.paths {
            Some(run.path(&found, &QueryPoint::at(vertex)).await?)
        } else {
            None
        };
        Ok(Some(SiteFound {
            number,
            id,
            vertex,
            distance,
            path,
        }))
    }
}

/// Sites and vertices by walking distance.
impl TileReader {
    /// Returns the sites by walking distance from `at`, nearest first. The *k* nearest sites are
    /// the first *k* items of the stream. Sites with equal computed distances are ordered by their
    /// numbers.
    ///
    /// Tiles are read as the search reaches them, so the first sites cost little. The stream is
    /// `Send + 'static`, must be polled within a tokio runtime, and may be dropped at any time.
    ///
    /// The stream ends with an error if the point is in an obstacle, or when a limit of the options
    /// is reached. The sites that came before are correct, and the error has a lower bound of the
    /// distances of the rest.
    ///
    /// In mode [`Fast`](crate::query::Mode::Fast) the sites are ordered by the length of their
    /// shortest paths along edges ([CDT distance](Self::cdt_distance)), and sites with equal
    /// lengths by number. Each of these paths is then shortened. So the values may be slightly out
    /// of order, and the first *k* sites are near, but perhaps not the nearest. In mode
    /// [`Within`](crate::query::Mode::Within) the sites come as in mode exact.
    ///
    /// ```
    /// # use delaunay_tiles::{BuildOptions, Builder, geometry::Point, input::PointBatch};
    /// use delaunay_tiles::query::QueryOptions;
    /// use delaunay_tiles::store::{OpenOptions, TileReader};
    /// use futures::{StreamExt, TryStreamExt};
    ///
    /// # use delaunay_tiles::input::SiteBatch;
    /// # use delaunay_tiles::input::SiteId;
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("town.tiles");
    /// # tokio::runtime::Runtime::new()?.block_on(async {
    /// # let points: Vec<Point> = (0..100).map(|i| Point::new(f64::from(i % 10), f64::from(i / 10))).collect();
    /// # let mut builder = Builder::new(&path, BuildOptions::default())?;
    /// # builder.push_sites(&SiteBatch { points: points[..20].to_vec(), ids: (0..20).map(SiteId::Number).collect(), ..SiteBatch::default() })?;
    /// # builder.push(&PointBatch { records: (0..100).collect(), points, z: Vec::new() }).await?;
    /// # builder.finish().await?;
    /// let map = TileReader::open(&path, OpenOptions::default()).await?;
    /// let sites = map.nearest_sites(Point { x: 3.0, y: 4.0 }, QueryOptions::default());
    /// let nearest = sites.take(10).try_collect::<Vec<_>>().await?;
    /// assert!(nearest.is_sorted_by(|a, b| a.distance.value <= b.distance.value));
    /// # assert_eq!(nearest.len(), 10);
    /// # Ok(())
    /// # })
    /// # }
    /// ```
    pub fn nearest_sites(
        &self,
        at: Point,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<SiteFound, QueryError>> + Send + Unpin + 'static + use<> {
        let count = options.first.unwrap_or(usize::MAX);
        let sites = fast::by_mode(
            options.mode,
            || fast::sites(self.clone(), at, options.clone()),
            || self.sites_within(at, f64::INFINITY, options.clone()),
        );
        sites.take(count)
    }

    /// Returns the sites whose computed walking distance from `at` is at most `radius`, nearest
    /// first, like [`nearest_sites`](Self::nearest_sites).
    ///
    /// The sites are exact in every mode: one search for all of them takes less time than a
    /// shortened path to each.
    ///
    /// [Examples](crate::query#examples).
    pub fn sites_within(
        &self,
        at: Point,
        radius: f64,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<SiteFound, QueryError>> + Send + Unpin + 'static + use<> {
        let count = options.first.unwrap_or(usize::MAX);
        let reader = self.clone();
        let start = async move {
            options.mode.check()?;
            let mut tiles = Tiles::new(&reader, &options);
            let source = QueryPoint::find_free(&mut tiles, at).await?;
            if radius == f64::INFINITY {
                match nearest::first_sites(&reader, tiles, &source, &options).await? {
                    Outcome::Found(found) => return Ok(ExactSites::Nearest(found.sites.into(), found.failed)),
                    Outcome::Wavefront(back) => tiles = back.unwrap_or_else(|| Tiles::new(&reader, &options)),
                }
            }
            tiles.get(source.tile()).await?;
            let run = WavefrontRun::start(tiles, source, Goal::Sites, radius, options).await?;
            Ok(ExactSites::Wavefront(Box::new(run)))
        };
        let sites = unfold(start, |mut sites: ExactSites| async move {
            Ok(sites.next().await?.map(|site| (site, sites)))
        });
        sites.take(count)
    }

    /// Returns all vertices that can be reached from `at`, by walking distance: the tree of
    /// shortest paths, in every mode. The stream ends, and its limits apply, as for
    /// [`nearest_sites`](Self::nearest_sites).
    ///
    /// [Examples](crate::query#examples).
    pub fn vertices_by_distance(
        &self,
        at: Point,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<VertexFound, QueryError>> + Send + Unpin + 'static + use<> {
        let reader = self.clone();
        let start = async move { WavefrontRun::from_point(&reader, at, Goal::Vertices, f64::INFINITY, options).await };
        unfold(start, |mut run: WavefrontRun| async move {
            let Some(found) = run.next().await? else {
                return Ok(None);
            };
            let Target::Vertex(vertex) = found.target else {
                return Ok(None);
            };
            let found = VertexFound {
                vertex,
                distance: Distance::of_legs(found.length, run.legs(&found)),
                parent: run.wavefront.root_vertex(found.root),
            };
            Ok(Some((found, run)))
        })
    }
}
