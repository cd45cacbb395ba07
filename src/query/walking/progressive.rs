//! A fast answer at once, and the exact answer when it is ready.
//!
//! The output for a query is its fast answer, with bounds and the expected cost of the exact
//! answer; then the exact answer.
//!
//! The exact search enters only triangles through which a path could run that is not longer than
//! the fast one. For a path, they are the triangles that meet the ellipse whose foci are the ends;
//! for *k* sites, those within the distance of the farthest site. The estimate is the number of
//! tiles whose cells meet that area, counted in the directory without reading any tile. The search
//! rarely needs more tiles, and often fewer, because walls hold it back. The expected time is the
//! time of the fast answer per tile, times that number.

use std::time::{Duration, Instant};

use futures::stream::Stream;
use futures::{StreamExt, TryStreamExt};

use super::fast;
use crate::geometry::{Point, Rect};
use crate::query::answer::distance::distance_to_rect;
use crate::query::answer::{PathOutcome, SiteFound};
use crate::query::request::{Mode, QueryError, QueryOptions, unfold};
use crate::store::{Cell, CellContent, TileReader};

/// The expected cost of an answer.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Cost {
    /// The number of different tiles, cached or not.
    pub tiles: u64,
    /// The time.
    pub time: Duration,
}

/// An answer of a progressive query.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Progress<T> {
    /// The answer of mode [`Fast`](Mode::Fast), which comes first.
    Fast {
        /// The answer.
        answer: T,
        /// The expected cost of the exact answer.
        exact: Cost,
    },
    /// The exact answer, which comes last.
    Exact(T),
}

/// Returns the number of tiles with a cell for which `lower_bound` is at most `limit`.
async fn tiles_within(reader: &TileReader, limit: f64, lower_bound: impl Fn(Rect) -> f64) -> Result<u64, QueryError> {
    let mut open: Vec<Cell> = reader.root_cell().into_iter().collect();
    let mut tiles = 0;
    while let Some(cell) = open.pop() {
        if cell.rect.is_empty() || lower_bound(cell.rect) > limit {
            continue;
        }
        match reader.content_of(cell).await? {
            CellContent::Cut(parts) => open.extend(parts),
            CellContent::Tile(_) => tiles += 1,
        }
    }
    Ok(tiles)
}

/// Returns the expected cost of `tiles` tiles, given that `for_tiles` tiles took the time `took`.
fn cost(tiles: u64, took: Duration, for_tiles: u64) -> Cost {
    let each = took.as_secs_f64() / for_tiles.max(1) as f64;
    Cost {
        tiles,
        time: Duration::try_from_secs_f64(each * tiles as f64).unwrap_or(Duration::MAX),
    }
}

/// A query, and which answer comes next.
struct ProgressiveQuery<Q> {
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

impl ProgressiveQuery<[Point; 2]> {
    async fn answer(&mut self) -> Result<Option<Progress<PathOutcome>>, QueryError> {
        let [from, to] = self.question;
        Ok(Some(match std::mem::replace(&mut self.stage, Stage::Over) {
            Stage::Fast => {
                let began = Instant::now();
                let options = self.options.clone().mode(Mode::Fast);
                let (answer, took) = self.reader.path_counted(from, to, options).await?;
                let detour = |cell| distance_to_rect(from, cell) + distance_to_rect(to, cell);
                let tiles = match &answer {
                    PathOutcome::Found(path) => tiles_within(&self.reader, path.distance.upper, detour).await?,
                    PathOutcome::Unreachable => tiles_within(&self.reader, f64::INFINITY, detour).await?,
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

impl ProgressiveQuery<(Point, usize)> {
    async fn answer(&mut self) -> Result<Option<Progress<Vec<SiteFound>>>, QueryError> {
        let (at, count) = self.question;
        Ok(Some(match std::mem::replace(&mut self.stage, Stage::Over) {
            Stage::Fast => {
                let began = Instant::now();
                let options = self.options.clone().mode(Mode::Fast);
                let (answer, took) = fast::first_sites(&self.reader, at, count, options).await?;
                // At least `count` sites are as near as the farthest of these.
                let farthest = answer.iter().map(|site| site.distance.upper).fold(0.0, f64::max);
                let limit = if answer.len() < count { f64::INFINITY } else { farthest };
                let tiles = tiles_within(&self.reader, limit, |cell| distance_to_rect(at, cell)).await?;
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

/// Fast answers at once, and exact answers when they are ready.
impl TileReader {
    /// Returns a path between two points: first that of mode [`Fast`](Mode::Fast), with its bounds
    /// and the expected cost of the exact path, then the exact path. A caller that does not need
    /// the exact path drops the stream. The options' limits apply to each of the two separately;
    /// the mode of the options is ignored.
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
        let query = ProgressiveQuery {
            reader: self.clone(),
            question: [from, to],
            options,
            stage: Stage::Fast,
        };
        unfold(
            async { Ok(query) },
            |mut query: ProgressiveQuery<[Point; 2]>| async move { Ok(query.answer().await?.map(|answer| (answer, query))) },
        )
    }

    /// Returns the `count` nearest sites: first those of mode [`Fast`](Mode::Fast), with their
    /// bounds and the expected cost of the exact answer, then the exact ones; otherwise as
    /// [`shortest_path_progressive`](Self::shortest_path_progressive).
    ///
    /// [Examples](crate::query#examples).
    pub fn nearest_sites_progressive(
        &self,
        at: Point,
        count: usize,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<Progress<Vec<SiteFound>>, QueryError>> + Send + Unpin + 'static + use<> {
        let query = ProgressiveQuery {
            reader: self.clone(),
            question: (at, count),
            options,
            stage: Stage::Fast,
        };
        unfold(
            async { Ok(query) },
            |mut query: ProgressiveQuery<(Point, usize)>| async move {
                Ok(query.answer().await?.map(|answer| (answer, query)))
            },
        )
    }
}
