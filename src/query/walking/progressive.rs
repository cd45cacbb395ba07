//! An answer at once, and the exact one when it is ready.
//!
//! In: a question. Out: its fast answer, with bounds and with what the exact one is expected to cost; then the exact one.
//!
//! The exact search only enters triangles through which a way could lead that is not longer than the fast one: for a path, those that meet the
//! ellipse whose foci are the ends, and for *k* sites those within reach of the farthest of them. The tiles whose cells do are counted in the
//! directory, without reading any; there are rarely more to read, and often fewer, since walls hold the search back. The time is what
//! the fast answer took for each tile that it asked for, times these.

use std::time::{Duration, Instant};

use futures::stream::Stream;
use futures::{StreamExt, TryStreamExt};

use super::fast;
use crate::geometry::{Point, Rect};
use crate::query::answer::distance::distance_to_rect;
use crate::query::answer::{PathOutcome, SiteFound};
use crate::query::request::{Mode, QueryError, QueryOptions, unfold};
use crate::store::{Directory, KdNode, TileReader};

/// What an answer is expected to cost.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Cost {
    /// Different tiles, in the cache or not.
    pub tiles: u64,
    /// Time.
    pub time: Duration,
}

/// An answer on the way.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Progress<T> {
    /// The one of mode [`Fast`](Mode::Fast), which comes first.
    Fast {
        /// The answer.
        answer: T,
        /// What the exact one is expected to cost.
        exact: Cost,
    },
    /// The exact one, which comes last.
    Exact(T),
}

/// How many tiles have a cell for which something is at most `limit`.
fn tiles_within(directory: &Directory, limit: f64, at_least: impl Fn(Rect) -> f64) -> u64 {
    let nodes = directory.tree.nodes();
    let mut open = vec![(0, directory.metadata.bounds)];
    let mut tiles = 0;
    while let Some((node, cell)) = open.pop() {
        if cell.is_empty() || at_least(cell) > limit {
            continue;
        }
        match nodes.get(node as usize) {
            Some(&KdNode::X { cut, right }) => {
                open.push((node + 1, Rect { max_x: cut, ..cell }));
                open.push((right, Rect { min_x: cut, ..cell }));
            }
            Some(&KdNode::Y { cut, right }) => {
                open.push((node + 1, Rect { max_y: cut, ..cell }));
                open.push((right, Rect { min_y: cut, ..cell }));
            }
            Some(KdNode::Leaf(_)) => tiles += 1,
            None => {}
        }
    }
    tiles
}

/// The time for so many tiles, given what others took.
fn cost(tiles: u64, took: Duration, for_tiles: u64) -> Cost {
    let each = took.as_secs_f64() / for_tiles.max(1) as f64;
    Cost {
        tiles,
        time: Duration::try_from_secs_f64(each * tiles as f64).unwrap_or(Duration::MAX),
    }
}

/// What was asked, and which answer comes next.
struct Asked<Q> {
    reader: TileReader,
    question: Q,
    options: QueryOptions,
    stage: Stage,
}

enum Stage {
    Fast,
    Exact,
    Over,
}

impl Asked<[Point; 2]> {
    async fn answer(&mut self) -> Result<Option<Progress<PathOutcome>>, QueryError> {
        let [from, to] = self.question;
        Ok(Some(match std::mem::replace(&mut self.stage, Stage::Over) {
            Stage::Fast => {
                let began = Instant::now();
                let options = self.options.clone().mode(Mode::Fast);
                let (answer, took) = self.reader.path_counted(from, to, options).await?;
                let directory = self.reader.directory();
                let around = |limit| {
                    tiles_within(directory, limit, |cell| {
                        distance_to_rect(from, cell) + distance_to_rect(to, cell)
                    })
                };
                let tiles = match &answer {
                    PathOutcome::Found(path) => around(path.distance.upper),
                    PathOutcome::Unreachable => around(f64::INFINITY),
                    PathOutcome::InsideObstacle { .. } => took,
                };
                self.stage = Stage::Exact;
                Progress::Fast {
                    answer,
                    exact: cost(tiles, began.elapsed(), took),
                }
            }
            Stage::Exact => {
                let options = self.options.clone().mode(Mode::Exact);
                Progress::Exact(self.reader.shortest_path(from, to, options).await?)
            }
            Stage::Over => return Ok(None),
        }))
    }
}

impl Asked<(Point, usize)> {
    async fn answer(&mut self) -> Result<Option<Progress<Vec<SiteFound>>>, QueryError> {
        let (at, count) = self.question;
        Ok(Some(match std::mem::replace(&mut self.stage, Stage::Over) {
            Stage::Fast => {
                let began = Instant::now();
                let options = self.options.clone().mode(Mode::Fast);
                let (answer, took) = fast::first_sites(&self.reader, at, count, options).await?;
                // As many are as near as the farthest of these.
                let farthest = answer.iter().map(|site| site.distance.upper).fold(0.0, f64::max);
                let limit = if answer.len() < count { f64::INFINITY } else { farthest };
                let tiles = tiles_within(self.reader.directory(), limit, |cell| distance_to_rect(at, cell));
                self.stage = Stage::Exact;
                Progress::Fast {
                    answer,
                    exact: cost(tiles, began.elapsed(), took),
                }
            }
            Stage::Exact => {
                let options = self.options.clone().mode(Mode::Exact);
                let sites = self.reader.nearest_sites(at, options).take(count);
                Progress::Exact(sites.try_collect().await?)
            }
            Stage::Over => return Ok(None),
        }))
    }
}

/// Answers at once, and exact ones when they are ready.
impl TileReader {
    /// A path between two points: first that of mode [`Fast`](Mode::Fast), with its bounds and what the exact one is expected to cost,
    /// then the exact one. Who has no use for that drops the stream. The options' limits hold for each of the two, and the mode they
    /// name for none.
    ///
    /// The stream ends with an error where [`shortest_path`](Self::shortest_path) fails.
    ///
    /// [Examples](crate::query#examples).
    pub fn shortest_path_progressive(
        &self,
        from: Point,
        to: Point,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<Progress<PathOutcome>, QueryError>> + Send + Unpin + 'static + use<> {
        let asked = Asked {
            reader: self.clone(),
            question: [from, to],
            options,
            stage: Stage::Fast,
        };
        unfold(async { Ok(asked) }, |mut asked: Asked<[Point; 2]>| async move {
            Ok(asked.answer().await?.map(|answer| (answer, asked)))
        })
    }

    /// The `count` nearest sites: first those of mode [`Fast`](Mode::Fast), with their bounds and what the exact answer is expected to
    /// cost, then the exact ones; otherwise as [`shortest_path_progressive`](Self::shortest_path_progressive).
    ///
    /// [Examples](crate::query#examples).
    pub fn nearest_sites_progressive(
        &self,
        at: Point,
        count: usize,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<Progress<Vec<SiteFound>>, QueryError>> + Send + Unpin + 'static + use<> {
        let asked = Asked {
            reader: self.clone(),
            question: (at, count),
            options,
            stage: Stage::Fast,
        };
        unfold(async { Ok(asked) }, |mut asked: Asked<(Point, usize)>| async move {
            Ok(asked.answer().await?.map(|answer| (answer, asked)))
        })
    }
}
