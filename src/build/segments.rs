//! The segments of a build, as they come: by their ends, or by the record numbers of points that are still to come.

use super::BuildError;
use crate::geometry::Point;
use crate::input::PointBatch;

/// Segments, all in memory.
#[derive(Debug, Default)]
pub(super) struct Segments {
    by_ends: Vec<[Point; 2]>,
    between: Vec<[Point; 2]>,
    /// The records that `between` waits for, in order once points come, and the ends that are to be there.
    wanted: Vec<(u64, u32)>,
    is_sorted: bool,
}

/// The place of an end that was not found yet.
const NOWHERE: Point = Point {
    x: f64::NAN,
    y: f64::NAN,
};

impl Segments {
    /// Takes segments by their ends.
    pub(super) fn push(&mut self, segments: &[[Point; 2]]) -> Result<(), BuildError> {
        let numbered = segments.iter().zip(self.len()..);
        for (ends, segment) in numbered {
            if let Some(&point) = ends.iter().find(|end| !end.is_valid()) {
                return Err(BuildError::InvalidEnd { segment, point });
            }
        }
        self.by_ends
            .extend(segments.iter().map(|ends| ends.map(Point::normalized)));
        Ok(())
    }

    /// Takes segments by the record numbers of their ends.
    pub(super) fn push_between(&mut self, records: &[[u64; 2]]) {
        let first = 2 * self.between.len() as u32;
        self.wanted.extend(records.as_flattened().iter().copied().zip(first..));
        self.between.resize(self.between.len() + records.len(), [NOWHERE; 2]);
        self.is_sorted = false;
    }

    fn len(&self) -> u64 {
        (self.by_ends.len() + self.between.len()) as u64
    }

    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes that they take; those of each cell among them take a little more.
    pub(super) fn byte_size(&self) -> u64 {
        let bytes = size_of_val(&*self.by_ends) + size_of_val(&*self.between) + size_of_val(&*self.wanted);
        bytes as u64 + 8 * self.len()
    }

    /// Fails if they take more than half of so much memory, or are too many to be numbered.
    pub(super) fn check_memory(&self, budget: u64) -> Result<(), BuildError> {
        let needed = 2 * self.byte_size();
        if needed > budget || self.len() > u64::from(u32::MAX / 2) {
            return Err(BuildError::Segments { needed, budget });
        }
        Ok(())
    }

    /// Finds the ends that are among these points.
    pub(super) fn resolve(&mut self, batch: &PointBatch) {
        if self.wanted.is_empty() {
            return;
        }
        if !self.is_sorted {
            self.wanted.sort_unstable();
            self.is_sorted = true;
        }
        let Some(&first) = batch.records.first() else { return };
        let mut at = self.wanted.partition_point(|&(record, _)| record < first);
        for (&record, point) in batch.records.iter().zip(&batch.points) {
            while self.wanted.get(at).is_some_and(|wanted| wanted.0 < record) {
                at += 1;
            }
            while let Some(&(_, end)) = self.wanted.get(at).filter(|wanted| wanted.0 == record) {
                self.between.as_flattened_mut()[end as usize] = point.normalized();
                at += 1;
            }
        }
    }

    /// Those whose ends are no points of the input.
    pub(super) fn by_ends(&self) -> &[[Point; 2]] {
        &self.by_ends
    }

    /// All, but for those of no length.
    pub(super) fn finish(self) -> Result<Vec<[Point; 2]>, BuildError> {
        let missing = |&&(_, end): &&(u64, u32)| self.between.as_flattened()[end as usize].x.is_nan();
        if let Some(&(record, end)) = self.wanted.iter().find(missing) {
            return Err(BuildError::NoSuchRecord {
                segment: (end / 2).into(),
                record,
            });
        }
        let mut all = self.by_ends;
        all.extend(self.between);
        all.retain(|[a, b]| a != b);
        Ok(all)
    }
}
