//! Walking distances between all of some points and all of others.
//!
//! Comes in: two lists of points. Goes out: a distance, or why there is none, for each pair. The points are found once; then one
//! wave to all points of the longer list starts at each of the shorter one, for a distance is the same in both directions. Where paths
//! are asked for, waves start at the points of the first list.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};
use std::thread::available_parallelism;

use futures::stream;
use futures::stream::{Stream, StreamExt, TryStreamExt};
use tokio::task::JoinHandle;

use super::answer::{Distance, Path};
use super::free_space::Place;
use super::request::{QueryError, QueryOptions, Tiles, unfold};
use super::wavefront::{Goal, Places, Run, What};
use crate::geometry::Point;
use crate::store::{ReadError, TileReader};

/// How far it is from one of some points to one of others.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PairDistance {
    /// The place of the first point in its list.
    pub from: usize,
    /// The place of the second point in its list.
    pub to: usize,
    /// How far it is.
    pub outcome: DistanceOutcome,
    /// A shortest path, if the options ask for it and there is one.
    pub path: Option<Path>,
}

/// How a question for a distance ends.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum DistanceOutcome {
    /// With a distance.
    Found(Distance),
    /// Both points are free, but no way leads from one to the other.
    Unreachable,
    /// A point lies in an obstacle: the first one, or else the second.
    InsideObstacle {
        /// The point.
        point: Point,
        /// The nearest point where one may be, rounded; none if there is none.
        nearest_free: Option<Point>,
    },
    /// The wave used up the tiles or the time that it may use.
    OutOfBudget {
        /// It is at least as far.
        at_least: f64,
    },
}

/// How far a goal is, and the path there if it is asked for.
type Outcome = (DistanceOutcome, Option<Path>);

/// A point, where it lies, and where one may be if not there.
struct End {
    place: Place,
    nearest_free: Option<Point>,
}

impl End {
    async fn find(tiles: &mut Tiles, point: Point) -> Result<Self, QueryError> {
        let place = Place::find(tiles, point).await?;
        let nearest_free = if place.is_free {
            None
        } else {
            place.nearest_free(tiles).await?
        };
        Ok(Self { place, nearest_free })
    }
}

/// What all waves share.
struct Matrix {
    reader: TileReader,
    options: QueryOptions,
    /// Where waves start, and where to. The ends of the longer list are the goals.
    starts: Vec<End>,
    goals: Vec<End>,
    places: Places,
    /// Whether waves go backwards.
    is_swapped: bool,
}

impl Matrix {
    async fn find(
        reader: TileReader,
        from: Vec<Point>,
        to: Vec<Point>,
        options: QueryOptions,
    ) -> Result<Arc<Self>, QueryError> {
        let mut tiles = Tiles::new(&reader, &QueryOptions::default());
        let is_swapped = to.len() < from.len() && !options.paths;
        let (few, many) = if is_swapped { (to, from) } else { (from, to) };
        let (mut starts, mut goals) = (Vec::new(), Vec::new());
        for (ends, points) in [(&mut starts, few), (&mut goals, many)] {
            for point in points {
                ends.push(End::find(&mut tiles, point).await?);
            }
        }
        let places = Places::new(goals.iter().map(|goal: &End| &goal.place));
        Ok(Arc::new(Self {
            reader,
            options,
            starts,
            goals,
            places,
            is_swapped,
        }))
    }

    /// The distances between a start and all goals.
    async fn row(self: Arc<Self>, start: usize) -> Result<Vec<PairDistance>, QueryError> {
        let inside = |end: &End| {
            (!end.place.is_free).then_some(DistanceOutcome::InsideObstacle {
                point: end.place.point,
                nearest_free: end.nearest_free,
            })
        };
        let of_start = inside(&self.starts[start]);
        let found = match of_start {
            Some(_) => self.unreached(),
            None => self.wave(start).await?,
        };
        let pairs = found
            .into_iter()
            .zip(&self.goals)
            .enumerate()
            .map(|(goal, ((found, path), end))| {
                let (of_goal, [from, to]) = (inside(end), [start, goal]);
                let (outcome, [from, to]) = if self.is_swapped {
                    (of_goal.or(of_start), [to, from])
                } else {
                    (of_start.or(of_goal), [from, to])
                };
                PairDistance {
                    from,
                    to,
                    outcome: outcome.unwrap_or(found),
                    path,
                }
            });
        Ok(pairs.collect())
    }

    /// What there is to tell of goals that nothing is known of.
    fn unreached(&self) -> Vec<Outcome> {
        vec![(DistanceOutcome::Unreachable, None); self.goals.len()]
    }

    /// The distances from a free start to all goals that a wave reaches.
    async fn wave(&self, start: usize) -> Result<Vec<Outcome>, QueryError> {
        let mut outcomes = self.unreached();
        let mut missing = self.goals.iter().filter(|goal| goal.place.is_free).count();
        let ended = self.reach(start, &mut outcomes, &mut missing).await;
        if let Err(error) = ended {
            let QueryError::OutOfBudget { at_least } = error else {
                return Err(error);
            };
            for (outcome, _) in &mut outcomes {
                if matches!(outcome, DistanceOutcome::Unreachable) {
                    *outcome = DistanceOutcome::OutOfBudget { at_least };
                }
            }
        }
        Ok(outcomes)
    }

    async fn reach(&self, start: usize, outcomes: &mut [Outcome], missing: &mut usize) -> Result<(), QueryError> {
        if *missing == 0 {
            return Ok(());
        }
        let source = self.starts[start].place.clone();
        let mut tiles = Tiles::new(&self.reader, &self.options);
        tiles.get(source.tile()).await?;
        let goal = Goal::Places(self.places.clone());
        let mut run = Run::start(tiles, source, goal, f64::INFINITY, self.options.clone()).await?;
        while let Some(found) = run.next().await? {
            if let What::Place(goal) = found.what {
                let distance = Distance::of_legs(found.length, run.legs(&found));
                let goal = goal as usize;
                let path = match self.options.paths {
                    true => Some(run.path(&found, &self.goals[goal].place).await?),
                    false => None,
                };
                outcomes[goal] = (DistanceOutcome::Found(distance), path);
                *missing -= 1;
                if *missing == 0 {
                    break;
                }
            }
        }
        Ok(())
    }
}

/// A task that ends with who waits for it.
struct Owned<T>(JoinHandle<Result<T, QueryError>>);

impl<T> Future for Owned<T> {
    type Output = Result<T, QueryError>;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        Poll::Ready(match ready!(Pin::new(&mut self.0).poll(context)) {
            Ok(result) => result,
            Err(error) if error.is_panic() => std::panic::resume_unwind(error.into_panic()),
            Err(_) => Err(ReadError::Cancelled.into()),
        })
    }
}

impl<T> Drop for Owned<T> {
    fn drop(&mut self) {
        self.0.abort();
    }
}

/// Walking distances of many to many.
impl TileReader {
    /// The walking distances between all points of one list and all of another: many to many.
    ///
    /// One wave goes out from each point of the shorter list (of the first, if both are equally long, or if the options ask for
    /// paths), as many at once as there are processors, each in a task of its own. The pairs come wave by wave, in the order of the shorter list, and
    /// within a wave in the order of the other. So memory is needed for a few waves, and not for all pairs. Which list is
    /// shorter can change the last bits of a distance, and nothing else: sums of the same legs are rounded in another order.
    ///
    /// Each wave is a query with these options; finding the points comes before and is free. A wave that used up what it may use
    /// leaves [`DistanceOutcome::OutOfBudget`] for what it did not reach. Otherwise the stream ends as
    /// [`nearest_sites`](Self::nearest_sites).
    ///
    /// [Examples](crate::query#examples).
    pub fn distance_matrix(
        &self,
        from: Vec<Point>,
        to: Vec<Point>,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<PairDistance, QueryError>> + Send + Unpin + 'static + use<> {
        let start = Matrix::find(self.clone(), from, to, options);
        let start = async move {
            let matrix = start.await?;
            let at_once = available_parallelism().map_or(1, usize::from);
            let rows = stream::iter(0..matrix.starts.len())
                .map(move |start| Owned(tokio::spawn(Arc::clone(&matrix).row(start))))
                .buffered(at_once);
            let pairs = rows.map_ok(|row| stream::iter(row.into_iter().map(Ok::<_, QueryError>)));
            Ok(pairs.try_flatten().boxed())
        };
        unfold(start, |mut pairs| async move {
            let next = pairs.try_next().await?;
            Ok(next.map(|pair| (pair, pairs)))
        })
    }
}
