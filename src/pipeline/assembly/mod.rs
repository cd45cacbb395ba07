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
use crate::pipeline::ingest::drape::PointSurface;
use crate::pipeline::ingest::intake::Points;
use crate::pipeline::next_state::NextState;
use crate::pipeline::options::BuildOptions;
use crate::pipeline::plan::NodeLimits;
use crate::pipeline::summary::BuildSummary;
use crate::pipeline::work_folder::WorkFolder;

mod next;
mod open;
mod prepare;
mod publish;
mod run;
mod tasks;

/// Makes a file from the input of a build.
pub(crate) struct Assembly {
    options: Arc<BuildOptions>,
    folder: Arc<WorkFolder>,
    output: PathBuf,
    given: Given,
    first_end: u64,
    memory: MemoryPlan,
    /// The limits of the interrupted build that is resumed.
    limits: Option<NodeLimits>,
    began: Instant,
    /// The surface from which vertices without z take it.
    surface: Option<Arc<PointSurface>>,
    /// What makes it the next state of a file.
    next: Option<NextState>,
}

impl Assembly {
    /// Creates the assembly from the settings and the input of a build.
    pub(crate) fn new(context: &BuildContext, output: &Path, mut given: Given, began: Instant) -> Self {
        given.site_count = given.site_ids.len() as u64;
        Self {
            memory: context.memory,
            limits: context.limits,
            options: Arc::clone(&context.options),
            folder: Arc::clone(&context.folder),
            output: output.to_owned(),
            first_end: context.first_end.load(Ordering::Relaxed),
            given,
            began,
            surface: None,
            next: None,
        }
    }

    /// Sets the surface from which vertices without z take it.
    pub(crate) fn on_surface(self, surface: Option<Arc<PointSurface>>) -> Self {
        Self { surface, ..self }
    }

    /// Builds the file.
    pub(crate) async fn build(mut self, points: Points, segments: SegmentSpool) -> Result<BuildSummary, BuildError> {
        let prepared = self.prepare(points, segments).await?;
        self.make(prepared).await
    }

    /// Builds the surface: the triangulation of points alone. Returns the path of the file.
    pub(crate) async fn build_surface(mut self, points: Points) -> Result<PathBuf, BuildError> {
        let no_segments = SegmentSpool::new(self.folder.spill(), 0);
        let prepared = self.prepare(points, no_segments).await?;
        let mut work = self.open(prepared)?;
        let ran = self.run(&mut work).await?;
        self.complete(work, &ran).await?;
        let aside = self.folder.set_surface_aside();
        aside.map_err(|error| BuildError::io(self.folder.path(), "rename the surface in", error))
    }
}
