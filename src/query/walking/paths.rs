//! Shortest paths.

use futures::future::FutureExt;
use futures::stream::Stream;

use super::fast;
use crate::geometry::Point;
use crate::query::answer::{Path, PathOutcome, distance};
use crate::query::free_space::QueryPoint;
use crate::query::request::{Mode, QueryError, QueryOptions, Tiles, unfold};
use crate::query::route;
use crate::query::wavefront::{Goal, QueryPoints, Target, WavefrontRun};
use crate::store::TileReader;

/// Shortest paths.
impl TileReader {
    /// Returns a shortest path between two points.
    ///
    /// [Examples](crate::query#examples).
    ///
    /// # Errors
    /// If a tile cannot be read, an end is not a valid point, the file has no triangles, or a limit
    /// of the options is reached.
    pub fn shortest_path(
        &self,
        from: Point,
        to: Point,
        options: QueryOptions,
    ) -> impl Future<Output = Result<PathOutcome, QueryError>> + Send {
        async move { Ok(self.path_counted(from, to, options).await?.0) }.boxed()
    }

    /// Returns a shortest path between two points, and the number of tiles used.
    pub(crate) async fn path_counted(
        &self,
        from: Point,
        to: Point,
        options: QueryOptions,
    ) -> Result<(PathOutcome, u64), QueryError> {
        let mut tiles = Tiles::new(self, &options);
        // The source is located last, so that its tile is the current one.
        let (to_point, from_point) = (to, from);
        let to = QueryPoint::find(&mut tiles, to).await?;
        let from = QueryPoint::find(&mut tiles, from).await?;
        for (query_point, point) in [(&from, from_point), (&to, to_point)] {
            if !query_point.is_free {
                let nearest_free = query_point.nearest_free(&mut tiles).await?;
                return Ok((PathOutcome::InsideObstacle { point, nearest_free }, tiles.count()));
            }
        }
        if options.mode != Mode::Exact {
            return fast::path(tiles, from, to, options).await;
        }
        if options.explored.is_none() && tiles.sees(&from, &to).await? {
            let way = [&from, &to].map(|query_point| (query_point.point, None));
            let length = distance(from.point, to.point);
            let path = route::path(&mut tiles, &way, [&from, &to], length, options.certify).await;
            let path = path.map_err(|error| error.lower_bound(length))?;
            return Ok((PathOutcome::Found(path), tiles.count()));
        }
        let goal = Goal::Points(QueryPoints::new([&to]));
        let mut run = WavefrontRun::start(tiles, from, goal, f64::INFINITY, options).await?;
        let outcome = match run.next().await? {
            Some(found) => PathOutcome::Found(run.path(&found, &to).await?),
            None => PathOutcome::Unreachable,
        };
        Ok((outcome, run.tiles.count()))
    }

    /// Returns shortest paths from `from` to several points, nearest first, each with the index of
    /// its end in `to`. The first is the path to the nearest of them. Points that are in obstacles
    /// or cannot be reached are left out. The stream ends, and its limits apply, as for
    /// [`nearest_sites`](Self::nearest_sites). In mode [`Fast`](Mode::Fast) all paths are found,
    /// each by a separate search, before the first one comes, and they are ordered by their values.
    ///
    /// [Examples](crate::query#examples).
    pub fn shortest_paths(
        &self,
        from: Point,
        to: Vec<Point>,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<(usize, Path), QueryError>> + Send + Unpin + 'static + use<> {
        fast::by_mode(
            options.mode,
            || fast::paths(self.clone(), from, to.clone(), options.clone()),
            || self.exact_paths(from, to.clone(), options.clone()),
        )
    }

    fn exact_paths(
        &self,
        from: Point,
        to: Vec<Point>,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<(usize, Path), QueryError>> + Send + Unpin + 'static + use<> {
        let reader = self.clone();
        let start = async move {
            let mut tiles = Tiles::new(&reader, &options);
            let mut query_points = Vec::new();
            for &point in &to {
                query_points.push(QueryPoint::find(&mut tiles, point).await?);
            }
            let source = QueryPoint::find_free(&mut tiles, from).await?;
            let goal = Goal::Points(QueryPoints::new(&query_points));
            let run = WavefrontRun::start(tiles, source, goal, f64::INFINITY, options).await?;
            Ok((run, query_points))
        };
        unfold(
            start,
            |(mut run, query_points): (WavefrontRun, Vec<QueryPoint>)| async move {
                let Some(found) = run.next().await? else {
                    return Ok(None);
                };
                let Target::Point(query_point) = found.target else {
                    return Ok(None);
                };
                let path = run.path(&found, &query_points[query_point as usize]).await?;
                Ok(Some(((query_point as usize, path), (run, query_points))))
            },
        )
    }
}
