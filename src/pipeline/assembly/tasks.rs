//! Tasks: leaves the blocks to other processes, where there are blocks.

use std::sync::Arc;

use crate::constraints::segments::spool::SegmentSpool;
use crate::io::blocking;
use crate::pipeline::assembly::Assembly;
use crate::pipeline::assembly::prepare::PreparedBuild;
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::intake::Points;
use crate::pipeline::resume::plan::sync_inputs;
use crate::pipeline::summary::BuildSummary;
use crate::pipeline::tasks::saved::SavedTasks;

impl Assembly {
    /// Leaves the blocks to tasks. Builds the file if all points are in memory, so that there are no
    /// blocks.
    pub(crate) async fn plan_tasks(
        mut self,
        points: Points,
        segments: SegmentSpool,
    ) -> Result<Option<BuildSummary>, BuildError> {
        let prepared = self.prepare(points, segments).await?;
        if !prepared.has_journal {
            return self.make(prepared).await.map(Some);
        }
        let PreparedBuild { plan, segments, .. } = prepared;
        let tasks = SavedTasks::of(&self.options, &plan.blocks)?;
        let folder = Arc::clone(&self.folder);
        let saved = blocking(move || {
            sync_inputs(&folder, &plan.blocks)?;
            tasks.save(&folder, &segments)
        });
        let cannot = |error| BuildError::io(self.folder.path(), "write the tasks in", error);
        saved.await.flatten().map_err(cannot)?;
        Ok(None)
    }

    /// Makes the file.
    pub(super) async fn make(mut self, prepared: PreparedBuild) -> Result<BuildSummary, BuildError> {
        let mut work = self.open(prepared)?;
        let ran = self.run(&mut work).await?;
        let written = self.publish(work, &ran).await?;
        Ok(self.summarise(written, &ran))
    }
}
