//! The points of a batch, by their record numbers.

use crate::geometry::Point;
use crate::input::PointBatch;

/// Where there is no point.
const NONE: u32 = u32::MAX;

/// Finds a point of a batch, in whatever order the records are. The last of several with one number counts.
#[derive(Debug)]
pub(crate) struct Lookup<'a> {
    points: &'a [Point],
    /// The lowest and the highest number.
    pub(crate) first: u64,
    pub(crate) last: u64,
    index: RecordIndex,
}

#[derive(Debug)]
enum RecordIndex {
    /// The place of each number from the first on.
    Table(Vec<u32>),
    /// Numbers with their places, in order.
    Sorted(Vec<(u64, u32)>),
}

impl<'a> Lookup<'a> {
    /// None: there are no points.
    pub(crate) fn new(batch: &'a PointBatch) -> Option<Self> {
        let (&first, &last) = batch.records.iter().min().zip(batch.records.iter().max())?;
        let numbered = batch.records.iter().copied().zip(0u32..);
        // A few gaps cost less than searching.
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

    /// The point with a number.
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
