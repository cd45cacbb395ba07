//! From all points and segments to the file, phase by phase: prepare, open, run, publish,
//! summarise.
//!
//! Prepare divides the memory and finds the blocks that are left to do. Open creates the files and
//! the state that the threads share. Run conquers the blocks and writes them. Publish completes the
//! file and gives it its name.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use crate::constraints::segments::spool::SegmentSpool;
use crate::memory::MemoryPlan;
use crate::pipeline::context::{BuildContext, Given};
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::intake::Points;
use crate::pipeline::options::BuildOptions;
use crate::pipeline::summary::BuildSummary;
use crate::pipeline::work_folder::WorkFolder;

mod open;
mod prepare;
mod publish;
mod run;

/// Makes a file from the input of a build.
pub(crate) struct Assembly {
    options: Arc<BuildOptions>,
    folder: Arc<WorkFolder>,
    output: PathBuf,
    given: Given,
    first_end: u64,
    memory: MemoryPlan,
    began: Instant,
}

impl Assembly {
    /// Creates the assembly from the settings and the input of a build.
    pub(crate) fn new(context: &BuildContext, output: &Path, mut given: Given, began: Instant) -> Self {
        given.site_count = given.site_ids.len() as u64;
        Self {
            memory: context.memory,
            options: Arc::clone(&context.options),
            folder: Arc::clone(&context.folder),
            output: output.to_owned(),
            first_end: context.first_end.load(Ordering::Relaxed),
            given,
            began,
        }
    }

    /// Builds the file.
    pub(crate) async fn build(
        mut self,
        points: Points,
        segments: SegmentSpool,
        is_resumed: bool,
    ) -> Result<BuildSummary, BuildError> {
        let prepared = self.prepare(points, segments, is_resumed).await?;
        let mut work = self.open(prepared)?;
        let ran = self.run(&mut work).await?;
        let written = self.publish(work, &ran).await?;
        Ok(self.summarise(written, &ran))
    }
}
