//! Sites and vertices by walking distance.

use futures::stream::Stream;

use super::fast;
use crate::geometry::Point;
use crate::query::answer::{Distance, SiteFound, VertexFound};
use crate::query::free_space::Place;
use crate::query::request::{QueryError, QueryOptions, unfold};
use crate::query::wavefront::{Goal, Run, What};
use crate::store::TileReader;

/// Sites and vertices by walking distance.
impl TileReader {
    /// The sites by their walking distance from a point, the nearest first: *k* nearest are the first *k* of the stream. Sites
    /// that are equally far away, as computed, come by their numbers.
    ///
    /// Tiles are read as the search comes to them, so the first sites cost little. The stream is `Send + 'static`, must be
    /// polled within a tokio runtime, and may be dropped at any time.
    ///
    /// It ends with an error if the point lies in an obstacle, or when the options' limits are reached: what came before
    /// stands, and the error says how far away the rest is at least.
    ///
    /// In mode [`Fast`](crate::query::Mode::Fast) they come by the length of their shortest ways along edges ([CDT distance](Self::cdt_distance)), and
    /// equal ones by number, each with that way pulled taut; so their values may be a little out of order, and the *k* first are near
    /// ones, but perhaps not the nearest. In mode [`Within`](crate::query::Mode::Within) they come as in mode exact.
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
        self.sites_within(at, f64::INFINITY, options)
    }

    /// The sites whose walking distance from a point, as computed, is not larger than `radius`, the nearest first, as
    /// [`nearest_sites`](Self::nearest_sites) gives them.
    ///
    /// In mode [`Fast`](crate::query::Mode::Fast) those come whose way as found is not longer than the radius: none that is farther away, but one
    /// that is hardly nearer may be missing; where the lower bounds hold none that is nearer than the radius divided by 2.42 is.
    ///
    /// [Examples](crate::query#examples).
    pub fn sites_within(
        &self,
        at: Point,
        radius: f64,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<SiteFound, QueryError>> + Send + Unpin + 'static + use<> {
        fast::by_mode(
            options.mode,
            || fast::sites(self.clone(), at, radius, options.clone()),
            || self.exact_sites(at, radius, options.clone()),
        )
    }

    fn exact_sites(
        &self,
        at: Point,
        radius: f64,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<SiteFound, QueryError>> + Send + Unpin + 'static + use<> {
        let reader = self.clone();
        let start = async move { Run::from_point(&reader, at, Goal::Sites, radius, options).await };
        unfold(start, |mut run: Run| async move {
            let Some(found) = run.next().await? else {
                return Ok(None);
            };
            let What::Site { number, id, vertex } = found.what.clone() else {
                return Ok(None);
            };
            let distance = Distance::of_legs(found.length, run.legs(&found));
            let path = if run.options.paths {
                Some(run.path(&found, &Place::at(vertex)).await?)
            } else {
                None
            };
            let site = SiteFound {
                number,
                id,
                vertex,
                distance,
                path,
            };
            Ok(Some((site, run)))
        })
    }

    /// All vertices that can be reached from a point, by walking distance: the tree of shortest paths, in every mode. Ends and limits as
    /// [`nearest_sites`](Self::nearest_sites).
    ///
    /// [Examples](crate::query#examples).
    pub fn vertices_by_distance(
        &self,
        at: Point,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<VertexFound, QueryError>> + Send + Unpin + 'static + use<> {
        let reader = self.clone();
        let start = async move { Run::from_point(&reader, at, Goal::Vertices, f64::INFINITY, options).await };
        unfold(start, |mut run: Run| async move {
            let Some(found) = run.next().await? else {
                return Ok(None);
            };
            let What::Vertex(vertex) = found.what else {
                return Ok(None);
            };
            let found = VertexFound {
                vertex,
                distance: Distance::of_legs(found.length, run.legs(&found)),
                parent: run.wave.root_vertex(found.root),
            };
            Ok(Some((found, run)))
        })
    }
}
