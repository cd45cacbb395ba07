//! What a build keeps of polygons while their segments come.

use std::path::Path;

use crate::constraints::error::ConstraintError;
use crate::constraints::polygons::check::{PolygonCheck, PolygonCounter, PolygonFaults, by_ends};
use crate::constraints::segments::spool::SegmentSpool;
use crate::input::SegmentBatch;
use crate::store::{EdgeSource, LineKind};

/// The polygons of a build.
#[derive(Debug)]
pub(crate) struct Arrivals {
    /// Unless those that are inside out are to be put right.
    check: Option<PolygonCheck>,
    counter: PolygonCounter,
    /// For each polygon but the first how many segments by their ends came before it. Those of no length do not count.
    starts: Option<Vec<u64>>,
    by_ends: u64,
    between: u64,
}

impl Arrivals {
    /// Of a build that checks polygons or not, in so many bytes of memory, and that splits segments or not.
    pub(crate) fn new((checks, splits): (bool, bool), folder: &Path, memory: u64) -> Self {
        Self {
            check: checks.then(|| PolygonCheck::new(folder, memory)),
            counter: PolygonCounter::default(),
            starts: splits.then(Vec::new),
            by_ends: 0,
            between: 0,
        }
    }

    /// Takes a batch of obstacles.
    ///
    /// An error is a batch that does not tell of all segments which polygon they are of, or one of [`PolygonCheck::push`].
    pub(crate) fn push(&mut self, first_line: u64, batch: &SegmentBatch) -> Result<(), ConstraintError> {
        let (segments, polygons) = (batch.ends.len(), batch.polygons.len());
        if polygons != 0 && polygons != segments {
            return Err(ConstraintError::PolygonNumbers { segments, polygons });
        }
        if let Some(check) = &mut self.check {
            check.push(first_line, batch)?;
        }
        for (key, _, [a, b]) in by_ends(first_line, batch) {
            let (before, polygon) = (self.counter.number(), self.counter.next(key));
            if let Some(starts) = self.starts.as_mut().filter(|_| before != polygon) {
                starts.push(self.by_ends);
            }
            self.by_ends += u64::from(a != b);
        }
        self.between += batch.records.len() as u64;
        Ok(())
    }

    /// What is wrong with the polygons that came by their ends.
    ///
    /// Errors are those of [`PolygonCheck::push`].
    pub(crate) fn faults(&mut self) -> Result<PolygonFaults, ConstraintError> {
        self.check
            .as_mut()
            .map_or_else(|| Ok(PolygonFaults::default()), PolygonCheck::finish)
    }

    /// What is wrong with any, once all points have come.
    ///
    /// Errors are those of [`PolygonCheck::push`], or what reading the segments says.
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

    /// Tells the polygons of segments that have a length, in the order of the spool.
    pub(crate) fn numbers(&self) -> PolygonNumbers<'_> {
        PolygonNumbers {
            starts: self.starts.as_deref().unwrap_or_default(),
            by_ends: self.by_ends,
            given: 0,
            number: 0,
        }
    }
}

/// Tells the polygons of segments.
#[derive(Debug)]
pub(crate) struct PolygonNumbers<'a> {
    starts: &'a [u64],
    by_ends: u64,
    given: u64,
    number: usize,
}

impl PolygonNumbers<'_> {
    /// That of the next segment of an obstacle; that of others is 0.
    pub(crate) fn next(&mut self, source: EdgeSource) -> u64 {
        /// From here on those of segments between points are numbered, by their lines.
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
