//! The intake of points: into memory as long as they fit, then to runs on disk, on a thread of its
//! own.

use std::path::Path;
use std::sync::atomic::Ordering;
use std::{iter, thread};

use tokio::sync::{mpsc, oneshot};

use crate::constraints::error::ConstraintError;
use crate::geometry::{Point, Rect};
use crate::input::PointBatch;
use crate::io::start_thread;
use crate::memory::{Load, Shares};
use crate::pipeline::context::BuildContext;
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::point_store::PointStore;
use crate::pipeline::ingest::spill;
use crate::pipeline::ingest::spill::resplit::{SplitLimits, plan_blocks};
use crate::pipeline::ingest::spill::{Spill, cut};
use crate::pipeline::options::DuplicateRule;
use crate::pipeline::plan::{BlockPlan, Run};
use crate::pipeline::records::FinishedBlocks;
use crate::store::KdTree;

/// Number of batches that may wait for the thread that distributes them.
const BATCHES_AHEAD: usize = 4;

/// The points so far.
#[derive(Debug)]
pub(crate) enum Intake {
    /// The points are in memory. `announced` is the number of points that were announced, or 0.
    Memory { store: PointStore, announced: u64 },
    /// The points are being distributed to runs.
    Spilling(Spilling),
    /// The points arrived in an interrupted build, which is resumed.
    Resumed(BlockPlan, FinishedBlocks),
}

/// A message to the thread that distributes points.
#[derive(Debug)]
enum Incoming {
    Points(PointBatch),
    /// Requests to flush the buffers and to reply with the current runs and the tree of their
    /// cells.
    Flush(oneshot::Sender<(Vec<Run>, KdTree)>),
}

/// The thread that distributes points.
#[derive(Debug)]
pub(crate) struct Spilling {
    /// `None` once all batches have been sent.
    batches: Option<mpsc::Sender<Incoming>>,
    plan: Option<oneshot::Receiver<Result<BlockPlan, BuildError>>>,
    thread: Option<thread::JoinHandle<()>>,
}

impl Drop for Spilling {
    /// Waits for the thread, which ends with the current batch, so that it does not outlive the
    /// work folder.
    fn drop(&mut self) {
        self.batches = None;
        self.plan = None;
        if let Some(thread) = self.thread.take() {
            // The result no longer matters.
            let _ = thread.join();
        }
    }
}

/// The points that have arrived so far.
pub(crate) enum ArrivedPoints<'a> {
    Memory(&'a PointStore),
    Runs(&'a Path, Vec<Run>, KdTree),
}

impl ArrivedPoints<'_> {
    /// Returns the borders between the cells of the points, as far as they are within a rectangle.
    pub(crate) fn borders(&self, within: Rect) -> Vec<[Point; 2]> {
        match self {
            Self::Memory(_) => Vec::new(),
            Self::Runs(_, _, tree) => tree.borders(within),
        }
    }

    /// Passes the points within a rectangle, and possibly others, to `take`.
    pub(crate) fn for_each(&self, within: Rect, take: &mut dyn FnMut(&[Point])) -> Result<(), ConstraintError> {
        match self {
            Self::Memory(store) => {
                let points = store.items.iter().map(|item| item.point);
                let near: Vec<Point> = points.filter(|&point| within.contains(point)).collect();
                take(&near);
                Ok(())
            }
            Self::Runs(folder, runs, _) => runs
                .iter()
                .try_for_each(|run| spill::read_points(run, folder, take))
                .map_err(|error| ConstraintError::io(folder, "read points in", error)),
        }
    }
}

/// All points.
#[derive(Debug)]
pub(crate) enum Points {
    Memory(PointStore),
    Runs(BlockPlan),
    /// Points of an interrupted build, which finished some of the blocks.
    Resumed(BlockPlan, FinishedBlocks),
}

impl Intake {
    /// Creates an empty intake.
    pub(crate) fn new() -> Self {
        Self::Memory {
            store: PointStore::default(),
            announced: 0,
        }
    }

    /// Creates an intake that has the points of these runs of each cell. Other runs are numbered from
    /// `first_run` on.
    pub(crate) fn of_runs(
        cells: KdTree,
        runs: Vec<Vec<Run>>,
        has_z: bool,
        first_run: u32,
        context: &BuildContext,
    ) -> Result<Self, BuildError> {
        let spill = new_spill(cells, first_run, context);
        let spilling = Spilling::start(PointStore::default(), spill.behind(runs, has_z), context)?;
        Ok(Self::Spilling(spilling))
    }

    /// Takes the expected number of points and a sample of them, which may be empty. If there is a
    /// sample and the points will not fit in memory, they go to disk from the first one on.
    pub(crate) fn expect(&mut self, points: u64, sample: Vec<Point>, context: &BuildContext) -> Result<(), BuildError> {
        let Self::Memory { store, announced } = self else {
            return Ok(());
        };
        *announced = points;
        let load = Load {
            points,
            segments: context.segments,
            has_z: false,
        };
        if sample.is_empty() || !store.items.is_empty() || context.memory.points_fit(load) {
            return Ok(());
        }
        let spill = new_spill(cut(&sample, cells_for(load, context)?), context.first_run, context);
        *self = Self::Spilling(Spilling::start(PointStore::default(), spill, context)?);
        Ok(())
    }

    /// Takes a batch.
    pub(crate) async fn push(&mut self, batch: &PointBatch, context: &BuildContext) -> Result<(), BuildError> {
        match self {
            Self::Resumed(..) => return Err(BuildError::PointsComplete),
            Self::Spilling(spilling) => return spilling.push(batch).await,
            Self::Memory { .. } => {}
        }
        let Self::Memory { store, announced } = self else {
            return Ok(());
        };
        let room = store.items.len() + batch.points.len() <= PointStore::MAX_POINTS;
        if room {
            store.push(batch);
        }
        let load = Load {
            points: store.items.len() as u64,
            segments: context.segments,
            has_z: store.attributes.has_z(),
        };
        if room && context.memory.fits(load, store.byte_size()) {
            return Ok(());
        }
        let cells = if *announced > load.points {
            let points = *announced;
            cells_for(Load { points, ..load }, context)?
        } else {
            context.memory.most_cells()
        };
        let store = std::mem::take(store);
        let step = store.items.len().div_ceil(spill::SAMPLE).max(1);
        let sample: Vec<Point> = store.items.iter().step_by(step).map(|item| item.point).collect();
        let spill = new_spill(cut(&sample, cells), context.first_run, context);
        let mut spilling = Spilling::start(store, spill, context)?;
        if !room {
            spilling.push(batch).await?;
        }
        *self = Self::Spilling(spilling);
        Ok(())
    }

    /// Returns the points that have arrived so far. A resumed build has none.
    pub(crate) async fn arrived<'a>(&'a mut self, context: &'a BuildContext) -> Result<ArrivedPoints<'a>, BuildError> {
        let folder = context.folder.spill();
        match self {
            Self::Memory { store, .. } => Ok(ArrivedPoints::Memory(store)),
            Self::Spilling(spilling) => {
                let (runs, tree) = spilling.flush().await?;
                Ok(ArrivedPoints::Runs(folder, runs, tree))
            }
            Self::Resumed(..) => Ok(ArrivedPoints::Runs(folder, Vec::new(), KdTree::default())),
        }
    }

    /// Returns all points, once all have arrived.
    pub(crate) async fn finish(self) -> Result<Points, BuildError> {
        match self {
            Self::Memory { store, .. } => Ok(Points::Memory(store)),
            Self::Spilling(spilling) => Ok(Points::Runs(spilling.finish().await?)),
            Self::Resumed(plan, finished) => Ok(Points::Resumed(plan, finished)),
        }
    }
}

impl Spilling {
    fn start(store: PointStore, mut spill: Spill, context: &BuildContext) -> Result<Self, BuildError> {
        let (batches, incoming) = mpsc::channel(BATCHES_AHEAD);
        let (reply, plan) = oneshot::channel::<Result<BlockPlan, BuildError>>();
        let path = context.folder.spill().to_owned();
        let context = context.clone();
        let work = move || {
            let pushed = spill.push_store(&store, context.options.threads);
            drop(store);
            let spilled = pushed.map_err(|error| cannot_spill(context.folder.spill(), error));
            let plan = spilled.and_then(|()| distribute(spill, incoming, &context, || reply.is_closed()));
            // Before the reply: its receiver may remove the folder.
            drop(context);
            // The receiver may have been dropped.
            let _ = reply.send(plan);
        };
        let thread = start_thread("tile-spill", work)
            .map_err(|error| BuildError::io(&path, "start a thread to spill to", error))?;
        Ok(Self {
            batches: Some(batches),
            plan: Some(plan),
            thread: Some(thread),
        })
    }

    async fn push(&mut self, batch: &PointBatch) -> Result<(), BuildError> {
        if let Some(batches) = &self.batches
            && batches.send(Incoming::Points(batch.clone())).await.is_ok()
        {
            return Ok(());
        }
        // The thread ended early; its result tells why.
        match self.plan().await {
            Err(error) => Err(error),
            Ok(_) => Err(gone()),
        }
    }

    /// Flushes all points to the disk. Returns their runs and the tree of their cells.
    async fn flush(&mut self) -> Result<(Vec<Run>, KdTree), BuildError> {
        let (reply, runs) = oneshot::channel();
        if let Some(batches) = &self.batches
            && batches.send(Incoming::Flush(reply)).await.is_ok()
            && let Ok(runs) = runs.await
        {
            return Ok(runs);
        }
        match self.plan().await {
            Err(error) => Err(error),
            Ok(_) => Err(gone()),
        }
    }

    async fn finish(mut self) -> Result<BlockPlan, BuildError> {
        self.batches = None;
        self.plan().await
    }

    async fn plan(&mut self) -> Result<BlockPlan, BuildError> {
        match self.plan.take() {
            Some(plan) => plan.await.unwrap_or_else(|_| Err(gone())),
            None => Err(gone()),
        }
    }
}

/// Returns the number of cells for a load that is expected: about four for each block. If the
/// expectation is wrong, cells are too fine or too coarse, and are joined or split later.
fn cells_for(load: Load, context: &BuildContext) -> Result<usize, BuildError> {
    let shares = context.memory.shares(load)?;
    let cells = load.points.saturating_mul(4).div_ceil(shares.block_points);
    Ok(cells.min(context.memory.most_cells() as u64) as usize)
}

/// Starts to distribute points to these cells, with runs numbered from `first_run` on.
fn new_spill(cells: KdTree, first_run: u32, context: &BuildContext) -> Spill {
    Spill::new(context.folder.spill(), cells, context.memory.run_buffers(), first_run)
}

fn gone() -> BuildError {
    BuildError::Internal("the thread that spills points is gone".to_owned())
}

fn cannot_spill(folder: &Path, error: std::io::Error) -> BuildError {
    BuildError::io(folder, "spill points in", error)
}

/// Distributes all batches that arrive, and makes the plan.
fn distribute(
    mut spill: Spill,
    mut incoming: mpsc::Receiver<Incoming>,
    context: &BuildContext,
    is_abandoned: impl Fn() -> bool,
) -> Result<BlockPlan, BuildError> {
    let (folder, options) = (spill.folder().to_owned(), &context.options);
    let cannot = |error: std::io::Error| {
        if options.progress.is_cancelled() {
            BuildError::Cancelled
        } else {
            cannot_spill(&folder, error)
        }
    };
    loop {
        let mut flush = None;
        let batches = iter::from_fn(|| match incoming.blocking_recv()? {
            Incoming::Points(batch) => Some(batch),
            Incoming::Flush(reply) => {
                flush = Some(reply);
                None
            }
        });
        spill.push_batches(batches, options.threads).map_err(cannot)?;
        match flush {
            // The receiver may have been dropped.
            Some(reply) => drop(reply.send(spill.flush().map_err(cannot)?)),
            None => break,
        }
    }
    if is_abandoned() {
        return Err(BuildError::Cancelled);
    }
    let spilled = spill.finish().map_err(cannot)?;
    let load = Load {
        points: spilled.points(),
        segments: context.segments,
        has_z: spilled.has_z,
    };
    let Shares { block_points, .. } = context.memory.shares(load)?;
    let limits = SplitLimits {
        block_points,
        cells: context.memory.most_cells(),
        buffers: context.memory.run_buffers(),
    };
    let rule = DuplicateRule {
        duplicates: options.duplicates,
        first_end: context.first_end.load(Ordering::Relaxed),
    };
    plan_blocks(spilled, &folder, limits, rule, &options.progress).map_err(cannot)
}
