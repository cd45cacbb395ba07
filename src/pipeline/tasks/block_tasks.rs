//! The tasks of a build, as any process opens them.

use std::io;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use crate::io::new_output;
use crate::memory::{Load, MemoryPlan, Shares};
use crate::pipeline::conquer::leaf::LeafRules;
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::drape::Draping;
use crate::pipeline::options::{BuildOptions, Progress};
use crate::pipeline::plan::{BlockPlan, NodeLimits};
use crate::pipeline::resume::plan::SavedPlan;
use crate::pipeline::tasks::block_file::BlockFile;
use crate::pipeline::tasks::saved::SavedTasks;
use crate::pipeline::work_folder::WorkFolder;

/// The blocks of a build, each of which any process may [conquer](Self::conquer) that shares the work
/// folder, on any machine. They may be conquered in any order, at the same time, and more than once.
///
/// [`Builder::plan_tasks`](crate::Builder::plan_tasks) makes them. A
/// [resumed](crate::BuildOptions::resume) build takes the blocks that were conquered, conquers the
/// others itself, and completes the file, which has the triangles of any other build of the same input.
#[derive(Debug)]
pub struct BlockTasks {
    /// What distinguishes these tasks from those of other builds of this name.
    pub(super) id: u64,
    pub(super) options: Arc<BuildOptions>,
    pub(super) folder: Arc<WorkFolder>,
    pub(super) memory: MemoryPlan,
    pub(super) shares: Shares,
    pub(super) plan: BlockPlan,
    pub(super) limits: NodeLimits,
    pub(super) rules: LeafRules,
    /// How vertices take their z from the surface of the points, if they do.
    pub(super) draping: Option<Draping>,
    /// The tile numbers of each block.
    pub(super) tiles: Vec<Range<u32>>,
}

impl BlockTasks {
    /// Opens the tasks of the build of a file of this name.
    ///
    /// # Errors
    /// Returns [`BuildError::NoTasks`] if that build has none, and an error if they cannot be read.
    pub fn open(output: impl AsRef<Path>) -> Result<Self, BuildError> {
        let output = output.as_ref();
        let target = new_output(output);
        let target = target.map_err(|error| BuildError::io(output, "write a file under this name", error))?;
        let folder = WorkFolder::shared(&target)?;
        let cannot = |error| BuildError::io(folder.path(), "read the tasks in", error);
        let saved = SavedPlan::load(&folder.plan()).map_err(cannot)?;
        let tasks = SavedTasks::load(&folder).map_err(cannot)?;
        match saved.zip(tasks) {
            Some((saved, tasks)) => Self::of(saved, &tasks, folder),
            None => Err(BuildError::NoTasks(folder.path().to_owned())),
        }
    }

    fn of(saved: SavedPlan, tasks: &SavedTasks, folder: WorkFolder) -> Result<Self, BuildError> {
        let SavedPlan {
            settings,
            mut given,
            plan,
            draping,
        } = saved;
        let (options, tiles) = match (tasks.options(), tasks.tiles()) {
            (Some(options), tiles) if tiles.len() == plan.blocks.len() => (options, tiles),
            _ => return Err(BuildError::NoTasks(folder.path().to_owned())),
        };
        let mut memory = options.memory_plan().with_arrivals_before(settings.arrivals)?;
        if draping.is_some() {
            memory = memory.with_surface();
        }
        let load = Load {
            points: plan.points,
            segments: settings.segments,
            has_z: plan.has_z,
        };
        let largest = plan.blocks.iter().map(|block| block.points).max();
        let has_lines = settings.segments > 0;
        Ok(Self {
            id: tasks.id,
            shares: memory.resumed_shares(load, largest.unwrap_or(0))?,
            rules: LeafRules::of(&mut given, &options, settings.first_end, has_lines),
            limits: settings.limits,
            options: Arc::new(options),
            folder: Arc::new(folder),
            memory,
            plan,
            draping,
            tiles,
        })
    }

    /// Returns the number of blocks. They are numbered from 0.
    #[must_use]
    pub fn blocks(&self) -> u32 {
        self.plan.blocks.len() as u32
    }

    /// Returns the number of points of a block, with ends of lines and sites, or 0 if there is no such
    /// block.
    #[must_use]
    pub fn points(&self, block: u32) -> u64 {
        self.plan.blocks.get(block as usize).map_or(0, |block| block.points)
    }

    /// Returns the bytes of memory that a task may take: those of the build that made the plan.
    #[must_use]
    pub fn memory(&self) -> u64 {
        self.memory.total()
    }

    /// Returns whether a block was conquered.
    #[must_use]
    pub fn is_done(&self, block: u32) -> bool {
        BlockFile::is_of(&self.folder, block, self.id)
    }

    /// Returns the progress of the tasks that this process does, and the way to cancel them.
    #[must_use]
    pub fn progress(&self) -> &Arc<Progress> {
        &self.options.progress
    }

    /// Returns the tasks as part of a build, with its progress.
    pub(crate) fn with_progress(mut self, progress: &Arc<Progress>) -> Self {
        Arc::make_mut(&mut self.options).progress = Arc::clone(progress);
        self
    }

    /// Returns the offset in the file behind which its tiles come.
    pub(crate) fn front_end(&self) -> u64 {
        self.plan.front_end(self.options.tile_vertices)
    }

    pub(super) fn cannot(&self, what: &'static str) -> impl Fn(io::Error) -> BuildError {
        move |error| BuildError::io(self.folder.spill(), what, error)
    }
}
