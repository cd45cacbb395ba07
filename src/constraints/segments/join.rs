//! The join of segments with the points whose record numbers define them.
//!
//! In: two record numbers for each segment, and then points in batches. Out: the positions of all
//! ends, part by part.
//!
//! Parts are made one after another as records arrive. Each part is a small join of its own
//! ([`JoinPart`]). A batch goes along all parts. So the parts need not be merged: in each part, the
//! pairs of the batch's records are adjacent. Batches should come in the order of their records, as
//! inputs do. If they do not, parts search for the position where they continue.

use std::io;

use crate::constraints::segments::chunk_store::ChunkStore;
use crate::constraints::segments::join_part::{END_BITS, JoinPart, PartLimits};
use crate::constraints::segments::lookup::Lookup;
use crate::geometry::Point;
use crate::input::PointBatch;
use crate::memory::JoinShares;

/// Smallest number of ends of a part, if memory allows it. This number of ends is sorted, and
/// written to their positions, within the processor's cache.
const FEW_ENDS: u64 = 1 << 16;
/// Number of parts of one size before parts get larger. Each part costs memory, and time with every
/// batch.
const PARTS: u64 = 64;

/// Records that wait for their points.
#[derive(Debug)]
pub(crate) struct Join {
    shares: JoinShares,
    parts: Vec<JoinPart>,
    /// Number of ends in all parts.
    ends: u64,
    /// The records of ends that are in no part yet.
    records: Vec<u64>,
}

impl Join {
    /// Makes an empty join.
    pub(crate) fn new(shares: JoinShares) -> Self {
        Self {
            shares,
            parts: Vec::new(),
            ends: 0,
            records: Vec::new(),
        }
    }

    /// Returns the number of segments that wait or waited.
    pub(crate) fn segments(&self) -> u64 {
        (self.ends + self.records.len() as u64) / 2
    }

    /// Returns the bytes in memory, except those of chunks that the store keeps there.
    pub(crate) fn byte_size(&self) -> u64 {
        let parts: usize = self.parts.iter().map(JoinPart::byte_size).sum();
        (parts + self.records.capacity() * size_of::<u64>()) as u64
    }

    /// Returns the largest number of ends of the next part: the number that half of the memory can
    /// sort, or write to their positions. It is even.
    fn part_ends(&self) -> usize {
        let most = self.shares.part_ends.clamp(16, 1 << END_BITS);
        ((self.ends / PARTS).max(FEW_ENDS).min(most) & !1) as usize
    }

    /// Adds the records of segments.
    pub(crate) fn push(&mut self, segments: &[[u64; 2]], store: &ChunkStore) -> io::Result<()> {
        let mut records = segments.as_flattened();
        while !records.is_empty() {
            let most = self.part_ends();
            if self.records.is_empty() {
                self.records.reserve_exact(most);
            }
            let (now, later) = records.split_at(records.len().min(most.saturating_sub(self.records.len())));
            self.records.extend_from_slice(now);
            records = later;
            if self.records.len() >= most {
                self.add_part(store)?;
            }
        }
        Ok(())
    }

    fn add_part(&mut self, store: &ChunkStore) -> io::Result<()> {
        let chunk_bytes = self.shares.chunk;
        let part = JoinPart::new(&mut self.records, chunk_bytes, store)?;
        self.ends += u64::from(part.ends());
        self.parts.push(part);
        Ok(())
    }

    /// Finds the ends that are among the points of a batch.
    pub(crate) fn resolve(&mut self, batch: &PointBatch, store: &ChunkStore) -> io::Result<()> {
        if !self.records.is_empty() {
            self.add_part(store)?;
        }
        if self.parts.is_empty() {
            return Ok(());
        }
        self.records = Vec::new();
        let Some(points) = Lookup::new(batch) else {
            return Ok(());
        };
        // The capacity of a buffer grows to twice its contents. Much smaller buffers would cost
        // more time than they save memory.
        let share = self.shares.found / self.parts.len() as u64;
        let found = share.clamp(256, 64 << 10) as usize;
        for (part, number) in self.parts.iter_mut().zip(0..) {
            let limits = PartLimits {
                found,
                keeps_pairs: number < self.shares.kept_chunks,
            };
            part.resolve(&points, limits, store)?;
        }
        Ok(())
    }

    /// Frees the memory that only arriving points need. More points may still come.
    pub(crate) fn rest(&mut self, store: &ChunkStore) -> io::Result<()> {
        if !self.records.is_empty() {
            self.add_part(store)?;
        }
        self.records = Vec::new();
        self.parts.iter_mut().for_each(JoinPart::rest);
        Ok(())
    }

    /// Passes the ends of all segments to `take`, in order and in batches, after
    /// [`rest`](Self::rest). If an end has no point, returns the error that `missing` makes of the
    /// first such segment and the record.
    ///
    /// If `is_last`, frees the chunks.
    pub(crate) fn for_each<E: From<io::Error>>(
        &mut self,
        is_last: bool,
        store: &ChunkStore,
        mut take: impl FnMut(&[[Point; 2]]) -> Result<(), E>,
        missing: impl Fn(u64, u64) -> E,
    ) -> Result<(), E> {
        let mut positions = Vec::new();
        let mut first_end = 0;
        for part in &mut self.parts {
            if let Err((end, record)) = part.positions(is_last, store, &mut positions)? {
                return Err(missing((first_end + u64::from(end)) / 2, record));
            }
            take(positions.as_chunks().0)?;
            first_end += u64::from(part.ends());
        }
        Ok(())
    }
}
