//! The shores of ponds as they arrive, until the surface that gives them their z is known.

use crate::constraints::error::ConstraintError;
use crate::input::SegmentBatch;
use crate::pipeline::error::BuildError;
use crate::terrain::Shores;

/// The ponds of a build.
#[derive(Debug, Default)]
pub(crate) struct PondInput {
    shores: Shores,
    /// The line of each edge.
    lines: Vec<u64>,
}

impl PondInput {
    /// Adds the polygons of a batch, whose lines are numbered from `first_line` on.
    pub(crate) fn push(&mut self, first_line: u64, batch: &SegmentBatch) -> Result<(), BuildError> {
        let (segments, z, lines) = (batch.ends.len(), batch.z.len(), batch.lines.len());
        if lines != segments || !(z == segments || z == 0) || !batch.records.is_empty() {
            return Err(ConstraintError::SegmentBatch { segments, z, lines }.into());
        }
        for (ends, segment) in batch.ends.iter().zip(self.lines.len() as u64..) {
            if let Some(&point) = ends.iter().find(|end| !end.is_valid()) {
                return Err(ConstraintError::InvalidEnd { segment, point }.into());
            }
        }
        if self.lines.len() + segments > Shores::MAX_EDGES {
            return Err(BuildError::TooManyShores);
        }
        self.shores.push(batch);
        self.lines
            .extend(batch.lines.iter().map(|line| line.saturating_add(first_line)));
        Ok(())
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// Returns the bytes of memory that the ponds take until the end of the build.
    pub(crate) fn byte_size(&self) -> u64 {
        self.lines.len() as u64 * (Shores::BYTES_PER_EDGE + size_of::<u64>() as u64)
    }

    /// Takes the shores out. The lines stay.
    pub(crate) fn take_shores(&mut self) -> Shores {
        std::mem::take(&mut self.shores)
    }

    /// Returns the line of each edge of the shores.
    pub(crate) fn lines(&self) -> &[u64] {
        &self.lines
    }
}
