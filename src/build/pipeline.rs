//! The computing side of a build: divide, conquer and merge, borders.
//!
//! Runs on threads of its own; what is to be written goes through a bounded channel, in the order of the file.

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::thread;
use std::time::Instant;

use bytes::Bytes;
use parking_lot::Mutex;
use tokio::sync::mpsc;

use super::border::assemble;
use super::border_log::BorderLog;
use super::divide::{Division, divide};
use super::leaf::{DuplicateFound, OpenSide, conquer, first_duplicate};
use super::merge::merge;
use super::node::{Seam, Workspace};
use super::options::{BuildOptions, Phase};
use super::ordered::{Closed, Ordered};
use super::point_store::PointStore;
use super::schedule::{Board, Task};
use super::summary::LevelSummary;
use super::{BuildError, GENERATION};
use crate::geometry::Rect;
use crate::store::{KdTree, MAX_TILES, TileId};

/// Bytes to append to the file.
#[derive(Debug)]
pub(super) enum Extent {
    Core(Bytes),
    Border(Bytes),
}

/// What is known of a tile, but for its extents.
#[derive(Debug, Default)]
pub(super) struct TileState {
    pub(super) vertices: u32,
    pub(super) core_triangles: u32,
    pub(super) border_triangles: u32,
    pub(super) owned_triangles: u32,
    pub(super) bounds: Option<Rect>,
    open_sides: Vec<OpenSide>,
}

/// What the computing side knows at its end.
#[derive(Debug, Default)]
pub(super) struct Computed {
    pub(super) tree: KdTree,
    pub(super) tiles: Vec<TileState>,
    pub(super) duplicates: u64,
    pub(super) late_triangles: u64,
    /// Bytes of the border log that were written and read back.
    pub(super) spilled_bytes: u64,
    pub(super) levels: Vec<LevelSummary>,
    /// When each phase began that has begun here.
    pub(super) began: Vec<(Phase, Instant)>,
}

type Sender = mpsc::Sender<Extent>;

/// Runs all phases. The channel closes at the end.
///
/// `folder` is where the border log is spilled.
pub(super) fn run(
    mut points: PointStore,
    options: &BuildOptions,
    folder: &Path,
    sender: Sender,
) -> Result<Computed, BuildError> {
    let spilling = |error: io::Error| BuildError::io(folder, "spill the border log in", error);
    let progress = &options.progress;
    let mut began = Vec::new();
    let mut start = |phase, total| {
        began.push((phase, Instant::now()));
        progress.start(phase, total);
    };
    start(Phase::Divide, 0);
    let division = divide(&mut points.items, options.tile_vertices, options.threads);
    let tiles = division.leaves.len();
    if tiles > MAX_TILES as usize {
        return Err(BuildError::TooManyTiles { tiles, max: MAX_TILES });
    }

    start(Phase::Conquer, tiles as u64);
    let log = BorderLog::create(folder, tiles as u32, options.tile_vertices).map_err(spilling)?;
    let conquest = Conquest::new(&division, &points, options, log);
    let window = 2 * options.threads as u32;
    let cores = Ordered::new(window, |_, core| {
        sender.blocking_send(Extent::Core(core)).map_err(|_| Closed)
    });
    on_threads(
        options.threads,
        || conquest.work(&cores),
        || {
            conquest.board.stop();
            cores.close();
        },
    )?;
    let Conquest { log, found, .. } = conquest;
    let mut found = found.into_inner();
    if let Some(error) = found.spilling.take() {
        return Err(spilling(error));
    }
    if found.duplicate {
        // Which leaf found one first depends on the threads; which one is reported does not.
        let leaves = division.leaves.iter().map(|leaf| &points.items[leaf.clone()]);
        let first = leaves.filter_map(|items| first_duplicate(items, &points.attributes));
        if let Some((records, point)) = first.min_by_key(|(records, _)| (records[1], records[0])) {
            return Err(BuildError::Duplicate { records, point });
        }
    }
    if progress.is_cancelled() {
        return Err(BuildError::Cancelled);
    }
    drop(points);

    start(Phase::Borders, tiles as u64);
    let mut log = log.into_inner();
    let (late_triangles, spilled_bytes) = (log.triangle_count(), log.spilled_bytes());
    write_borders(&mut found.tiles, &mut log, options, &sender, spilling)?;
    if progress.is_cancelled() {
        return Err(BuildError::Cancelled);
    }
    start(Phase::Finish, 0);
    Ok(Computed {
        tree: division.tree,
        tiles: found.tiles,
        duplicates: found.duplicates,
        late_triangles,
        spilled_bytes,
        levels: found.levels,
        began,
    })
}

/// Conquers leaves and merges seams.
struct Conquest<'a> {
    board: Board,
    division: &'a Division,
    cells: Vec<Rect>,
    points: &'a PointStore,
    options: &'a BuildOptions,
    log: Mutex<BorderLog>,
    found: Mutex<Found>,
}

/// What tasks have found so far.
#[derive(Default)]
struct Found {
    tiles: Vec<TileState>,
    /// Why the border log could not be spilled.
    spilling: Option<io::Error>,
    levels: Vec<LevelSummary>,
    duplicates: u64,
    /// Whether a tile has a duplicate, where these are an error.
    duplicate: bool,
}

impl<'a> Conquest<'a> {
    fn new(division: &'a Division, points: &'a PointStore, options: &'a BuildOptions, log: BorderLog) -> Self {
        let mut tiles = Vec::new();
        tiles.resize_with(division.leaves.len(), TileState::default);
        Self {
            board: Board::new(&division.tree, options.merge_vertices),
            cells: division.tree.node_cells(),
            division,
            points,
            options,
            log: Mutex::new(log),
            found: Mutex::new(Found {
                tiles,
                ..Found::default()
            }),
        }
    }

    /// One thread's work: tasks until there are no more.
    fn work<F: FnMut(u32, Bytes) -> Result<(), Closed>>(&self, cores: &Ordered<Bytes, F>) {
        let mut workspace = Workspace::new(self.options.engine.create());
        while let Some(task) = self.board.take() {
            let (node, done) = match task {
                Task::Leaf { node, tile } => (node, self.leaf(&mut workspace, node, tile, cores)),
                Task::Merge { node, seams } => (node, self.merge(&mut workspace, node, &seams)),
            };
            match done {
                Ok(seam) if !self.options.progress.is_cancelled() => self.board.done(node, seam),
                _ => {
                    self.board.stop();
                    cores.close();
                    return;
                }
            }
        }
    }

    fn leaf<F: FnMut(u32, Bytes) -> Result<(), Closed>>(
        &self,
        workspace: &mut Workspace,
        node: u32,
        tile: TileId,
        cores: &Ordered<Bytes, F>,
    ) -> Result<Seam, Closed> {
        cores.begin(tile.0)?;
        let _span = tracing::debug_span!("leaf", tile = tile.0).entered();
        let items = &self.points.items[self.division.leaves[tile.0 as usize].clone()];
        let cell = self.cells[node as usize];
        let duplicates = self.options.duplicates;
        let leaf = match conquer(workspace, items, &self.points.attributes, duplicates, tile, cell) {
            Ok(leaf) => leaf,
            Err(DuplicateFound) => {
                self.found.lock().duplicate = true;
                return Err(Closed);
            }
        };
        let core = leaf.core.encode(tile, GENERATION);
        let (vertices, settled) = (leaf.core.points.len(), leaf.core.triangles.len());
        {
            let mut found = self.found.lock();
            found.duplicates += leaf.duplicates;
            found.count(vertices, settled, &leaf.seam);
            found.tiles[tile.0 as usize] = TileState {
                vertices: vertices as u32,
                core_triangles: settled as u32,
                bounds: Some(leaf.bounds),
                open_sides: leaf.open_sides,
                ..TileState::default()
            };
        }
        cores.put(tile.0, core)?;
        self.options.progress.advance(1, items.len() as u64);
        Ok(leaf.seam)
    }

    fn merge(&self, workspace: &mut Workspace, node: u32, seams: &[Seam]) -> Result<Seam, Closed> {
        let _span = tracing::debug_span!("merge", node, seams = seams.len()).entered();
        let vertices = seams.iter().map(|seam| seam.vertices.len()).sum();
        let (late, seam) = merge(workspace, seams, self.cells[node as usize]);
        let appended = self.log.lock().append(&late);
        let mut found = self.found.lock();
        found.count(vertices, late.len(), &seam);
        if let Err(error) = appended {
            found.spilling = Some(error);
            return Err(Closed);
        }
        Ok(seam)
    }
}

impl Found {
    fn count(&mut self, vertices: usize, settled: usize, seam: &Seam) {
        let level = seam.level - 1;
        if self.levels.len() <= level {
            self.levels.resize_with(level + 1, LevelSummary::default);
        }
        let level = &mut self.levels[level];
        level.nodes += 1;
        level.vertices += vertices as u64;
        level.settled += settled as u64;
        level.seam_vertices += seam.vertices.len() as u64;
    }
}

/// Assembles the borders of all tiles, bucket by bucket, and sends them in order.
fn write_borders(
    tiles: &mut [TileState],
    log: &mut BorderLog,
    options: &BuildOptions,
    sender: &Sender,
    spilling: impl Fn(io::Error) -> BuildError,
) -> Result<(), BuildError> {
    let progress = &options.progress;
    let borders = Ordered::new(2 * options.threads as u32, |_, border| {
        sender.blocking_send(Extent::Border(border)).map_err(|_| Closed)
    });
    for number in 0..log.bucket_count() {
        let bucket = log.take_bucket(number).map_err(&spilling)?;
        let group = bucket.tiles();
        let states = &mut tiles[group.start as usize..group.end as usize];
        let next = Mutex::new(group.zip(states));
        let work = || {
            loop {
                let Some((number, state)) = next.lock().next() else {
                    return;
                };
                if progress.is_cancelled() || borders.begin(number).is_err() {
                    borders.close();
                    return;
                }
                let tile = TileId(number);
                let sides = std::mem::take(&mut state.open_sides);
                let border = assemble(tile, state.vertices, state.core_triangles, &sides, bucket.of_tile(tile));
                state.border_triangles = border.draft.triangles.len() as u32;
                state.owned_triangles = state.core_triangles + border.owned;
                state.bounds = state.bounds.map(|bounds| bounds.union(border.bounds));
                if borders.put(number, border.draft.encode(tile, GENERATION)).is_err() {
                    return;
                }
                progress.advance(1, u64::from(state.vertices));
            }
        };
        on_threads(options.threads, work, || borders.close())?;
    }
    Ok(())
}

/// Runs the same work on several threads. A panic in one calls `abort`, so that the others do not wait for it.
fn on_threads(threads: usize, work: impl Fn() + Sync, abort: impl Fn() + Sync) -> Result<(), BuildError> {
    let panicked = Mutex::new(None);
    thread::scope(|scope| {
        for number in 0..threads.max(1) {
            let (work, abort, panicked) = (&work, &abort, &panicked);
            let run = move || {
                if let Err(panic) = catch_unwind(AssertUnwindSafe(work)) {
                    let text = panic.downcast_ref::<String>().map(String::as_str);
                    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
                    *panicked.lock() = Some(text.unwrap_or("a thread panicked").to_owned());
                    abort();
                }
            };
            let thread = thread::Builder::new().name(format!("tile-compute-{number}"));
            if let Err(error) = thread.spawn_scoped(scope, run) {
                // Without any thread of its own the work is done here.
                tracing::warn!(%error, "could not start a computing thread");
                if number == 0 {
                    work();
                }
            }
        }
    });
    match panicked.into_inner() {
        Some(text) => Err(BuildError::Internal(text)),
        None => Ok(()),
    }
}
