//! The state of a build's polygons while their segments arrive.

use std::path::Path;

use crate::constraints::error::ConstraintError;
use crate::constraints::polygons::check::{PolygonCheck, PolygonFaults};
use crate::constraints::polygons::counter::{Begins, PolygonCounter, by_ends};
use crate::constraints::polygons::lines::PolygonLines;
use crate::constraints::polygons::normalize::PolygonNormalizer;
use crate::constraints::segments::spool::SegmentSpool;
use crate::input::SegmentBatch;
use crate::store::{EdgeSource, LineKind, PolygonLine};

/// The polygons of a build.
#[derive(Debug)]
pub(crate) struct Arrivals {
    /// `None` if polygons that are inside out are to be repaired.
    check: Option<PolygonCheck>,
    counter: PolygonCounter,
    lines: PolygonLines,
    /// For each polygon but the first, the number of segments by their ends that came before it.
    /// Segments of zero length do not count.
    starts: Option<Vec<u64>>,
    by_ends: u64,
    between: u64,
}

impl Arrivals {
    /// Makes the state of a build. `checks` says whether it checks polygons, within `memory` bytes
    /// of memory; `splits` says whether it splits segments.
    pub(crate) fn new((checks, splits): (bool, bool), folder: &Path, memory: u64) -> Self {
        Self {
            check: checks.then(|| PolygonCheck::new(folder, memory)),
            counter: PolygonCounter::default(),
            lines: PolygonLines::default(),
            starts: splits.then(Vec::new),
            by_ends: 0,
            between: 0,
        }
    }

    /// Adds a batch of obstacles.
    ///
    /// Returns an error if the batch has polygon numbers for some of its segments only, or an error
    /// of [`PolygonCheck::push`].
    pub(crate) fn push(&mut self, first_line: u64, batch: &SegmentBatch) -> Result<(), ConstraintError> {
        let (segments, polygons) = (batch.ends.len(), batch.polygons.len());
        if polygons != 0 && polygons != segments {
            return Err(ConstraintError::PolygonNumbers { segments, polygons });
        }
        if let Some(check) = &mut self.check {
            check.push(first_line, batch)?;
        }
        for (key, line, _) in by_ends(first_line, batch).filter(|(_, _, [a, b])| a != b) {
            let begins = self.counter.next(key, line);
            self.lines.take(begins, line);
            if let Some(starts) = self.starts.as_mut()
                && begins != Begins::Nothing
                && self.by_ends > 0
            {
                starts.push(self.by_ends);
            }
            self.by_ends += 1;
        }
        self.between += batch.records.len() as u64;
        Ok(())
    }

    /// Returns the faults of the polygons that came by their ends.
    ///
    /// Errors are those of [`PolygonCheck::push`].
    pub(crate) fn faults(&mut self) -> Result<PolygonFaults, ConstraintError> {
        self.check
            .as_mut()
            .map_or_else(|| Ok(PolygonFaults::default()), PolygonCheck::finish)
    }

    /// Returns the faults of all polygons, once all points have arrived.
    ///
    /// Errors are those of [`PolygonCheck::push`] and those of reading the segments.
    pub(crate) fn all_faults(&mut self, segments: &mut SegmentSpool) -> Result<PolygonFaults, ConstraintError> {
        let faults = self.faults()?;
        let Some(check) = self.check.as_mut().filter(|_| self.between > 0) else {
            return Ok(faults);
        };
        let mut by_ends = self.by_ends;
        segments.for_each_chunk(|some| {
            for segment in some
                .iter()
                .filter(|segment| segment.source.kind() == LineKind::Obstacle)
            {
                match by_ends.checked_sub(1) {
                    Some(left) => by_ends = left,
                    None => check.take(segment.source.number(), segment.source.number(), segment.ends)?,
                }
            }
            Ok(())
        })?;
        check.finish()
    }

    /// Returns the normaliser of the segments in the order of the spool, once their faults are
    /// known; `None` if all obstacles cover each place 0 or 1 times, or if they are to be repaired.
    pub(crate) fn normalizer(&self) -> Option<PolygonNormalizer> {
        self.check.as_ref().and_then(PolygonCheck::normalizer)
    }

    /// Returns the lines that belong to the polygon of a smaller line, in order.
    pub(crate) fn take_lines(&mut self) -> Vec<PolygonLine> {
        std::mem::take(&mut self.lines).finish()
    }

    /// Returns the polygon numbers of the segments of nonzero length, in the order of the spool.
    pub(crate) fn numbers(&self) -> PolygonNumbers<'_> {
        PolygonNumbers {
            starts: self.starts.as_deref().unwrap_or_default(),
            by_ends: self.by_ends,
            given: 0,
            number: 0,
        }
    }
}

/// The polygon numbers of segments, in order.
#[derive(Debug)]
pub(crate) struct PolygonNumbers<'a> {
    starts: &'a [u64],
    by_ends: u64,
    given: u64,
    number: usize,
}

impl PolygonNumbers<'_> {
    /// Returns the polygon number of the next segment, which has this source. It is 0 unless the
    /// source is an obstacle.
    pub(crate) fn next(&mut self, source: EdgeSource) -> u64 {
        /// The first polygon number of segments between points. These are numbered by their lines.
        const BETWEEN: u64 = 1 << 63;
        if source.kind() != LineKind::Obstacle {
            return 0;
        }
        if self.given == self.by_ends {
            return BETWEEN | source.number();
        }
        while self.starts.get(self.number).is_some_and(|&start| start <= self.given) {
            self.number += 1;
        }
        self.given += 1;
        self.number as u64
    }
}
