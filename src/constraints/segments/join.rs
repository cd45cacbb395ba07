//! The join of segments with the points that they were given by.
//!
//! In: record numbers, two for each segment, and then points in batches. Out: the places of all ends, part by part.
//!
//! Parts are made one after the other as records come, and each is a small join of its own ([`JoinPart`]). A batch goes along all
//! of them, which is a merge that nobody needs to do: in each part the pairs of its records lie together. Batches should come
//! in the order of their records, as inputs do; if they do not, parts look for the place to go on.

use std::io;

use crate::constraints::segments::chunk_store::ChunkStore;
use crate::constraints::segments::join_part::{END_BITS, JoinPart, PartLimits};
use crate::constraints::segments::lookup::Lookup;
use crate::geometry::Point;
use crate::input::PointBatch;
use crate::memory::JoinShares;

/// Ends of a part at least, if memory allows it: so many are sorted, and put in their places, in the processor's cache.
const FEW_ENDS: u64 = 1 << 16;
/// Parts of one size, before they get larger: each costs memory, and time with every batch.
const PARTS: u64 = 64;

/// Records that wait for their points.
#[derive(Debug)]
pub(crate) struct Join {
    shares: JoinShares,
    parts: Vec<JoinPart>,
    /// Ends in all parts.
    ends: u64,
    /// The records of ends that are in no part yet.
    records: Vec<u64>,
}

impl Join {
    /// Nothing yet.
    pub(crate) fn new(shares: JoinShares) -> Self {
        Self {
            shares,
            parts: Vec::new(),
            ends: 0,
            records: Vec::new(),
        }
    }

    /// How many segments wait, or waited.
    pub(crate) fn segments(&self) -> u64 {
        (self.ends + self.records.len() as u64) / 2
    }

    /// Bytes in memory, but for those of chunks that the store keeps there.
    pub(crate) fn byte_size(&self) -> u64 {
        let parts: usize = self.parts.iter().map(JoinPart::byte_size).sum();
        (parts + self.records.capacity() * size_of::<u64>()) as u64
    }

    /// The most ends of the next part: as many as half of the memory can sort, or put in their places. Even.
    fn part_ends(&self) -> usize {
        let most = self.shares.part_ends.clamp(16, 1 << END_BITS);
        ((self.ends / PARTS).max(FEW_ENDS).min(most) & !1) as usize
    }

    /// Takes the records of segments.
    pub(crate) fn push(&mut self, segments: &[[u64; 2]], store: &mut ChunkStore) -> io::Result<()> {
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

    fn add_part(&mut self, store: &mut ChunkStore) -> io::Result<()> {
        let chunk_bytes = self.shares.chunk;
        let part = JoinPart::new(&mut self.records, chunk_bytes, store)?;
        self.ends += u64::from(part.ends());
        self.parts.push(part);
        Ok(())
    }

    /// Finds the ends that are among these points.
    pub(crate) fn resolve(&mut self, batch: &PointBatch, store: &mut ChunkStore) -> io::Result<()> {
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
        // A buffer grows to twice what is in it. Much smaller ones would cost more time than they save memory.
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

    /// Points have come: gives back the memory that only they needed. More may come all the same.
    pub(crate) fn rest(&mut self, store: &mut ChunkStore) -> io::Result<()> {
        if !self.records.is_empty() {
            self.add_part(store)?;
        }
        self.records = Vec::new();
        self.parts.iter_mut().for_each(JoinPart::rest);
        Ok(())
    }

    /// Gives the ends of all segments in order, some at a time, after [`rest`](Self::rest). If no point came for one of them,
    /// the error is what `missing` makes of the first segment with such an end, and the record.
    ///
    /// If it is for the last time, chunks are given up.
    pub(crate) fn for_each<E: From<io::Error>>(
        &mut self,
        is_last: bool,
        store: &mut ChunkStore,
        mut take: impl FnMut(&[[Point; 2]], &mut ChunkStore) -> Result<(), E>,
        missing: impl Fn(u64, u64) -> E,
    ) -> Result<(), E> {
        let mut positions = Vec::new();
        let mut first_end = 0;
        for part in &mut self.parts {
            if let Err((end, record)) = part.positions(is_last, store, &mut positions)? {
                return Err(missing((first_end + u64::from(end)) / 2, record));
            }
            take(positions.as_chunks().0, store)?;
            first_end += u64::from(part.ends());
        }
        Ok(())
    }
}
