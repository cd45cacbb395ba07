//! The points of a batch, by record number.

use crate::geometry::Point;
use crate::input::PointBatch;

/// The index for a record without a point.
const NONE: u32 = u32::MAX;

/// An index of the points of a batch by record number. Records may be in any order. Of several
/// points with the same record number, the last one counts.
#[derive(Debug)]
pub(crate) struct Lookup<'a> {
    points: &'a [Point],
    /// The smallest and the largest record number.
    pub(crate) first: u64,
    pub(crate) last: u64,
    index: RecordIndex,
}

#[derive(Debug)]
enum RecordIndex {
    /// The index of the point of each record number, from the first on.
    Table(Vec<u32>),
    /// Record numbers and the indices of their points, sorted.
    Sorted(Vec<(u64, u32)>),
}

impl<'a> Lookup<'a> {
    /// Makes an index. Returns `None` if there are no points.
    pub(crate) fn new(batch: &'a PointBatch) -> Option<Self> {
        let (&first, &last) = batch.records.iter().min().zip(batch.records.iter().max())?;
        let numbered = batch.records.iter().copied().zip(0u32..);
        // A few gaps cost less than a search.
        let index = if last - first < 4 * batch.records.len() as u64 {
            let mut table = vec![NONE; (last - first) as usize + 1];
            for (record, index) in numbered {
                table[(record - first) as usize] = index;
            }
            RecordIndex::Table(table)
        } else {
            let mut sorted: Vec<(u64, u32)> = numbered.collect();
            sorted.sort_unstable();
            RecordIndex::Sorted(sorted)
        };
        Some(Self {
            points: &batch.points,
            first,
            last,
            index,
        })
    }

    /// Returns the point with a record number.
    #[inline]
    pub(crate) fn point(&self, record: u64) -> Option<Point> {
        let index = match &self.index {
            RecordIndex::Table(table) => {
                let at = usize::try_from(record.checked_sub(self.first)?).ok()?;
                *table.get(at)?
            }
            RecordIndex::Sorted(sorted) => {
                let after = sorted.partition_point(|&(other, _)| other <= record);
                let &(found, index) = sorted.get(after.checked_sub(1)?)?;
                if found == record { index } else { NONE }
            }
        };
        self.points.get(index as usize).map(|point| point.normalized())
    }
}
