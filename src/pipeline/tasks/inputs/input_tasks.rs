//! The input tasks of a build: planned, opened, and taken.

use std::hash::{BuildHasher, RandomState};
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::time::SystemTime;

use crate::geometry::Point;
use crate::io::new_output;
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::spill::cut;
use crate::pipeline::plan::Run;
use crate::pipeline::tasks::inputs::saved::{SavedInput, SavedInputs};
use crate::pipeline::work_folder::WorkFolder;
use crate::store::KdTree;

/// What [`Builder::plan_inputs`](crate::Builder::plan_inputs) must know of the inputs.
#[derive(Clone, Debug, Default)]
pub struct InputPlan {
    /// Number of records of each input, those included that give no point: exactly.
    pub records: Vec<u64>,
    /// Whether the points have z, which takes memory.
    pub has_z: bool,
    /// Positions from all inputs, for instance
    /// [`PointSource::sample`](crate::input::PointSource::sample). They determine the cells. If they
    /// say little of the distribution of the points, the build distributes points twice.
    pub sample: Vec<Point>,
    /// Any text that [`InputTasks::memo`] returns to whoever does the tasks.
    pub memo: String,
}

/// The inputs of a build, the points of each of which any process may
/// [distribute](Self::start) that shares the work folder, on any machine: in any order, at the
/// same time, and more than once.
///
/// [`Builder::plan_inputs`](crate::Builder::plan_inputs) makes them, and
/// [`Builder::take_inputs`](crate::Builder::take_inputs) goes on once all are done.
#[derive(Debug)]
pub struct InputTasks {
    pub(super) saved: SavedInputs,
    pub(super) folder: Arc<WorkFolder>,
}

/// What tasks distributed.
pub(crate) struct TakenInputs {
    pub(crate) cells: KdTree,
    /// The runs of each cell.
    pub(crate) runs: Vec<Vec<Run>>,
    pub(crate) points: u64,
    pub(crate) has_z: bool,
    /// One more than the largest record number.
    pub(crate) next_record: u64,
    /// The number of the first run that no task has.
    pub(crate) first_run: u32,
    /// What each task said of its input.
    pub(crate) memos: Vec<String>,
}

impl InputTasks {
    /// Opens the input tasks of the build of a file of this name.
    ///
    /// # Errors
    /// Returns [`BuildError::NoTasks`] if that build has none, and an error if they cannot be read.
    pub fn open(output: impl AsRef<Path>) -> Result<Self, BuildError> {
        let output = output.as_ref();
        let target = new_output(output);
        let target = target.map_err(|error| BuildError::io(output, "write a file under this name", error))?;
        let folder = WorkFolder::shared(&target)?;
        let saved = SavedInputs::load(&folder);
        let saved = saved.map_err(|error| BuildError::io(folder.path(), "read the tasks in", error))?;
        let saved = saved.ok_or_else(|| BuildError::NoTasks(folder.path().to_owned()))?;
        Ok(Self::of(saved, Arc::new(folder)))
    }

    pub(crate) fn of(saved: SavedInputs, folder: Arc<WorkFolder>) -> Self {
        Self { saved, folder }
    }

    /// Saves the tasks of a build with this identity, memory, and number of cells, whose buffers take
    /// `buffers` bytes together.
    pub(crate) fn plan(
        folder: &WorkFolder,
        identity: String,
        memory: u64,
        (cells, buffers): (usize, usize),
        plan: InputPlan,
    ) -> io::Result<()> {
        let mut next = 0_u64;
        let ends = plan.records.iter().map(|records| {
            next = next.saturating_add(*records);
            next
        });
        let saved = SavedInputs {
            // A random number, with the time.
            id: RandomState::new().hash_one(SystemTime::now()),
            identity,
            memory,
            buffers,
            cells: cut(&plan.sample, cells),
            first_records: std::iter::once(0).chain(ends).collect(),
            memo: plan.memo,
        };
        saved.save(folder)
    }

    /// Returns the number of inputs. They are numbered from 0, in the order of their records.
    #[must_use]
    pub fn inputs(&self) -> u32 {
        self.saved.inputs()
    }

    /// Returns the record numbers of an input; an empty range if there is no such input.
    #[must_use]
    pub fn records(&self, input: u32) -> std::ops::Range<u64> {
        let ends = self.saved.first_records.get(input as usize..).unwrap_or_default();
        match ends {
            [first, end, ..] => *first..*end,
            _ => 0..0,
        }
    }

    /// Returns the bytes of memory that a task may take: those of the build.
    #[must_use]
    pub fn memory(&self) -> u64 {
        self.saved.memory
    }

    /// Returns [`InputPlan::memo`].
    #[must_use]
    pub fn memo(&self) -> &str {
        &self.saved.memo
    }

    /// Returns whether the points of an input were distributed.
    #[must_use]
    pub fn is_done(&self, input: u32) -> bool {
        self.output(input).is_some()
    }

    /// Returns the output of a task, if it is complete.
    pub(super) fn output(&self, input: u32) -> Option<SavedInput> {
        let saved = SavedInput::load(&self.folder, input, self.saved.id).ok()??;
        saved.is_whole(&self.folder).then_some(saved)
    }

    /// Returns what the tasks distributed.
    ///
    /// # Errors
    /// Returns [`BuildError::InputsLeft`] if some are not done.
    pub(crate) fn take(&self) -> Result<TakenInputs, BuildError> {
        let (inputs, cells) = (self.inputs(), self.saved.cells.tiles());
        let mut taken = TakenInputs {
            runs: vec![Vec::new(); cells as usize],
            points: 0,
            has_z: false,
            next_record: self.saved.first_records.last().copied().unwrap_or(0),
            first_run: self.saved.first_run(inputs),
            memos: Vec::new(),
            cells: KdTree::default(),
        };
        let mut left = Vec::new();
        for input in 0..inputs {
            let Some(saved) = self.output(input) else {
                left.push(input);
                continue;
            };
            taken.points += saved.points();
            taken.has_z |= saved.has_z;
            taken.memos.push(saved.memo);
            for run in saved.runs {
                if let Some(cell) = taken.runs.get_mut((run.number % cells) as usize) {
                    cell.push(run);
                }
            }
        }
        if let Some(&first) = left.first() {
            let left = left.len() as u64;
            return Err(BuildError::InputsLeft { first, left });
        }
        taken.cells = self.saved.cells.clone();
        Ok(taken)
    }
}
