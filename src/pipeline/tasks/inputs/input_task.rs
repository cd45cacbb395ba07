//! Distributes the points of one input.

use std::hash::{BuildHasher, RandomState};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Instant, SystemTime};
use std::{fs, io};

use crate::input::PointBatch;
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::batch::check_batch;
use crate::pipeline::ingest::spill::Spill;
use crate::pipeline::plan::path_of_run;
use crate::pipeline::tasks::inputs::input_tasks::InputTasks;
use crate::pipeline::tasks::inputs::saved::{SavedInput, SavedInputs};
use crate::pipeline::work_folder::WorkFolder;

/// A task that distributes the points of one input. Dropping it removes what it wrote, unless it is
/// [finished](Self::finish).
#[derive(Debug)]
pub struct InputTask<'a> {
    tasks: &'a InputTasks,
    input: u32,
    spill: Spill,
    runs: UnfinishedRuns,
    has_z: bool,
    began: Instant,
}

/// What a task did.
#[derive(Clone, Copy, Debug)]
pub struct DistributedInput {
    /// The number of the input.
    pub input: u32,
    /// Number of points.
    pub points: u64,
    /// Bytes of the runs that were written.
    pub bytes_written: u64,
    /// Seconds that this took.
    pub seconds: f64,
}

/// The files of runs that do not have their names yet. They are removed on drop.
#[derive(Debug)]
struct UnfinishedRuns {
    folder: Arc<WorkFolder>,
    first_run: u32,
    cells: u32,
    /// What follows the names.
    suffix: String,
}

impl InputTasks {
    /// Starts the task of an input. Its points are [pushed](InputTask::push) then.
    ///
    /// # Errors
    /// Returns [`BuildError::NoInput`] if there is no such input, and [`BuildError::TaskMemory`] if the task
    /// may take fewer than the [bytes](Self::memory) of the plan.
    ///
    /// # Example
    ///
    /// ```
    /// use delaunay_tiles::input::PointBatch;
    /// use delaunay_tiles::{BuildOptions, Builder, InputPlan, InputTasks, Point};
    ///
    /// # tokio::runtime::Runtime::new()?.block_on(async {
    /// let folder = tempfile::tempdir()?;
    /// let path = folder.path().join("grid.tiles");
    /// // Two inputs of 50,000 points.
    /// let points = |records: std::ops::Range<u64>| PointBatch {
    ///     points: records.clone().map(|i| Point::new((i % 400) as f64, (i / 400) as f64)).collect(),
    ///     z: Vec::new(),
    ///     records: records.collect(),
    /// };
    /// let options = BuildOptions::default()
    ///     .memory(1_500_000)
    ///     .tile_vertices(1000)
    ///     .threads(1)
    ///     .resumable("a grid".to_owned());
    /// let builder = Builder::new(&path, options.clone())?;
    /// let sample = points(0..100_000).points.into_iter().step_by(100).collect();
    /// let plan = InputPlan { records: vec![50_000; 2], sample, ..InputPlan::default() };
    /// assert!(builder.plan_inputs(plan)?.is_some(), "1.5 MB suffice");
    /// // Any process may do this, for any input.
    /// let tasks = InputTasks::open(&path)?;
    /// for input in 0..tasks.inputs() {
    ///     let mut task = tasks.start(input, 1_500_000)?;
    ///     task.push(&points(tasks.records(input)))?;
    ///     task.finish("")?;
    /// }
    /// let mut builder = Builder::new(&path, options.resume(true))?;
    /// builder.take_inputs()?;
    /// assert_eq!(builder.finish().await?.vertices, 100_000);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// # })?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn start(&self, input: u32, memory: u64) -> Result<InputTask<'_>, BuildError> {
        if input >= self.inputs() {
            let inputs = self.inputs();
            return Err(BuildError::NoInput { input, inputs });
        }
        if memory < self.memory() {
            return Err(BuildError::TaskMemory {
                needed: self.memory(),
                given: memory,
            });
        }
        let SavedInputs { cells, buffers, .. } = &self.saved;
        let runs = UnfinishedRuns {
            folder: Arc::clone(&self.folder),
            first_run: self.saved.first_run(input),
            cells: cells.tiles(),
            // A random number, with the time.
            suffix: format!(".{:016x}", RandomState::new().hash_one(SystemTime::now())),
        };
        let spill = Spill::new(self.folder.spill(), cells.clone(), *buffers, runs.first_run);
        Ok(InputTask {
            tasks: self,
            input,
            spill: spill.named(&runs.suffix),
            runs,
            has_z: false,
            began: Instant::now(),
        })
    }
}

impl InputTask<'_> {
    /// Distributes a batch of points, whose [records](InputTasks::records) are those of the input. It
    /// writes files, so it blocks.
    ///
    /// # Errors
    /// Returns an error if a point is [not valid](crate::geometry::Point::is_valid), a z is not finite, the
    /// batch's arrays differ in length, a record is none of the input, or points cannot be written.
    pub fn push(&mut self, batch: &PointBatch) -> Result<(), BuildError> {
        check_batch(batch)?;
        let records = self.tasks.records(self.input);
        if let Some(&record) = batch.records.iter().find(|record| !records.contains(record)) {
            let input = self.input;
            return Err(BuildError::RecordOfInput { input, record });
        }
        self.has_z |= !batch.z.is_empty();
        self.spill.push(batch).map_err(self.runs.cannot())
    }

    /// Completes the task: the runs get their names, and then its output, of which `memo` is a part
    /// that [`Builder::take_inputs`](crate::Builder::take_inputs) returns.
    ///
    /// # Errors
    /// Returns an error if something cannot be written, and [`BuildError::NoTasks`] if other tasks were
    /// planned meanwhile.
    pub fn finish(self, memo: &str) -> Result<DistributedInput, BuildError> {
        let Self {
            tasks,
            input,
            spill,
            runs,
            has_z,
            began,
        } = self;
        let cannot = runs.cannot();
        let spilled = spill.finish().map_err(&cannot)?;
        let saved = SavedInput {
            id: tasks.saved.id,
            runs: spilled
                .runs
                .into_iter()
                .flatten()
                .filter(|run| run.points > 0)
                .collect(),
            has_z,
            memo: memo.to_owned(),
        };
        let is_current = SavedInputs::load(&runs.folder).map_err(&cannot)?;
        if is_current.is_none_or(|current| current.id != saved.id) {
            return Err(BuildError::NoTasks(runs.folder.path().to_owned()));
        }
        for run in &saved.runs {
            let path = run.path(runs.folder.spill());
            fs::rename(runs.path(run.number), path).map_err(&cannot)?;
        }
        saved.save(&runs.folder, input).map_err(&cannot)?;
        Ok(DistributedInput {
            input,
            points: saved.points(),
            bytes_written: saved.runs.iter().map(|run| run.length).sum(),
            seconds: began.elapsed().as_secs_f64(),
        })
    }
}

impl UnfinishedRuns {
    fn path(&self, number: u32) -> PathBuf {
        let mut path = path_of_run(self.folder.spill(), number).into_os_string();
        path.push(&self.suffix);
        path.into()
    }

    fn cannot(&self) -> impl Fn(io::Error) -> BuildError + use<> {
        let folder = Arc::clone(&self.folder);
        move |error| BuildError::io(folder.spill(), "distribute points in", error)
    }
}

impl Drop for UnfinishedRuns {
    fn drop(&mut self) {
        for cell in 0..self.cells {
            // Those that have their names are not there.
            let _ = fs::remove_file(self.path(self.first_run + cell));
        }
    }
}
