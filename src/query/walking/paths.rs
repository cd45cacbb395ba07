//! Shortest paths.

use futures::stream::Stream;

use super::fast;
use crate::geometry::Point;
use crate::query::answer::{Path, PathOutcome, distance};
use crate::query::free_space::Place;
use crate::query::request::{Mode, QueryError, QueryOptions, Tiles, unfold};
use crate::query::route;
use crate::query::wavefront::{Goal, Places, Run, What};
use crate::store::TileReader;

/// Shortest paths.
impl TileReader {
    /// A shortest path between two points.
    ///
    /// [Examples](crate::query#examples).
    ///
    /// # Errors
    /// If a tile cannot be read, an end is no point, the file has no triangles, or the options' limits are reached.
    pub async fn shortest_path(
        &self,
        from: Point,
        to: Point,
        options: QueryOptions,
    ) -> Result<PathOutcome, QueryError> {
        Ok(self.path_counted(from, to, options).await?.0)
    }

    /// The same, with how many tiles it took.
    pub(crate) async fn path_counted(
        &self,
        from: Point,
        to: Point,
        options: QueryOptions,
    ) -> Result<(PathOutcome, u64), QueryError> {
        let mut tiles = Tiles::new(self, &options);
        // The last tile is that of the source.
        let (to_point, from_point) = (to, from);
        let to = Place::find(&mut tiles, to).await?;
        let from = Place::find(&mut tiles, from).await?;
        for (place, point) in [(&from, from_point), (&to, to_point)] {
            if !place.is_free {
                let nearest_free = place.nearest_free(&mut tiles).await?;
                return Ok((PathOutcome::InsideObstacle { point, nearest_free }, tiles.count()));
            }
        }
        if options.mode != Mode::Exact {
            return fast::path(tiles, from, to, options).await;
        }
        if options.explored.is_none() && tiles.sees(&from, &to).await? {
            let way = [&from, &to].map(|place| (place.point, None));
            let length = distance(from.point, to.point);
            let path = route::path(&mut tiles, &way, [&from, &to], length, options.certify).await;
            let path = path.map_err(|error| error.at_least(length))?;
            return Ok((PathOutcome::Found(path), tiles.count()));
        }
        let goal = Goal::Places(Places::new([&to]));
        let mut run = Run::start(tiles, from, goal, f64::INFINITY, options).await?;
        let outcome = match run.next().await? {
            Some(found) => PathOutcome::Found(run.path(&found, &to).await?),
            None => PathOutcome::Unreachable,
        };
        Ok((outcome, run.tiles.count()))
    }

    /// Shortest paths from a point to several, nearest first, each with the place of its end in `to`: one to many; the first
    /// is that to the nearest of a set. Those that lie in obstacles or cannot be reached do not come. Ends and limits as
    /// [`nearest_sites`](Self::nearest_sites). In mode [`Fast`](Mode::Fast) each is looked for by itself, before the first comes, and
    /// they come by their values.
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
            let mut places = Vec::new();
            for &point in &to {
                places.push(Place::find(&mut tiles, point).await?);
            }
            let source = Place::find_free(&mut tiles, from).await?;
            let goal = Goal::Places(Places::new(&places));
            let run = Run::start(tiles, source, goal, f64::INFINITY, options).await?;
            Ok((run, places))
        };
        unfold(start, |(mut run, places): (Run, Vec<Place>)| async move {
            let Some(found) = run.next().await? else {
                return Ok(None);
            };
            let What::Place(place) = found.what else {
                return Ok(None);
            };
            let path = run.path(&found, &places[place as usize]).await?;
            Ok(Some(((place as usize, path), (run, places))))
        })
    }
}
