//! Queries among obstacles: sites and vertices by walking distance, and shortest paths.

use std::pin::Pin;
use std::sync::Arc;

use futures::stream::{self, Stream};

use super::place::Place;
use super::route::{self, Path};
use super::tiles::Tiles;
use super::wave::{Found, Goal, Part, Places, Step, Wave, What, distance};
use super::{Mode, QueryError, QueryOptions, fast};
use crate::geometry::Point;
use crate::store::{Tile, TileReader, Vertex, VertexId};

/// A site, by walking distance.
#[derive(Clone, Debug, PartialEq)]
pub struct SiteFound {
    /// Its number, from 0 over all inputs.
    pub number: u64,
    /// Its id, if the input gave it one.
    pub id: Option<String>,
    /// The vertex at which it lies.
    pub vertex: Vertex,
    /// How far it is.
    pub distance: Distance,
    /// The way there, if it was asked for.
    pub path: Option<Path>,
}

/// A vertex, by walking distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexFound {
    /// The vertex.
    pub vertex: Vertex,
    /// How far it is.
    pub distance: Distance,
    /// The vertex round which the way to it bends last: its parent in the tree of shortest paths. None: it is seen from the source.
    pub parent: Option<VertexId>,
}

/// A length, with bounds of the true one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// The best guess.
    pub value: f64,
    /// The true one is not less.
    pub lower: f64,
    /// The true one is not more.
    pub upper: f64,
}

impl Distance {
    /// A distance that the wave found, over so many straight legs.
    ///
    /// A leg's length is wrong by two units in the last place at most, and a sum by half a unit more for each leg. Of ways that
    /// differ by less than that, any may have been taken, for each of its bends.
    pub(super) fn of_legs(value: f64, legs: usize) -> Self {
        let error = 8.0 * f64::EPSILON * (legs as f64 + 1.0);
        Self {
            value,
            lower: value * (1.0 - error),
            upper: value * (1.0 + error),
        }
    }
}

/// Whether one may be at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Footing {
    /// One may.
    Free,
    /// It lies in an obstacle.
    InsideObstacle {
        /// The nearest point where one may be, rounded; none if there is none.
        nearest_free: Option<Point>,
    },
}

/// How a question for a path ends.
#[derive(Clone, Debug, PartialEq)]
pub enum PathOutcome {
    /// With a shortest path.
    Found(Path),
    /// Both ends are free, but no way leads from one to the other.
    Unreachable,
    /// An end lies in an obstacle.
    InsideObstacle {
        /// The end.
        point: Point,
        /// The nearest point where one may be, rounded; none if there is none.
        nearest_free: Option<Point>,
    },
}

/// A wave and its tiles.
pub(super) struct Run {
    pub(super) tiles: Tiles,
    pub(super) wave: Box<Wave>,
    pub(super) tile: Arc<Tile>,
    source: Place,
    pub(super) options: QueryOptions,
}

impl Run {
    /// Starts a wave at a free place.
    pub(super) async fn start(
        mut tiles: Tiles,
        source: Place,
        goal: Goal,
        limit: f64,
        options: QueryOptions,
    ) -> Result<Self, QueryError> {
        options.mode.check()?;
        let mut wave = Wave::new(&source, goal, limit, tiles.outside_is_free());
        if options.explored.is_some() {
            wave.keep_parts();
        }
        let tile = tiles.last().await?;
        Ok(Self {
            wave,
            tile,
            tiles,
            source,
            options,
        })
    }

    /// Starts a wave at a point, which must be free.
    pub(super) async fn from_point(
        reader: &TileReader,
        at: Point,
        goal: Goal,
        limit: f64,
        options: QueryOptions,
    ) -> Result<Self, QueryError> {
        let mut tiles = Tiles::new(reader, &options);
        let source = Place::find(&mut tiles, at).await?;
        if !source.is_free {
            let nearest_free = source.nearest_free(&mut tiles).await?;
            return Err(QueryError::InsideObstacle {
                point: at,
                nearest_free,
            });
        }
        Self::start(tiles, source, goal, limit, options).await
    }

    /// The next thing that is found.
    pub(super) async fn next(&mut self) -> Result<Option<Found>, QueryError> {
        loop {
            let found = self.advance().await?;
            self.wave.take_parts();
            if let Some(found) = found {
                return Ok(found);
            }
        }
    }

    /// Takes a step: what it found, or that there is no more, if it came to either.
    async fn advance(&mut self) -> Result<Option<Option<Found>>, QueryError> {
        match self.step()? {
            Step::Found(found) => return Ok(Some(Some(found))),
            Step::Done => return Ok(Some(None)),
            step => {
                let went_on = self.go_on(step).await;
                went_on.map_err(|error| error.at_least(self.wave.front()))?;
            }
        }
        Ok(None)
    }

    /// A step of the wave in the tile at hand.
    pub(super) fn step(&mut self) -> Result<Step, QueryError> {
        let step = self.wave.step(&self.tile);
        if let Some(explored) = &self.options.explored {
            explored.add(self.wave.parts());
        }
        step.map_err(|reason| self.tiles.damaged(self.tile.id(), reason))
    }

    /// Makes ready for the step after one that found nothing.
    pub(super) async fn go_on(&mut self, step: Step) -> Result<(), QueryError> {
        if let Step::Need(id) = step {
            if let Some(width) = self.tiles.width_of_lost(id) {
                // The front of the wave goes through more tiles than the cache holds.
                self.wave.lead(width);
            }
            self.tiles.ask_ahead(id, || self.wave.ahead(id));
            self.tile = self.tiles.get(id).await?;
            return Ok(());
        }
        tokio::task::yield_now().await;
        self.tiles.check_time()
    }

    /// Has the wave keep what it sees.
    pub(super) fn keep_parts(&mut self) {
        self.wave.keep_parts();
    }

    /// What the wave sees next, some parts at a time, whatever it finds; none when it is over.
    pub(super) async fn next_parts(&mut self) -> Result<Option<Vec<Part>>, QueryError> {
        let mut is_over = false;
        loop {
            let parts = self.wave.take_parts();
            if is_over || !parts.is_empty() {
                return Ok((!parts.is_empty()).then_some(parts));
            }
            is_over = self.advance().await?.is_some_and(|found| found.is_none());
        }
    }

    /// Where a root of the wave is, and how long the way to it is.
    pub(super) fn root_at(&self, root: u32) -> (Point, f64) {
        self.wave.root_at(root)
    }

    /// The way to what was found.
    pub(super) async fn path(&mut self, found: &Found, to: &Place) -> Result<Path, QueryError> {
        let mut way = self.wave.way(found.root);
        way.push((to.point, to.vertex()));
        let ends = [&self.source, to];
        let path = route::path(&mut self.tiles, &way, ends, found.length, self.options.certify).await;
        path.map_err(|error| error.at_least(found.length))
    }

    pub(super) fn legs(&self, found: &Found) -> usize {
        self.wave.way(found.root).len()
    }
}

/// A stream that a function makes, one item after the other, until it says that there is no more or fails.
pub(super) fn unfold<S, T, F, G, H>(
    start: F,
    next: G,
) -> impl Stream<Item = Result<T, QueryError>> + Send + Unpin + 'static + use<S, T, F, G, H>
where
    S: Send + 'static,
    T: Send + 'static,
    F: Future<Output = Result<S, QueryError>> + Send + 'static,
    G: Fn(S) -> H + Clone + Send + 'static,
    H: Future<Output = Result<Option<(T, S)>, QueryError>> + Send + 'static,
{
    enum State<F, S> {
        New(F),
        Going(S),
        Over,
    }
    let step = move |state: State<Pin<Box<F>>, S>| {
        let next = next.clone();
        async move {
            let going = match state {
                State::New(start) => start.await,
                State::Going(going) => Ok(going),
                State::Over => return None,
            };
            let made = match going {
                Ok(going) => next(going).await,
                Err(error) => Err(error),
            };
            match made {
                Ok(Some((item, going))) => Some((Ok(item), State::Going(going))),
                Ok(None) => None,
                Err(error) => Some((Err(error), State::Over)),
            }
        }
    };
    Box::pin(stream::unfold(State::New(Box::pin(start)), step))
}

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
    /// In mode [`Fast`](Mode::Fast) they come by the length of their shortest ways along edges ([CDT distance](Self::cdt_distance)), and
    /// equal ones by number, each with that way pulled taut; so their values may be a little out of order, and the *k* first are near
    /// ones, but perhaps not the nearest. In mode [`Within`](Mode::Within) they come as in mode exact.
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
    /// In mode [`Fast`](Mode::Fast) those come whose way as found is not longer than the radius: none that is farther away, but one
    /// that is hardly nearer may be missing; where the lower bounds hold none that is nearer than the radius divided by 2.42 is.
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

    /// Whether one may be at a point, and where one may if not.
    ///
    /// # Errors
    /// As [`shortest_path`](Self::shortest_path).
    pub async fn footing(&self, at: Point, options: QueryOptions) -> Result<Footing, QueryError> {
        let mut tiles = Tiles::new(self, &options);
        let place = Place::find(&mut tiles, at).await?;
        if place.is_free {
            return Ok(Footing::Free);
        }
        let nearest_free = place.nearest_free(&mut tiles).await?;
        Ok(Footing::InsideObstacle { nearest_free })
    }

    /// A shortest path between two points.
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
    pub(super) async fn path_counted(
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
            let source = Place::find(&mut tiles, from).await?;
            if !source.is_free {
                let nearest_free = source.nearest_free(&mut tiles).await?;
                return Err(QueryError::InsideObstacle {
                    point: from,
                    nearest_free,
                });
            }
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
