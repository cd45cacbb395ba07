//! From all points and segments to the file, phase by phase: prepare, open, run, publish, summarise.
//!
//! Prepare decides who gets how much memory and which blocks are left; open makes files and what the threads share; run
//! conquers and writes; publish completes the file and gives it its name.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use crate::constraints::segments::spool::SegmentSpool;
use crate::memory::MemoryPlan;
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::intake::Points;
use crate::pipeline::options::BuildOptions;
use crate::pipeline::summary::BuildSummary;
use crate::pipeline::terms::{Given, Terms};
use crate::pipeline::work_folder::WorkFolder;

mod open;
mod prepare;
mod publish;
mod run;

/// Makes a file of what came.
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
    /// Of what a build was told, and what came.
    pub(crate) fn new(terms: &Terms, output: &Path, mut given: Given, began: Instant) -> Self {
        given.site_count = given.site_ids.len() as u64;
        Self {
            memory: terms.memory,
            options: Arc::clone(&terms.options),
            folder: Arc::clone(&terms.folder),
            output: output.to_owned(),
            first_end: terms.first_end.load(Ordering::Relaxed),
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
        let parts = self.prepare(points, segments, is_resumed).await?;
        let mut work = self.open(parts)?;
        let ran = self.run(&mut work).await?;
        let written = self.publish(work, &ran).await?;
        Ok(self.summarise(written, &ran))
    }
}
