//! Builds whose inputs are distributed by tasks.

use std::sync::Arc;

use crate::memory::{Load, Shares};
use crate::pipeline::builder::Builder;
use crate::pipeline::context::BuildContext;
use crate::pipeline::disk::{DiskLoad, check_disk};
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::intake::Intake;
use crate::pipeline::tasks::inputs::{InputPlan, InputTasks, TakenInputs};

/// The most runs that tasks may write, cells times inputs: their numbers have 31 bits.
const MOST_RUNS: usize = 1 << 31;

impl Builder {
    /// Leaves reading the points to [tasks](InputTasks), one for each input, which any process may do that
    /// shares the work folder: the folder beside the output, and
    /// [`BuildOptions::work_folder`](crate::BuildOptions::work_folder) if that is set. Then
    /// [resume](crate::BuildOptions::resume) the build, push lines and sites, and
    /// [take](Self::take_inputs) the points. If the inputs were planned before and the build is resumed, its
    /// tasks are returned.
    ///
    /// Returns `None` if all points fit into memory, or if the sample is empty. Then the points must be
    /// pushed.
    ///
    /// # Errors
    /// Returns [`BuildError::NotResumable`] if the build cannot be
    /// [resumed](crate::BuildOptions::resumable), [`BuildError::PointsComplete`] if it has its points, and
    /// an error if there is too little memory or room on the disk.
    ///
    /// # Example
    /// See [`InputTasks::start`].
    pub fn plan_inputs(mut self, plan: InputPlan) -> Result<Option<InputTasks>, BuildError> {
        let planned = self.inputs_planned(plan);
        self.keep_after(planned)
    }

    fn inputs_planned(&mut self, mut plan: InputPlan) -> Result<Option<InputTasks>, BuildError> {
        let BuildContext {
            options,
            folder,
            memory,
            ..
        } = &self.context;
        if options.resumable.is_none() {
            return Err(BuildError::NotResumable);
        }
        if !self.needs_points() {
            return Err(BuildError::PointsComplete);
        }
        if self.inputs.is_some() {
            return InputTasks::open(&self.output).map(Some);
        }
        let load = Load {
            points: plan.records.iter().fold(0, |sum, &records| sum.saturating_add(records)),
            segments: 0,
            has_z: plan.has_z,
        };
        plan.sample.retain(|point| point.is_valid());
        if plan.sample.is_empty() || memory.points_fit(load) {
            return Ok(None);
        }
        let of_disk = DiskLoad {
            points: load.points,
            has_z: plan.has_z,
            segments: 0,
            segment_bytes: 0,
            spilled_bytes: 0,
        };
        check_disk(folder, of_disk)?;
        let Shares { block_points, .. } = memory.shares(load)?;
        let buffers = memory.run_buffers();
        let wanted = load.points.saturating_mul(4).div_ceil(block_points);
        let most = memory.most_cells_of_input().min(MOST_RUNS / plan.records.len().max(1));
        let cells = wanted.min(most as u64) as usize;
        let planned = InputTasks::plan(folder, options.identity(), memory.total(), (cells, buffers), plan);
        planned.map_err(|error| BuildError::io(folder.path(), "write the tasks in", error))?;
        folder.keep(true);
        InputTasks::open(&self.output).map(Some)
    }

    /// Returns the input tasks of the build that is resumed, if it has some, and has not
    /// [taken](Self::take_inputs) the points yet.
    #[must_use]
    pub fn input_tasks(&self) -> Option<InputTasks> {
        let saved = self.inputs.clone()?;
        Some(InputTasks::of(saved, Arc::clone(&self.context.folder)))
    }

    /// Takes the points that [tasks](InputTasks) distributed, in place of pushing them. Returns what each
    /// task [said](crate::InputTask::finish) of its input.
    ///
    /// # Errors
    /// Returns [`BuildError::NoTasks`] if there are none, [`BuildError::InputsLeft`] if some are not done,
    /// [`BuildError::InputsForRecords`] if segments between records were pushed, and an error if the
    /// obstacles pushed so far are invalid, or points were pushed already.
    pub fn take_inputs(&mut self) -> Result<Vec<String>, BuildError> {
        self.before_points("take_inputs")?;
        self.check_obstacles()?;
        let tasks = self.input_tasks();
        let tasks = tasks.ok_or_else(|| BuildError::NoTasks(self.context.folder.path().to_owned()))?;
        let [_, between_records] = self.segments.counts();
        if between_records > 0 {
            return Err(BuildError::InputsForRecords);
        }
        let TakenInputs {
            cells,
            runs,
            points,
            has_z,
            next_record,
            first_run,
            memos,
        } = tasks.take()?;
        self.inputs = None;
        self.intake = Intake::of_runs(cells, runs, has_z, first_run, &self.context)?;
        self.given.points += points;
        self.given.has_z |= has_z;
        self.next_record = self.next_record.max(next_record);
        self.context.options.progress.advance(points, points);
        Ok(memos)
    }
}
