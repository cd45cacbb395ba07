//! Questions about many points at once: their tiles are read one after the other, each once, and threads
//! answer for the points of each.
//!
//! ```text
//!   points ──▶ tiles_of_points ──▶ a job per tile ──▶ sorted_walk ──▶ answers
//!                                       ▲                  │
//!                                       └── walks and ─────┘
//!                                           errands to other tiles
//! ```
//!
//! Most walks end in the tile of the point's cell. Those that leave it wait, until all that go on in the
//! same tile are continued together in the next round.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::available_parallelism;

use futures::stream;
use futures::stream::{StreamExt, TryStreamExt};

use super::sorted_walk::{Arrival, visit};
use super::walk::{Locate, Spot, SpotStep};
use crate::geometry::Point;
use crate::query::request::Contradiction;
use crate::store::{Piece, PointsOfTile, ReadError, Tile, TileId, TileReader, spawn};

/// A job has about so many points at most.
const MOST: usize = 1 << 16;
/// The number of tiles that are read ahead of the computing threads.
const AHEAD: usize = 2;
/// A thread looks after so many points whether the answers are still wanted.
const LOOK: usize = 1024;

/// How questions about many points are answered.
///
/// The [example of `TileReader::locate_many`](TileReader::locate_many) uses it.
#[derive(Clone, Copy, Debug, Default)]
pub struct BulkOptions {
    threads: Option<usize>,
}

impl BulkOptions {
    /// Sets the number of threads that compute, at least 1; by default as many as the machine can run at
    /// once. It affects only the time.
    #[must_use]
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = Some(threads.max(1));
        self
    }

    fn thread_count(self) -> usize {
        self.threads
            .unwrap_or_else(|| available_parallelism().map_or(1, usize::from))
    }
}

/// A question about each of many points.
pub(super) trait Question: Send + Sync + 'static {
    type Answer: Copy + Send + 'static;
    /// What has to be asked in another tile, after the walk.
    type Errand: Send + 'static;
    /// What the question needs to know of a tile.
    type InTile;

    fn in_tile(&self, tile: &Tile) -> Self::InTile;

    /// Answers for a point whose walk ended in a tile. `home` is the tile of the point's cell.
    fn answer(&self, at: &At<'_, Self::InTile>, spot: Spot, home: TileId) -> Result<Outcome<Self>, Contradiction>;

    /// Answers for a point in the tile that was asked for.
    fn finish(&self, at: &At<'_, Self::InTile>, errand: Self::Errand) -> Result<Self::Answer, Contradiction>;
}

/// A point, and a tile in which something is known of it.
pub(super) struct At<'a, I> {
    pub(super) tile: &'a Tile,
    pub(super) in_tile: &'a I,
    pub(super) point: Point,
}

/// What a question leads to.
pub(super) enum Outcome<Q: Question + ?Sized> {
    Answer(Q::Answer),
    Ask(TileId, Q::Errand),
}

/// A point for which another tile is needed.
struct Waiting<Q: Question> {
    number: u32,
    home: TileId,
    needs: TileId,
    what: Pending<Q>,
}

enum Pending<Q: Question> {
    Walk(Box<Locate>),
    Errand(Q::Errand),
}

/// Points for which the same tile is needed.
enum Work<Q: Question> {
    Cell(Vec<Piece>),
    Waiting(Vec<Waiting<Q>>),
}

/// What the threads share.
struct Shared<Q> {
    question: Q,
    points: Arc<[Point]>,
    triangles: u64,
    /// Nobody waits for the answers any more.
    is_over: AtomicBool,
}

/// Ends the work of the threads when it is dropped.
struct EndOnDrop<Q>(Arc<Shared<Q>>);

impl<Q> Drop for EndOnDrop<Q> {
    fn drop(&mut self) {
        self.0.is_over.store(true, Ordering::Relaxed);
    }
}

/// What a job has found.
struct Found<Q: Question> {
    answers: Vec<(u32, Q::Answer)>,
    waiting: Vec<Waiting<Q>>,
}

/// The error of a job: the tile is damaged.
type Damaged = (TileId, Contradiction);

/// Asks a question about each point. Returns the answers in the order of the points; `otherwise` for
/// those outside the box around all vertices.
pub(super) async fn ask<Q: Question>(
    reader: &TileReader,
    points: Arc<[Point]>,
    options: BulkOptions,
    question: Q,
    otherwise: Q::Answer,
) -> Result<Vec<Q::Answer>, ReadError> {
    let threads = options.thread_count();
    let groups = reader.tiles_of_points(&points, threads).await?;
    let mut answers = vec![otherwise; points.len()];
    let shared = EndOnDrop(Arc::new(Shared {
        question,
        points,
        triangles: reader.metadata().triangles,
        is_over: AtomicBool::new(false),
    }));
    let mut jobs: Vec<_> = groups.into_iter().map(parts_of).collect();
    while !jobs.is_empty() {
        let tiles = stream::iter(jobs).map(|(id, parts)| async move {
            let tile = reader.tile(id).await?;
            Ok(stream::iter(parts).map(move |part| Ok::<_, ReadError>((Arc::clone(&tile), part))))
        });
        let parts = tiles.buffered(threads + AHEAD).try_flatten();
        let tasks = parts.map_ok(|(tile, part)| {
            let shared = Arc::clone(&shared.0);
            spawn(move || shared.work(&tile, part))
        });
        let mut tasks = std::pin::pin!(tasks.try_buffer_unordered(threads));
        let mut waiting = Vec::new();
        while let Some(found) = tasks.try_next().await? {
            let found = found.map_err(|(tile, contradiction)| reader.damaged(tile, contradiction.to_string()))?;
            for (number, answer) in found.answers {
                answers[number as usize] = answer;
            }
            waiting.extend(found.waiting);
        }
        jobs = by_need(waiting);
    }
    Ok(answers)
}

/// Divides the points in a cell into parts of about the same size.
fn parts_of<Q: Question>(group: PointsOfTile) -> (TileId, Vec<Work<Q>>) {
    let all: usize = group.pieces.iter().map(Piece::len).sum();
    let size = all.div_ceil(all.div_ceil(MOST).max(1));
    let (mut parts, mut part, mut count) = (Vec::new(), Vec::new(), 0);
    for piece in group.pieces {
        count += piece.len();
        part.push(piece);
        if count >= size {
            parts.push(Work::Cell(std::mem::take(&mut part)));
            count = 0;
        }
    }
    if !part.is_empty() {
        parts.push(Work::Cell(part));
    }
    (group.tile, parts)
}

/// Groups the points that wait by the tile that they need.
fn by_need<Q: Question>(mut waiting: Vec<Waiting<Q>>) -> Vec<(TileId, Vec<Work<Q>>)> {
    waiting.sort_unstable_by_key(|point| (point.needs, point.number));
    let mut jobs: Vec<(TileId, Vec<Work<Q>>)> = Vec::new();
    for point in waiting {
        let tile = point.needs;
        if jobs.last().is_none_or(|(last, _)| *last != tile) {
            jobs.push((tile, Vec::new()));
        }
        let Some((_, parts)) = jobs.last_mut() else { continue };
        match parts.last_mut() {
            Some(Work::Waiting(points)) if points.len() < MOST => points.push(point),
            _ => parts.push(Work::Waiting(vec![point])),
        }
    }
    jobs
}

impl<Q: Question> Shared<Q> {
    fn work(&self, tile: &Tile, work: Work<Q>) -> Result<Found<Q>, Damaged> {
        let mut found = Found {
            answers: Vec::new(),
            waiting: Vec::new(),
        };
        let done = match work {
            Work::Cell(pieces) => self.visit_cell(tile, &pieces, &mut found),
            Work::Waiting(waiting) => self.go_on(tile, waiting, &mut found),
        };
        done.map_err(|contradiction| (tile.id(), contradiction))?;
        Ok(found)
    }

    fn is_over(&self, done: usize) -> bool {
        done.is_multiple_of(LOOK) && self.is_over.load(Ordering::Relaxed)
    }

    /// Walks to the points in the cell of a tile.
    fn visit_cell(&self, tile: &Tile, pieces: &[Piece], found: &mut Found<Q>) -> Result<(), Contradiction> {
        let in_tile = self.question.in_tile(tile);
        found.answers.reserve(pieces.iter().map(Piece::len).sum());
        let numbers = pieces.iter().flat_map(Piece::numbers);
        let home = tile.id();
        let mut done = 0;
        visit(tile, self.triangles, &self.points, numbers, |number, point, arrival| {
            done += 1;
            let at = At {
                tile,
                in_tile: &in_tile,
                point,
            };
            match arrival {
                Arrival::There(spot) => found.take(number, home, self.question.answer(&at, spot, home)?),
                Arrival::Leaves(walk, needs) => found.waiting.push(Waiting {
                    number,
                    home,
                    needs,
                    what: Pending::Walk(walk),
                }),
            }
            Ok(!self.is_over(done))
        })
    }

    /// Goes on with points that waited for a tile.
    fn go_on(&self, tile: &Tile, waiting: Vec<Waiting<Q>>, found: &mut Found<Q>) -> Result<(), Contradiction> {
        let in_tile = self.question.in_tile(tile);
        for (Waiting { number, home, what, .. }, done) in waiting.into_iter().zip(0..) {
            if self.is_over(done) {
                break;
            }
            let at = At {
                tile,
                in_tile: &in_tile,
                point: self.points[number as usize].representable(),
            };
            match what {
                Pending::Errand(errand) => found.answers.push((number, self.question.finish(&at, errand)?)),
                Pending::Walk(mut walk) => match walk.step_to_spot(tile)? {
                    SpotStep::There(spot) => found.take(number, home, self.question.answer(&at, spot, home)?),
                    SpotStep::Need(needs) => found.waiting.push(Waiting {
                        number,
                        home,
                        needs,
                        what: Pending::Walk(walk),
                    }),
                },
            }
        }
        Ok(())
    }
}

impl<Q: Question> Found<Q> {
    fn take(&mut self, number: u32, home: TileId, outcome: Outcome<Q>) {
        match outcome {
            Outcome::Answer(answer) => self.answers.push((number, answer)),
            Outcome::Ask(needs, errand) => self.waiting.push(Waiting {
                number,
                home,
                needs,
                what: Pending::Errand(errand),
            }),
        }
    }
}
