//! The lines that are pushed to an editor, to come or to go.

use std::path::Path;

use crate::constraints::error::ConstraintError;
use crate::constraints::polygons::check::{PolygonCheck, PolygonFaults};
use crate::constraints::polygons::counter::{PolygonCounter, by_ends};
use crate::constraints::polygons::lines::PolygonLines;
use crate::constraints::polygons::normalize::PolygonNormalizer;
use crate::constraints::segment::Segment;
use crate::edit::EditError;
use crate::geometry::Point;
use crate::input::SegmentBatch;
use crate::store::{EdgeSource, LineKind, LinePart, PolygonLine};

/// The lines that were pushed so far.
pub(crate) struct LineIntake {
    /// The number of the first line.
    first_line: u64,
    pub(crate) segments: Vec<Segment>,
    polygons: PolygonCheck,
    counter: PolygonCounter,
    polygon_lines: PolygonLines,
}

/// All lines, with what was found out about obstacles.
pub(crate) struct TakenLines {
    pub(crate) segments: Vec<Segment>,
    /// Normalises the obstacles that cover a place more than once; `None` if none does.
    pub(crate) normalizer: Option<PolygonNormalizer>,
    pub(crate) polygon_lines: Vec<PolygonLine>,
    pub(crate) faults: PolygonFaults,
}

impl LineIntake {
    /// Creates an intake for the lines of a file, numbered from `first_line` on.
    pub(crate) fn new(file: &Path, first_line: u64) -> Self {
        Self {
            first_line,
            segments: Vec::new(),
            // All segments are in memory, and a polygon takes no more than what is counted for
            // them.
            polygons: PolygonCheck::new(file, u64::MAX),
            counter: PolygonCounter::default(),
            polygon_lines: PolygonLines::default(),
        }
    }

    /// Takes segments, whose lines are numbered from `first_line` on among those of the intake.
    pub(crate) fn push(&mut self, kind: LineKind, first_line: u64, batch: &SegmentBatch) -> Result<(), EditError> {
        if !batch.records.is_empty() {
            return Err(EditError::Records);
        }
        let (segments, polygons) = (batch.ends.len(), batch.polygons.len());
        if polygons != 0 && polygons != segments {
            return Err(ConstraintError::PolygonNumbers { segments, polygons }.into());
        }
        let first = self.first_line + first_line;
        let segments = batch.ends.iter().zip(&batch.lines).map(|(&ends, &line)| Segment {
            ends: ends.map(Point::normalized),
            source: LinePart::whole(EdgeSource::new(kind, first + line)),
        });
        self.segments.extend(segments);
        if kind == LineKind::Obstacle {
            self.polygons.push(first, batch)?;
            for (key, line, _) in by_ends(first, batch).filter(|(_, _, [a, b])| a != b) {
                self.polygon_lines.take(self.counter.next(key, line), line);
            }
        }
        Ok(())
    }

    /// Completes the check of obstacles.
    ///
    /// # Errors
    /// Returns an error if a ring does not close or if a polygon is inside out.
    pub(crate) fn finish(self) -> Result<TakenLines, EditError> {
        let Self {
            mut segments,
            mut polygons,
            polygon_lines,
            ..
        } = self;
        let faults = polygons.finish()?;
        if let Some(line) = faults.open {
            return Err(EditError::OpenRing { line });
        }
        if let Some(inverted) = faults.inverted {
            return Err(EditError::Inverted(inverted));
        }
        segments.shrink_to_fit();
        Ok(TakenLines {
            segments,
            normalizer: polygons.normalizer(),
            polygon_lines: polygon_lines.finish(),
            faults,
        })
    }
}
