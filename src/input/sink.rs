//! Where every reader puts its records: checks them, numbers them, counts them.
//!
//! In: coordinates with their place in the file, or the news that a record is none. Out: a [`PointBatch`] and
//! [`InputCounts`]. Being the one way in, it upholds what the batch promises: valid, normalized, z for all or none.

use super::{InputError, MissingZ, Place, PointBatch};
use crate::geometry::Point;
use std::path::Path;

/// Points in a full batch.
const BATCH: usize = 8192;

/// What was read so far. `records` = `points` + `withheld` + `filtered` + `invalid`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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

/// The way from one file into one batch.
pub(super) struct Sink<'a> {
    pub batch: &'a mut PointBatch,
    pub counts: &'a mut InputCounts,
    pub path: &'a Path,
    pub skip_invalid: bool,
    /// Whether the batches have z.
    pub wants_z: bool,
    /// Points of the file that had no z and got 0.
    pub padded: &'a mut u64,
    pub missing_z: MissingZ,
}

impl Sink<'_> {
    /// Whether the batch should be handed out before more is put in.
    #[inline]
    pub fn is_full(&self) -> bool {
        self.batch.points.len() >= BATCH
    }

    /// The number of points that the batch still takes.
    pub fn room(&self) -> usize {
        BATCH.saturating_sub(self.batch.points.len())
    }

    /// Takes a record that gives coordinates.
    #[inline]
    pub fn point(&mut self, x: f64, y: f64, z: Option<f64>, place: impl FnOnce() -> Place) -> Result<(), InputError> {
        let point = Point::new(x, y);
        if !point.is_valid() || z.is_some_and(|z| !z.is_finite()) {
            return self.invalid(place, || describe(x, y, z));
        }
        if z.is_none() && self.lacks_z() {
            return Err(self.no_z(place()));
        }
        self.batch.points.push(point.normalized());
        self.batch.records.push(self.counts.records);
        if self.wants_z {
            *self.padded += u64::from(z.is_none());
            self.batch.z.push(z.unwrap_or(0.0) + 0.0);
        }
        self.counts.records += 1;
        self.counts.points += 1;
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
        let first = self.counts.records;
        self.batch.records.extend(first..first + n as u64);
        self.counts.records += n as u64;
        self.counts.points += n as u64;
        *self.padded += padded;
        true
    }

    /// Whether a point without z is an error.
    fn lacks_z(&self) -> bool {
        self.wants_z && self.missing_z == MissingZ::Error
    }

    #[cold]
    fn no_z(&self, place: Place) -> InputError {
        InputError::Malformed {
            path: self.path.to_owned(),
            place,
            problem: format!("record {} has no z, and other points have", self.counts.records),
            hint: "give all points z, or allow that they get z = 0 (--missing-z zero)",
            source: None,
        }
    }

    /// Takes a record that is no valid point: an error, or counted.
    #[cold]
    pub fn invalid(&mut self, place: impl FnOnce() -> Place, found: impl FnOnce() -> String) -> Result<(), InputError> {
        if !self.skip_invalid {
            return Err(InputError::Record {
                path: self.path.to_owned(),
                record: self.counts.records,
                place: place(),
                found: found(),
            });
        }
        self.counts.records += 1;
        self.counts.invalid += 1;
        Ok(())
    }
}

/// What is wrong with coordinates of which at least one is not valid.
pub(super) fn describe(x: f64, y: f64, z: Option<f64>) -> String {
    let (name, value) = if !Point::new(x, 0.0).is_valid() {
        ("x", x)
    } else if !Point::new(0.0, y).is_valid() {
        ("y", y)
    } else {
        ("z", z.unwrap_or(f64::NAN))
    };
    if !value.is_finite() {
        format!("{name} is {value}, not a finite number")
    } else if value.abs() > 1.0 {
        format!("{name} is {value:e}, of greater magnitude than 2^200, the most that exact arithmetic takes")
    } else {
        format!("{name} is {value:e}, nearer to zero than 2^-142, the least that exact arithmetic takes")
    }
}
