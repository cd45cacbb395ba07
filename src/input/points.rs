//! Points: what a batch of them is, what is counted, and what every reader of points has to go through.
//!
//! In: coordinates with their place in the file, or the news that a record is none. Out: a [`PointBatch`] and
//! [`InputCounts`]. Being the one way in, it upholds what the batch promises: valid, normalized, z for all or none.

use crate::geometry::Point;
use crate::input::error::{InputError, Place, RecordKind};
use crate::input::flaw::Flaw;
use crate::input::options::{InputOptions, MissingZ};
use crate::input::reader::{Batch, Sink, Totals};
use crate::input::spot::Spot;
use crate::shown;
use std::path::Path;

/// A batch of points in input order: what a [`PointSource`](crate::input::PointSource) gives, and a
/// [`Builder`](crate::Builder) takes.
#[derive(Clone, Debug, Default)]
pub struct PointBatch {
    /// The points: valid and normalized.
    pub points: Vec<Point>,
    /// Their elevations: finite. Empty if the source has none ([`has_z`](crate::input::PointSource::has_z)), else as long as `points`.
    pub z: Vec<f64>,
    /// Their record numbers, ascending; as long as `points`.
    pub records: Vec<u64>,
}

impl PointBatch {
    /// The number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether the batch has no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Removes all points and keeps the memory.
    pub fn clear(&mut self) {
        self.points.clear();
        self.z.clear();
        self.records.clear();
    }
}

/// What a [`PointSource`](crate::input::PointSource) has read so far. `records` = `points` + `withheld` + `filtered` + `invalid`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct InputCounts {
    /// Records of any kind.
    pub records: u64,
    /// Records that became points.
    pub points: u64,
    /// LAS points that are marked as withheld, and passed over.
    pub withheld: u64,
    /// LAS points that the choice of classes and returns leaves out.
    pub filtered: u64,
    /// Invalid records that were passed over.
    pub invalid: u64,
    /// Bytes taken from the inputs (compressed ones if an input is compressed).
    pub bytes_read: u64,
}

/// What is counted over all files of points.
#[derive(Default)]
pub struct PointTotals {
    pub counts: InputCounts,
    /// Points of the file at hand that had no z and got 0.
    padded: u64,
}

impl Batch for PointBatch {
    type Options = InputOptions;
    type Totals = PointTotals;
    type Tally = ();

    #[inline]
    fn len(&self) -> usize {
        self.points.len()
    }

    fn clear(&mut self) {
        Self::clear(self);
    }
}

impl Totals<PointBatch> for PointTotals {
    fn end_file(&mut self, (): &(), _: u64) -> u64 {
        self.counts.records
    }

    fn notes(&mut self, path: &Path) -> Vec<String> {
        match std::mem::take(&mut self.padded) {
            0 => Vec::new(),
            n => vec![format!("{}: {n} points without z got z = 0", shown::path(path))],
        }
    }
}

impl Sink<'_, PointBatch> {
    /// Takes a record that gives coordinates.
    #[inline]
    pub fn point(&mut self, x: f64, y: f64, z: Option<f64>, place: impl FnOnce() -> Place) -> Result<(), InputError> {
        let spot = match Spot::new(x, y, z) {
            Ok(spot) => spot,
            Err(flaw) => return self.invalid(place, &flaw),
        };
        if z.is_none() && self.lacks_z() {
            return Err(self.no_z(place()));
        }
        self.batch.points.push(spot.point);
        self.batch.records.push(self.totals.counts.records);
        if self.wants_z {
            self.totals.padded += u64::from(z.is_none());
            self.batch.z.push(spot.z.unwrap_or(0.0));
        }
        self.totals.counts.records += 1;
        self.totals.counts.points += 1;
        Ok(())
    }

    /// Takes records that give coordinates, all of them or, if one is not valid or lacks z, none
    /// (false). For readers whose records cost next to nothing: with no branch for each record it
    /// takes less than half the time of [`Self::point`].
    pub fn points(
        &mut self,
        points: impl ExactSizeIterator<Item = Point>,
        z: Option<impl Iterator<Item = f64>>,
    ) -> bool {
        if z.is_none() && self.lacks_z() {
            return false;
        }
        let (before, z_before, n) = (self.batch.points.len(), self.batch.z.len(), points.len());
        let (mut valid, mut padded) = (true, 0);
        self.batch.points.extend(points.map(|point| {
            valid &= point.is_valid();
            point.normalized()
        }));
        match z {
            Some(z) => self.batch.z.extend(z.map(|z| {
                valid &= z.is_finite();
                z + 0.0
            })),
            None if self.wants_z => {
                self.batch.z.resize(z_before + n, 0.0);
                padded = n as u64;
            }
            None => {}
        }
        if !valid {
            self.batch.points.truncate(before);
            self.batch.z.truncate(z_before);
            return false;
        }
        let first = self.totals.counts.records;
        self.batch.records.extend(first..first + n as u64);
        self.totals.counts.records += n as u64;
        self.totals.counts.points += n as u64;
        self.totals.padded += padded;
        true
    }

    /// Whether a point without z is an error.
    fn lacks_z(&self) -> bool {
        self.wants_z && self.options.missing_z == MissingZ::Error
    }

    #[cold]
    fn no_z(&self, place: Place) -> InputError {
        let record = self.totals.counts.records;
        InputError::malformed(
            self.path,
            place,
            format!("record {record} has no z, and other points have"),
            "give all points z, or allow that they get z = 0 (--missing-z zero)",
        )
    }

    /// Takes a record that is no valid point: an error, or counted.
    #[cold]
    pub fn invalid(&mut self, place: impl FnOnce() -> Place, flaw: &Flaw) -> Result<(), InputError> {
        if !self.options.skip_invalid {
            return Err(self.wrong(RecordKind::Point, self.totals.counts.records, place(), flaw));
        }
        self.pass_over();
        Ok(())
    }

    /// Counts an invalid record.
    pub fn pass_over(&mut self) {
        self.totals.counts.records += 1;
        self.totals.counts.invalid += 1;
    }
}
