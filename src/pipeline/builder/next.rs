//! Builds that make the next state of a file.

use std::path::Path;
use std::sync::atomic::Ordering;

use crate::constraints::segment::Segment;
use crate::edit::EditError;
use crate::pipeline::builder::{Builder, target};
use crate::pipeline::error::BuildError;
use crate::pipeline::next_state::{NextState, NextStateSummary};
use crate::pipeline::options::BuildOptions;
use crate::store::LineKind;

impl Builder {
    /// Starts a build of the next state of a file, which [`finish_next`](Self::finish_next) completes.
    /// In it, record numbers from `first_end` on are those of vertices that are no points of the
    /// input. The errors are those of [`new`](Self::new).
    pub(crate) fn for_next_state(file: &Path, options: BuildOptions, first_end: u64) -> Result<Self, BuildError> {
        let this = Self::start(target(file)?, options)?;
        this.context.first_end.store(first_end, Ordering::Relaxed);
        Ok(this)
    }

    /// Pushes parts of lines. Their ends come as points, with their z.
    pub(crate) fn push_parts(&mut self, parts: Vec<Segment>) -> Result<(), BuildError> {
        self.given.has_obstacles |= parts.iter().any(|part| part.source.kind() == LineKind::Obstacle);
        self.segments.push_parts(parts)?;
        self.reserve()
    }

    /// Builds the next state of a file, and puts it in the place of the file. The errors are those of
    /// [`finish`](Self::finish).
    pub(crate) async fn finish_next(
        mut self,
        next: NextState,
    ) -> Result<Result<NextStateSummary, EditError>, BuildError> {
        self.push_ends().await?;
        let (assembly, points, segments) = self.assembly().await?;
        assembly.build_next(points, segments, next).await
    }
}
