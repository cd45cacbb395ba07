//! Walking distances between all points of one list and all points of another.
//!
//! The input is two lists of points. The output is a distance, or the reason why there is none, for
//! each pair. The points are located once. Then a wavefront to all points of the longer list starts
//! at each point of the shorter list, because a distance is the same in both directions. If paths
//! are requested, wavefronts start at the points of the first list.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};
use std::thread::available_parallelism;

use futures::stream;
use futures::stream::{Stream, StreamExt, TryStreamExt};
use tokio::task::JoinHandle;

use super::answer::{Distance, Path};
use super::free_space::QueryPoint;
use super::request::{QueryError, QueryOptions, Tiles, unfold};
use super::wavefront::{Goal, QueryPoints, Target, WavefrontRun};
use crate::geometry::Point;
use crate::store::{ReadError, TileReader};

/// The distance of a pair of points.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PairDistance {
    /// The index of the first point in its list.
    pub from_index: usize,
    /// The index of the second point in its list.
    pub to_index: usize,
    /// The distance, or the reason why there is none.
    pub outcome: DistanceOutcome,
    /// A shortest path, if the options request it and there is one.
    pub path: Option<Path>,
}

/// The outcome of a query for a distance.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum DistanceOutcome {
    /// A distance.
    Found(Distance),
    /// Both points are free, but no path connects them.
    Unreachable,
    /// A point is in an obstacle: the first one, or otherwise the second.
    InsideObstacle {
        /// The point.
        point: Point,
        /// The nearest free point, rounded; `None` if no point is free.
        nearest_free: Option<Point>,
    },
    /// The wavefront reached its limit of tiles or time.
    OutOfBudget {
        /// A lower bound of the distance.
        lower_bound: f64,
    },
}

/// The outcome for a goal, and the path there if it is requested.
type Outcome = (DistanceOutcome, Option<Path>);

/// A point of a list, with the nearest free point if it is not free itself.
struct MatrixPoint {
    query_point: QueryPoint,
    nearest_free: Option<Point>,
}

impl MatrixPoint {
    async fn find(tiles: &mut Tiles, point: Point) -> Result<Self, QueryError> {
        let query_point = QueryPoint::find(tiles, point).await?;
        let nearest_free = if query_point.is_free {
            None
        } else {
            query_point.nearest_free(tiles).await?
        };
        Ok(Self {
            query_point,
            nearest_free,
        })
    }
}

/// The data that all wavefronts share.
struct Matrix {
    reader: TileReader,
    options: QueryOptions,
    /// The points where wavefronts start. The points of the other list, which is the longer one
    /// unless paths are requested, are the goals.
    starts: Vec<MatrixPoint>,
    goals: Vec<MatrixPoint>,
    goal_points: QueryPoints,
    /// Whether wavefronts run from the second list to the first.
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
                ends.push(MatrixPoint::find(&mut tiles, point).await?);
            }
        }
        let goal_points = QueryPoints::new(goals.iter().map(|goal: &MatrixPoint| &goal.query_point));
        Ok(Arc::new(Self {
            reader,
            options,
            starts,
            goals,
            goal_points,
            is_swapped,
        }))
    }

    /// Returns the distances between a start and all goals.
    async fn row(self: Arc<Self>, start: usize) -> Result<Vec<PairDistance>, QueryError> {
        let inside = |end: &MatrixPoint| {
            (!end.query_point.is_free).then_some(DistanceOutcome::InsideObstacle {
                point: end.query_point.point,
                nearest_free: end.nearest_free,
            })
        };
        let of_start = inside(&self.starts[start]);
        let found = match of_start {
            Some(_) => self.unreached(),
            None => self.reach_goals(start).await?,
        };
        let pairs = found
            .into_iter()
            .zip(&self.goals)
            .enumerate()
            .map(|(goal, ((found, path), end))| {
                let (of_goal, [from, to]) = (inside(end), [start, goal]);
                let (outcome, [from_index, to_index]) = if self.is_swapped {
                    (of_goal.or(of_start), [to, from])
                } else {
                    (of_start.or(of_goal), [from, to])
                };
                PairDistance {
                    from_index,
                    to_index,
                    outcome: outcome.unwrap_or(found),
                    path,
                }
            });
        Ok(pairs.collect())
    }

    /// Returns the initial outcome of each goal.
    fn unreached(&self) -> Vec<Outcome> {
        vec![(DistanceOutcome::Unreachable, None); self.goals.len()]
    }

    /// Returns the distances from a free start to all goals that a wavefront reaches.
    async fn reach_goals(&self, start: usize) -> Result<Vec<Outcome>, QueryError> {
        let mut outcomes = self.unreached();
        let mut missing = self.goals.iter().filter(|goal| goal.query_point.is_free).count();
        let ended = self.reach(start, &mut outcomes, &mut missing).await;
        if let Err(error) = ended {
            let QueryError::OutOfBudget { lower_bound } = error else {
                return Err(error);
            };
            for (outcome, _) in &mut outcomes {
                if matches!(outcome, DistanceOutcome::Unreachable) {
                    *outcome = DistanceOutcome::OutOfBudget { lower_bound };
                }
            }
        }
        Ok(outcomes)
    }

    async fn reach(&self, start: usize, outcomes: &mut [Outcome], missing: &mut usize) -> Result<(), QueryError> {
        if *missing == 0 {
            return Ok(());
        }
        let source = self.starts[start].query_point.clone();
        let mut tiles = Tiles::new(&self.reader, &self.options);
        tiles.get(source.tile()).await?;
        let goal = Goal::Points(self.goal_points.clone());
        let mut run = WavefrontRun::start(tiles, source, goal, f64::INFINITY, self.options.clone()).await?;
        while let Some(found) = run.next().await? {
            if let Target::Point(goal) = found.target {
                let distance = Distance::of_legs(found.length, run.legs(&found));
                let goal = goal as usize;
                let path = match self.options.paths {
                    true => Some(run.path(&found, &self.goals[goal].query_point).await?),
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

/// A task that is aborted on drop.
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

/// Many-to-many walking distances.
impl TileReader {
    /// Returns the walking distances between all points of `from` and all points of `to`.
    ///
    /// One wavefront starts at each point of the shorter list. (It is the first list if both are
    /// equally long, or if the options request paths.) As many wavefronts run at once as there are
    /// processors, each in its own task. The pairs come wavefront by wavefront, in the order of the
    /// shorter list, and within a wavefront in the order of the other list. So the memory needed is
    /// that of a few wavefronts, not that of all pairs. Which list is shorter can change only the
    /// last bits of a distance: the sum of the same legs is rounded in another order.
    ///
    /// Each wavefront is a query with these options. Locating the points comes before and does not
    /// count towards the limits. A wavefront that reached a limit returns
    /// [`DistanceOutcome::OutOfBudget`] for the goals that it did not reach. Otherwise the stream
    /// ends as [`nearest_sites`](Self::nearest_sites).
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
