//! Where points go as they come: to memory as long as they fit, then to runs on disk, on a thread of its own.

use std::path::Path;
use std::sync::atomic::Ordering;
use std::thread;

use tokio::sync::{mpsc, oneshot};

use crate::constraints::error::ConstraintError;
use crate::geometry::{Point, Rect};
use crate::input::PointBatch;
use crate::io::start_thread;
use crate::memory::{Load, Shares};
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::point_store::PointStore;
use crate::pipeline::ingest::spill;
use crate::pipeline::ingest::spill::Spill;
use crate::pipeline::ingest::spill::resplit::{Limits, plan_blocks};
use crate::pipeline::options::DuplicateRule;
use crate::pipeline::plan::{Plan, Run};
use crate::pipeline::resume::journal::SavedPlan;
use crate::pipeline::terms::Terms;
use crate::store::KdTree;

/// Batches that wait for the thread that distributes them.
const BATCHES_AHEAD: usize = 4;

/// The points so far.
#[derive(Debug)]
pub(crate) enum Intake {
    /// In memory.
    Memory(PointStore),
    /// On their way to runs.
    Spilling(Spilling),
    /// They came in before: an interrupted build goes on.
    Resumed(Box<SavedPlan>),
}

/// What comes to the thread that distributes points.
#[derive(Debug)]
enum Incoming {
    Points(PointBatch),
    /// Write what is in memory, and say what the runs are by now, and the tree of their cells.
    Flush(oneshot::Sender<(Vec<Run>, KdTree)>),
}

/// The thread that distributes points.
#[derive(Debug)]
pub(crate) struct Spilling {
    /// None once all have come, or nobody takes them.
    batches: Option<mpsc::Sender<Incoming>>,
    plan: Option<oneshot::Receiver<Result<Plan, BuildError>>>,
    thread: Option<thread::JoinHandle<()>>,
}

impl Drop for Spilling {
    /// Waits for the thread, which ends with the batch at hand, so that it does not outlive the work folder.
    fn drop(&mut self) {
        self.batches = None;
        self.plan = None;
        if let Some(thread) = self.thread.take() {
            // Whatever it had to say, nobody listens any more.
            let _ = thread.join();
        }
    }
}

/// The points that have come by now, to be looked through.
pub(crate) enum Arrived<'a> {
    Memory(&'a PointStore),
    Runs(&'a Path, Vec<Run>, KdTree),
}

impl Arrived<'_> {
    /// The borders between the cells that they lie in, as far as they lie in a rectangle.
    pub(crate) fn borders(&self, within: Rect) -> Vec<[Point; 2]> {
        match self {
            Self::Memory(_) => Vec::new(),
            Self::Runs(_, _, tree) => tree.borders(within),
        }
    }

    /// Gives those within a rectangle, and perhaps others.
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
    Runs(Plan),
}

impl Intake {
    /// Nothing yet.
    pub(crate) fn new() -> Self {
        Self::Memory(PointStore::default())
    }

    /// Learns how many points come, and how they lie. If they will not fit, they go to disk from the first one on.
    pub(crate) fn expect(&mut self, points: u64, sample: Vec<Point>, terms: &Terms) -> Result<(), BuildError> {
        let Self::Memory(store) = self else { return Ok(()) };
        let load = Load {
            points,
            segments: terms.segments,
            has_z: false,
        };
        if sample.is_empty() || !store.items.is_empty() || terms.memory.points_fit(load) {
            return Ok(());
        }
        // What is to come may be told wrong; it decides how finely the plane is cut, nothing else.
        let shares = terms.memory.shares(load)?;
        let cells = points.saturating_mul(4).div_ceil(shares.block_points).min(1 << 16) as usize;
        let cells = cells.min(terms.memory.most_cells());
        *self = Self::Spilling(Spilling::start(PointStore::default(), &sample, cells, terms)?);
        Ok(())
    }

    /// Takes a batch.
    pub(crate) async fn push(&mut self, batch: &PointBatch, terms: &Terms) -> Result<(), BuildError> {
        match self {
            Self::Resumed(_) => return Err(BuildError::PointsComplete),
            Self::Spilling(spilling) => return spilling.push(batch).await,
            Self::Memory(_) => {}
        }
        let Self::Memory(store) = self else { return Ok(()) };
        let room = store.items.len() + batch.points.len() <= PointStore::MAX_POINTS;
        if room {
            store.push(batch);
            let load = Load {
                points: store.items.len() as u64,
                segments: terms.segments,
                has_z: store.attributes.has_z(),
            };
            if terms.memory.fits(load, store.byte_size()) {
                return Ok(());
            }
        }
        let store = std::mem::take(store);
        let step = store.items.len().div_ceil(spill::SAMPLE).max(1);
        let sample: Vec<Point> = store.items.iter().step_by(step).map(|item| item.point).collect();
        let cells = terms.memory.most_cells();
        let mut spilling = Spilling::start(store, &sample, cells, terms)?;
        if !room {
            spilling.push(batch).await?;
        }
        *self = Self::Spilling(spilling);
        Ok(())
    }

    /// Those that have come by now. None came of a build that is resumed.
    pub(crate) async fn arrived<'a>(&'a mut self, terms: &'a Terms) -> Result<Arrived<'a>, BuildError> {
        let folder = terms.folder.spill();
        match self {
            Self::Memory(store) => Ok(Arrived::Memory(store)),
            Self::Spilling(spilling) => {
                let (runs, tree) = spilling.flush().await?;
                Ok(Arrived::Runs(folder, runs, tree))
            }
            Self::Resumed(_) => Ok(Arrived::Runs(folder, Vec::new(), KdTree::default())),
        }
    }

    /// All points have come.
    pub(crate) async fn finish(self) -> Result<Points, BuildError> {
        match self {
            Self::Memory(store) => Ok(Points::Memory(store)),
            Self::Spilling(spilling) => Ok(Points::Runs(spilling.finish().await?)),
            Self::Resumed(saved) => Ok(Points::Runs(saved.plan)),
        }
    }
}

impl Spilling {
    fn start(store: PointStore, sample: &[Point], cells: usize, terms: &Terms) -> Result<Self, BuildError> {
        let (batches, incoming) = mpsc::channel(BATCHES_AHEAD);
        let (reply, plan) = oneshot::channel::<Result<Plan, BuildError>>();
        let path = terms.folder.spill().to_owned();
        let mut spill = Spill::new(&path, sample, cells, terms.memory.run_buffers(), 0);
        let terms = terms.clone();
        let work = move || {
            let pushed = spill.push_store(&store);
            drop(store);
            let spilled = pushed.map_err(|error| cannot_spill(terms.folder.spill(), error));
            let plan = spilled.and_then(|()| distribute(spill, incoming, &terms, || reply.is_closed()));
            // Before the answer: whoever gets it may remove the folder.
            drop(terms);
            // If nobody waits for the answer any more, nobody needs it.
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
        // The thread ended before its time: it knows why.
        match self.plan().await {
            Err(error) => Err(error),
            Ok(_) => Err(gone()),
        }
    }

    /// The runs of the points so far, all of which are on the disk, and the tree of their cells.
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

    async fn finish(mut self) -> Result<Plan, BuildError> {
        self.batches = None;
        self.plan().await
    }

    async fn plan(&mut self) -> Result<Plan, BuildError> {
        match self.plan.take() {
            Some(plan) => plan.await.unwrap_or_else(|_| Err(gone())),
            None => Err(gone()),
        }
    }
}

fn gone() -> BuildError {
    BuildError::Internal("the thread that spills points is gone".to_owned())
}

fn cannot_spill(folder: &Path, error: std::io::Error) -> BuildError {
    BuildError::io(folder, "spill points in", error)
}

/// Distributes all batches that come, and makes the plan.
fn distribute(
    mut spill: Spill,
    mut incoming: mpsc::Receiver<Incoming>,
    terms: &Terms,
    is_abandoned: impl Fn() -> bool,
) -> Result<Plan, BuildError> {
    let (folder, options) = (spill.folder().to_owned(), &terms.options);
    let cannot = |error: std::io::Error| {
        if options.progress.is_cancelled() {
            BuildError::Cancelled
        } else {
            cannot_spill(&folder, error)
        }
    };
    while let Some(incoming) = incoming.blocking_recv() {
        match incoming {
            Incoming::Points(batch) => spill.push(&batch).map_err(cannot)?,
            // If nobody waits for the answer any more, nobody needs it.
            Incoming::Flush(reply) => drop(reply.send(spill.flush().map_err(cannot)?)),
        }
    }
    if is_abandoned() {
        return Err(BuildError::Cancelled);
    }
    let spilled = spill.finish().map_err(cannot)?;
    let points = spilled.runs.iter().map(|run| run.points).sum();
    let load = Load {
        points,
        segments: terms.segments,
        has_z: spilled.has_z,
    };
    let Shares { block_points, .. } = terms.memory.shares(load)?;
    let limits = Limits {
        block_points,
        cells: terms.memory.most_cells(),
        buffers: terms.memory.run_buffers(),
    };
    let rule = DuplicateRule {
        duplicates: options.duplicates,
        first_end: terms.first_end.load(Ordering::Relaxed),
    };
    plan_blocks(spilled, &folder, limits, rule, &options.progress).map_err(cannot)
}
