//! Next: builds the next state of a file, edits it if there is more to do, and gives it the name of
//! the file.

use std::fs;

use crate::constraints::segments::spool::SegmentSpool;
use crate::edit::{EditError, Target};
use crate::pipeline::assembly::Assembly;
use crate::pipeline::assembly::publish::Published;
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::intake::Points;
use crate::pipeline::next_state::{NextState, NextStateSummary};

impl Assembly {
    /// Builds the next state of the file, which it replaces unless it is a dry run. The inner error is
    /// that of the edit of what was built.
    pub(crate) async fn build_next(
        mut self,
        points: Points,
        segments: SegmentSpool,
        mut next: NextState,
    ) -> Result<Result<NextStateSummary, EditError>, BuildError> {
        let (then, is_dry_run) = (next.work.take(), next.is_dry_run);
        self.next = Some(next);
        let prepared = self.prepare(points, segments).await?;
        let mut work = self.open(prepared)?;
        let path = work.path.clone();
        let ran = self.run(&mut work).await?;
        let Published {
            metadata,
            tiles,
            file_bytes,
            ..
        } = self.complete(work, &ran).await?;
        let edited = match then {
            None => None,
            Some(_) if metadata.triangles == 0 => return Ok(Err(EditError::NothingLeft)),
            Some(work) => match self.edit_draft(&path, work).await {
                Ok(edited) => Some(self.settle(&path, edited).await?),
                Err(error) => return Ok(Err(error)),
            },
        };
        let locked = match is_dry_run {
            true => None,
            false => Some(self.replace()?),
        };
        Ok(Ok(NextStateSummary {
            locked,
            metadata,
            tiles,
            file_bytes,
            edited,
        }))
    }

    /// Gives the file the name of the one that it replaces, and its permissions. Returns it locked, so
    /// that nobody else can edit it first.
    fn replace(&self) -> Result<Target, BuildError> {
        if self.options.progress.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        if let Ok(before) = fs::metadata(&self.output) {
            // A new file is readable by its owner only, or as the system has it by default.
            let _ = fs::set_permissions(self.folder.file(), before.permissions());
        }
        let target = Target::lock(&self.folder.file())?;
        self.folder.publish(true)?;
        Ok(target.renamed(self.output.clone()))
    }
}
