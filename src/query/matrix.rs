//! Walking distances between all points of one list and all points of another.
//!
//! The input is two lists of points. The output is a distance, or the reason why there is none, for
//! each pair. The points are located once. Then a search for all points of the longer list starts
//! at each point of the shorter list ([`aimed`](crate::query::aimed)), because a distance is the
//! same in both directions. If paths are requested, searches start at the points of the first list.
//! If both lists are the same, each search looks only for the points after its own, and the other
//! half of the matrix is a mirror image.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};
use std::thread::available_parallelism;

use futures::stream;
use futures::stream::{Stream, StreamExt, TryStreamExt};
use parking_lot::Mutex;
use tokio::task::JoinHandle;

use super::aimed::{AimedRun, Expectation, Targets};
use super::answer::{Distance, Path, distance};
use super::free_space::QueryPoint;
use super::request::{QueryError, QueryOptions, Tiles, unfold};
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

/// The maximum number of points of a list of which the matrix is mirrored: half of it is kept.
const MIRRORED: usize = 1 << 10;

/// The points of a list.
#[derive(Clone, Default)]
struct Ends {
    positions: Vec<QueryPoint>,
    /// The outcome of all pairs with a point, if it is in an obstacle.
    inside: Vec<Option<DistanceOutcome>>,
}

impl Ends {
    async fn find(tiles: &mut Tiles, points: Vec<Point>) -> Result<Self, QueryError> {
        let mut this = Self::default();
        for point in points {
            let position = QueryPoint::find(tiles, point).await?;
            let mut inside = None;
            if !position.is_free {
                let (point, nearest_free) = (position.point, position.nearest_free(tiles).await?);
                inside = Some(DistanceOutcome::InsideObstacle { point, nearest_free });
            }
            this.positions.push(position);
            this.inside.push(inside);
        }
        Ok(this)
    }

    fn len(&self) -> usize {
        self.positions.len()
    }
}

/// The data that all searches share.
struct Matrix {
    reader: TileReader,
    options: QueryOptions,
    /// The points where searches start. The points of the other list, which is the longer one
    /// unless paths are requested, are the goals.
    starts: Ends,
    goals: Ends,
    targets: Targets,
    /// What earlier searches have learnt of detours.
    expectation: Mutex<Option<Expectation>>,
    /// Whether searches run from the second list to the first.
    is_swapped: bool,
    /// Whether the lists are the same, and searches look only for points after their own.
    is_mirrored: bool,
}

impl Matrix {
    async fn find(
        reader: TileReader,
        from: Vec<Point>,
        to: Vec<Point>,
        options: QueryOptions,
    ) -> Result<Arc<Self>, QueryError> {
        options.mode.check()?;
        let mut tiles = Tiles::new(&reader, &QueryOptions::default());
        let is_swapped = to.len() < from.len() && !options.paths;
        let is_mirrored = from == to && from.len() <= MIRRORED && !options.paths;
        let (few, many) = if is_swapped { (to, from) } else { (from, to) };
        let starts = Ends::find(&mut tiles, few).await?;
        let goals = match is_mirrored {
            true => starts.clone(),
            false => Ends::find(&mut tiles, many).await?,
        };
        let points = goals.positions.iter().map(|position| position.point).collect();
        let free = (0..).zip(&goals.inside).filter(|(_, inside)| inside.is_none());
        let targets = Targets::new(points, free.map(|(goal, _)| goal));
        Ok(Arc::new(Self {
            reader,
            options,
            starts,
            goals,
            targets,
            expectation: Mutex::new(None),
            is_swapped,
            is_mirrored,
        }))
    }

    /// Returns whether a search looks for a goal.
    fn is_wanted(&self, start: usize, goal: usize) -> bool {
        self.goals.inside[goal].is_none() && (goal >= start || !self.is_mirrored)
    }

    /// Returns the distances between a start and all goals. If the matrix is mirrored, those before
    /// the start are missing.
    async fn row(self: Arc<Self>, start: usize) -> Result<Vec<PairDistance>, QueryError> {
        let of_start = self.starts.inside[start];
        let mut found: Vec<Outcome> = vec![(DistanceOutcome::Unreachable, None); self.goals.len()];
        if of_start.is_none() {
            self.reach_goals(start, &mut found).await?;
        }
        let pairs = found.into_iter().enumerate().map(|(goal, (found, path))| {
            let (of_goal, [from, to]) = (self.goals.inside[goal], [start, goal]);
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

    /// Finds the distances between a free start and all goals that a search reaches.
    async fn reach_goals(&self, start: usize, outcomes: &mut [Outcome]) -> Result<(), QueryError> {
        let Err(error) = self.reach(start, outcomes).await else {
            return Ok(());
        };
        let QueryError::OutOfBudget { lower_bound } = error else {
            return Err(error);
        };
        let from = self.starts.positions[start].point;
        for (goal, (outcome, _)) in outcomes.iter_mut().enumerate() {
            if self.is_wanted(start, goal) && matches!(outcome, DistanceOutcome::Unreachable) {
                let straight = Distance::of_legs(distance(from, self.goals.positions[goal].point), 1).lower;
                // The bound of the error is that of the goals that the search was looking for.
                *outcome = DistanceOutcome::OutOfBudget {
                    lower_bound: if self.targets.is_one_group() {
                        lower_bound
                    } else {
                        straight
                    },
                };
            }
        }
        Ok(())
    }

    async fn reach(&self, start: usize, outcomes: &mut [Outcome]) -> Result<(), QueryError> {
        let source = self.starts.positions[start].clone();
        let mut tiles = Tiles::new(&self.reader, &self.options);
        let is_wanted: Vec<bool> = (0..self.goals.len()).map(|goal| self.is_wanted(start, goal)).collect();
        tiles.get(source.tile()).await?;
        let here = Expectation::new(tiles.density_at(source.tile()));
        let learnt = *self.expectation.lock();
        let expectation = learnt.map_or(here, |learnt| learnt.with_density_of(here));
        let positions = &self.goals.positions;
        let options = self.options.clone();
        let mut run = AimedRun::new(tiles, source, &self.targets, positions, is_wanted, expectation, options);
        while let Some(reached) = run.next().await? {
            let distance = run.distance(&reached.1);
            let path = match self.options.paths {
                true => run.path(&reached).await?,
                false => None,
            };
            outcomes[reached.0 as usize] = (DistanceOutcome::Found(distance), path);
        }
        *self.expectation.lock() = Some(run.expectation());
        Ok(())
    }
}

/// The half of a mirrored matrix that was found so far, by start and goal.
#[derive(Default)]
struct Mirror(Vec<Vec<DistanceOutcome>>);

impl Mirror {
    /// Completes the next row with what earlier rows have found.
    fn complete(&mut self, mut row: Vec<PairDistance>) -> Vec<PairDistance> {
        let start = self.0.len();
        for (goal, found) in self.0.iter().enumerate() {
            let outcome = &mut row[goal].outcome;
            if matches!(outcome, DistanceOutcome::Unreachable) {
                *outcome = found[start - goal - 1];
            }
        }
        self.0.push(row[start + 1..].iter().map(|pair| pair.outcome).collect());
        row
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
    /// One search starts at each point of the shorter list. (It is the first list if both are
    /// equally long, or if the options request paths.) As many searches run at once as there are
    /// processors, each in its own task. The pairs come search by search, in the order of the
    /// shorter list, and within a search in the order of the other list. So the memory needed is
    /// that of a few searches, not that of all pairs. If both lists are the same, have at most 1,024
    /// points, and no paths are requested, half of the pairs are kept, and are the distances of
    /// their mirror images too. The direction can change only the last bits of a distance: the sum
    /// of the same legs is rounded in another order.
    ///
    /// Each search is a query with these options. Locating the points comes before and does not
    /// count towards the limits. A search that reached a limit returns
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
            let mut mirror = matrix.is_mirrored.then(Mirror::default);
            let rows = stream::iter(0..matrix.starts.len())
                .map(move |start| Owned(tokio::spawn(Arc::clone(&matrix).row(start))))
                .buffered(at_once);
            let rows = rows.map_ok(move |row| match &mut mirror {
                Some(mirror) => mirror.complete(row),
                None => row,
            });
            let pairs = rows.map_ok(|row| stream::iter(row.into_iter().map(Ok::<_, QueryError>)));
            Ok(pairs.try_flatten().boxed())
        };
        unfold(start, |mut pairs| async move {
            let next = pairs.try_next().await?;
            Ok(next.map(|pair| (pair, pairs)))
        })
    }
}
