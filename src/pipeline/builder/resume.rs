//! Builds that go on from the work of an interrupted one.

use std::iter::repeat;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use crate::constraints::segments::spool::SegmentSpool;
use crate::edit::EditError;
use crate::io::blocking;
use crate::pipeline::builder::Builder;
use crate::pipeline::context::BuildContext;
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::drape::PointSurface;
use crate::pipeline::ingest::intake::Intake;
use crate::pipeline::records::FinishedBlocks;
use crate::pipeline::resume::plan::SavedPlan;
use crate::pipeline::tasks::inputs::SavedInputs;

impl Builder {
    /// Loads the work of an interrupted build. Removes it if there is no plan to continue from, or if
    /// something that the plan needs is lost, as after a power cut. Inputs that tasks distributed stay.
    pub(super) fn resume(&mut self) -> Result<(), BuildError> {
        let folder = &self.context.folder;
        let cannot = |error| BuildError::io(folder.path(), "resume the work in", error);
        match SavedPlan::load(&folder.plan()).map_err(cannot)? {
            Some(saved) if !folder.was_published() => {
                self.check_identity(&saved.settings.identity)?;
                if let Some(finished) = saved.finished(folder)? {
                    return self.continue_from(saved, finished);
                }
            }
            _ => {}
        }
        match SavedInputs::load(folder).map_err(cannot)? {
            Some(inputs) if !folder.was_published() => {
                self.check_identity(&inputs.identity)?;
                folder.forget_plan();
                self.inputs = Some(inputs);
                Ok(())
            }
            _ => folder.empty().map_err(cannot),
        }
    }

    /// Returns an error if the work of the interrupted build belongs to other inputs or options.
    fn check_identity(&self, others: &str) -> Result<(), BuildError> {
        let BuildContext { folder, options, .. } = &self.context;
        match first_difference(others, &options.identity()) {
            None => Ok(()),
            Some(line) => Err(BuildError::OtherBuild {
                path: folder.path().to_owned(),
                what: line.to_owned(),
            }),
        }
    }

    /// Takes over the input and the settings of an interrupted build, apart from its segments.
    fn continue_from(&mut self, saved: SavedPlan, finished: FinishedBlocks) -> Result<(), BuildError> {
        let SavedPlan {
            settings,
            given,
            plan,
            draping,
        } = saved;
        let context = &mut self.context;
        context.memory = context.memory.with_arrivals_before(settings.arrivals)?;
        if draping.is_some() {
            context.memory = context.memory.with_surface();
        }
        // With less memory, nodes must be smaller. Then the file has the same triangles, and other
        // bytes.
        let has_memory = context.memory.total() >= settings.memory;
        context.limits = has_memory.then_some(settings.limits);
        context.segments = settings.segments;
        context.first_end.store(settings.first_end, Ordering::Relaxed);
        self.next_record = given.next_record;
        (self.given, self.draping, self.intake) = (given, draping, Intake::Resumed(plan, finished));
        Ok(())
    }

    /// Reads back what an interrupted build saved beside its plan: segments, and the surface.
    pub(super) async fn read_back(&mut self) -> Result<(), BuildError> {
        let BuildContext { folder, memory, .. } = &self.context;
        let (path, count) = (folder.lines(), self.context.segments);
        let mut segments = SegmentSpool::new(folder.spill(), memory.for_segments());
        let read = blocking(move || match count {
            0 => Ok(segments),
            _ => segments.restore(&path, count).map(|()| segments),
        });
        let cannot = |error| BuildError::io(folder.spill(), "read segments in", error);
        self.segments = read.await.map_err(cannot)??;
        if let Some(rules) = self.draping.take() {
            let progress = Arc::clone(&self.context.options.progress);
            let surface = PointSurface::open(&folder.surface(), rules, memory.for_surface(), progress).await;
            self.surface = Some(Arc::new(surface.map_err(EditError::Read)?));
        }
        Ok(())
    }
}

/// Returns the first line in which two texts differ: that of `a`, or of `b` if `a` has no more
/// lines.
fn first_difference<'a>(a: &'a str, b: &'a str) -> Option<&'a str> {
    let padded = |text: &'a str| text.lines().map(Some).chain(repeat(None));
    let mut pairs = padded(a).zip(padded(b)).take_while(|(a, b)| a.or(*b).is_some());
    pairs.find(|(a, b)| a != b).and_then(|(a, b)| a.or(b))
}
