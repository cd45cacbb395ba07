//! Batches of points, the counts of their source, and the sink for readers of points.
//!
//! In: coordinates with their location in the file, or the flaw of an invalid record. Out: a
//! [`PointBatch`] and [`InputCounts`]. All points pass through this sink, so it ensures what a
//! batch promises: every point is valid and normalized, and either all points have z or none has.

use crate::geometry::Point;
use crate::input::error::{InputError, Location, RecordKind};
use crate::input::flaw::Flaw;
use crate::input::options::{InputOptions, MissingZ};
use crate::input::point_z::PointZ;
use crate::input::reader::{Batch, Sink, Totals};
use crate::shown;
use std::path::Path;

/// A batch of points in input order, as produced by a [`PointSource`](crate::input::PointSource)
/// and accepted by a [`Builder`](crate::Builder).
#[derive(Clone, Debug, Default)]
pub struct PointBatch {
    /// The points: valid and normalized.
    pub points: Vec<Point>,
    /// The elevations of the points, all finite. Empty if the source has no z
    /// ([`has_z`](crate::input::PointSource::has_z)), otherwise as long as `points`.
    pub z: Vec<f64>,
    /// The record numbers of the points, ascending; as long as `points`.
    pub records: Vec<u64>,
}

impl PointBatch {
    /// Returns the number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Returns whether the batch has no points.
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

    /// Removes the ends of segments of no length, in a batch of the ends of segments, two for each.
    /// Such a segment becomes no edge, so nothing would hold a vertex there.
    pub fn remove_pairs_at_one_point(&mut self) {
        let (pairs, _) = self.points.as_chunks::<2>();
        let kept: Vec<bool> = pairs.iter().flat_map(|[a, b]| [a != b; 2]).collect();
        if kept.iter().all(|kept| *kept) {
            return;
        }
        retain(&mut self.points, &kept);
        retain(&mut self.z, &kept);
        retain(&mut self.records, &kept);
    }
}

/// Keeps the elements whose flag is set. Elements without a flag are kept.
fn retain<T>(list: &mut Vec<T>, kept: &[bool]) {
    let mut flags = kept.iter();
    list.retain(|_| flags.next().is_none_or(|kept| *kept));
}

/// The counts of a [`PointSource`](crate::input::PointSource) so far. `records` = `points` +
/// `withheld` + `filtered` + `invalid`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct InputCounts {
    /// The number of records of any kind.
    pub records: u64,
    /// The number of records that became points.
    pub points: u64,
    /// The number of LAS points that were skipped because they are marked as withheld.
    pub withheld: u64,
    /// The number of points that the options exclude: by their place, their number, or for LAS by
    /// their class and return. Points in nodes of a COPC file that are not read count here too,
    /// withheld ones included.
    pub filtered: u64,
    /// The number of invalid records that were skipped.
    pub invalid: u64,
    /// The number of bytes read from the inputs. In a compressed input, compressed bytes count. An
    /// input that has ended counts as a whole, even if parts of it were not needed.
    pub bytes_read: u64,
}

/// The counts over all files of points.
#[derive(Default)]
pub struct PointTotals {
    pub counts: InputCounts,
    /// The number of the first record.
    pub first_record: u64,
    /// The number of points of the current file that had no z and got 0.
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
    /// Takes a record with coordinates.
    #[inline]
    pub fn point(
        &mut self,
        x: f64,
        y: f64,
        z: Option<f64>,
        location: impl FnOnce() -> Location,
    ) -> Result<(), InputError> {
        let point_z = match PointZ::new(x, y, z) {
            Ok(point_z) => point_z,
            Err(flaw) => return self.invalid(location, &flaw),
        };
        if self.options.is_thinned() && !self.is_selected(point_z.point) {
            self.totals.counts.records += 1;
            self.totals.counts.filtered += 1;
            return Ok(());
        }
        if z.is_none() && self.lacks_z() {
            return Err(self.no_z(location()));
        }
        self.batch.points.push(point_z.point);
        self.batch.records.push(self.totals.counts.records);
        if self.wants_z {
            self.totals.padded += u64::from(z.is_none());
            let missing = if self.options.is_description { f64::NAN } else { 0.0 };
            self.batch.z.push(point_z.z.unwrap_or(missing));
        }
        self.totals.counts.records += 1;
        self.totals.counts.points += 1;
        Ok(())
    }

    /// Takes a series of records with coordinates, and returns true. Returns false and takes none
    /// of them if any record is invalid or lacks z, or if not all may be selected. For readers whose records cost next to nothing:
    /// without a branch per record, this takes less than half the time of [`Self::point`].
    pub fn points(
        &mut self,
        points: impl ExactSizeIterator<Item = Point>,
        z: Option<impl Iterator<Item = f64>>,
    ) -> bool {
        if (z.is_none() && self.lacks_z()) || self.options.is_thinned() {
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

    /// Returns whether the options select the next record, which has this point.
    fn is_selected(&self, point: Point) -> bool {
        let InputOptions { bounds, every, .. } = self.options;
        bounds.is_none_or(|bounds| bounds.contains(point)) && self.totals.counts.records.is_multiple_of(every.get())
    }

    /// Returns whether a point without z is an error.
    fn lacks_z(&self) -> bool {
        self.wants_z && self.options.missing_z != MissingZ::Zero
    }

    #[cold]
    fn no_z(&self, location: Location) -> InputError {
        let record = self.totals.counts.records;
        InputError::malformed(
            self.path,
            location,
            format!("record {record} has no z, and other points have"),
            "give all points z, or let them get z = 0 (option `missing_z`: zero)",
        )
    }

    /// Takes an invalid record: counts it, or returns an error if `skip_invalid` is not set.
    #[cold]
    pub fn invalid(&mut self, location: impl FnOnce() -> Location, flaw: &Flaw) -> Result<(), InputError> {
        if !self.options.skip_invalid {
            return Err(self.wrong(RecordKind::Point, self.totals.counts.records, location(), flaw));
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
