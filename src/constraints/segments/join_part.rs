//! A part of the ends that wait for points: consecutive ends, as many as memory has room for.
//!
//! In: their record numbers, in the order of the ends. Out: their positions.
//!
//! ```text
//! records ─▶ (record, end) sorted ─▶ chunks ─┐ as points arrive, one pass along
//! points  ───────────────────────────────────┴─▶ (end, position) ─▶ chunks ─▶ positions in memory
//! ```
//!
//! Within a part, the number of an end has few bits. So it fits into a word beside the record,
//! which sorts fast.

use std::io;

use crate::constraints::segments::chunk_store::{Chunk, ChunkStore, damaged};
use crate::constraints::segments::found_ends::FoundEnds;
use crate::constraints::segments::lookup::Lookup;
use crate::constraints::segments::radix::sort_by_bits;
use crate::geometry::Point;

/// Base-2 logarithm of the largest number of ends of a part.
pub(crate) const END_BITS: u32 = 20;
/// Bytes of a pair that fits into a word, and of one that does not.
const NARROW: usize = 8;
const WIDE: usize = 12;

/// A part of the ends that wait for points.
#[derive(Debug)]
pub(crate) struct JoinPart {
    ends: u32,
    /// Whether records are too far apart for pairs to fit into a word.
    is_wide: bool,
    /// The highest record.
    last: u64,
    pairs: Vec<PairChunk>,
    cursor: Cursor,
    found: FoundEnds,
}

/// Pairs in order of their records.
#[derive(Debug)]
struct PairChunk {
    /// The smallest record. The others are stored relative to it.
    first: u64,
    chunk: Chunk,
}

/// The first pair with a record that is larger than all those whose points were seen.
#[derive(Debug, Default)]
struct Cursor {
    chunk: usize,
    pair: usize,
    seen: Option<u64>,
    /// The chunk in `buffer`.
    loaded: Option<usize>,
    buffer: Vec<u8>,
}

/// Limits of a part while points arrive.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartLimits {
    /// Bytes of found ends before they go to a chunk.
    pub(crate) found: usize,
    /// Whether a chunk of pairs may stay between batches.
    pub(crate) keeps_pairs: bool,
}

impl JoinPart {
    /// Makes a part of the ends that wait for `records`, of which there must be at least one.
    /// Chunks of pairs take about `chunk_bytes` bytes. Empties `records`.
    pub(crate) fn new(records: &mut Vec<u64>, chunk_bytes: usize, store: &ChunkStore) -> io::Result<Self> {
        let first = records.iter().copied().min().unwrap_or(0);
        let last = records.iter().copied().max().unwrap_or(0);
        let record_bits = u64::BITS - (last - first).leading_zeros();
        let mut part = Self {
            ends: records.len() as u32,
            is_wide: record_bits + END_BITS > u64::BITS,
            last,
            pairs: Vec::new(),
            cursor: Cursor::default(),
            found: FoundEnds::default(),
        };
        let mut bytes = Vec::with_capacity(chunk_bytes + WIDE);
        if part.is_wide {
            let mut pairs: Vec<(u64, u32)> = records.drain(..).zip(0..).collect();
            pairs.sort_unstable();
            for pairs in pairs.chunks((chunk_bytes / WIDE).max(1)) {
                bytes.clear();
                for (record, end) in pairs {
                    bytes.extend_from_slice(&(record - pairs[0].0).to_le_bytes());
                    bytes.extend_from_slice(&end.to_le_bytes());
                }
                part.append_pairs(pairs[0].0, &bytes, store)?;
            }
        } else {
            for (record, end) in records.iter_mut().zip(0..) {
                *record = (*record - first) << END_BITS | end;
            }
            sort_by_bits(records, END_BITS, END_BITS + record_bits);
            for pairs in records.chunks((chunk_bytes / NARROW).max(1)) {
                let before = pairs[0] >> END_BITS;
                bytes.clear();
                for pair in pairs {
                    bytes.extend_from_slice(&(pair - (before << END_BITS)).to_le_bytes());
                }
                part.append_pairs(first + before, &bytes, store)?;
            }
            records.clear();
        }
        part.pairs.shrink_to_fit();
        Ok(part)
    }

    fn append_pairs(&mut self, first: u64, bytes: &[u8], store: &ChunkStore) -> io::Result<()> {
        let chunk = store.append(bytes)?;
        self.pairs.push(PairChunk { first, chunk });
        Ok(())
    }

    /// Returns the number of ends.
    pub(crate) fn ends(&self) -> u32 {
        self.ends
    }

    /// Returns the bytes in memory, except those of chunks that the store keeps there.
    pub(crate) fn byte_size(&self) -> usize {
        size_of::<Self>()
            + self.pairs.capacity() * size_of::<PairChunk>()
            + self.cursor.buffer.capacity()
            + self.found.byte_size()
    }

    /// Finds the ends that are among these points.
    pub(crate) fn resolve(&mut self, points: &Lookup, limits: PartLimits, store: &ChunkStore) -> io::Result<()> {
        let Self {
            is_wide,
            pairs,
            cursor,
            found,
            ..
        } = self;
        if points.first > self.last || pairs.first().is_none_or(|chunk| chunk.first > points.last) {
            return Ok(());
        }
        cursor.seek(points.first, pairs);
        cursor.seen = Some(points.last);
        while let Some(PairChunk { first, chunk }) = pairs.get(cursor.chunk).filter(|c| c.first <= points.last) {
            let is_loaded = cursor.loaded == Some(cursor.chunk);
            let bytes = match chunk {
                Chunk::File(_) if is_loaded => &cursor.buffer,
                chunk => {
                    cursor.loaded = None;
                    let bytes = store.read(chunk, &mut cursor.buffer)?;
                    cursor.loaded = matches!(chunk, Chunk::File(_)).then_some(cursor.chunk);
                    bytes
                }
            };
            let pairs = Pairs::new(bytes, *is_wide);
            let mut is_done = true;
            for at in cursor.pair..pairs.len() {
                let (more, end) = pairs.get(at);
                let record = first + more;
                if record > points.last {
                    cursor.pair = at;
                    is_done = false;
                    break;
                }
                let Some(point) = points.point(record) else { continue };
                found.push(end, point, limits.found, store)?;
            }
            if !is_done {
                break;
            }
            (cursor.chunk, cursor.pair) = (cursor.chunk + 1, 0);
        }
        if !limits.keeps_pairs {
            cursor.rest();
        }
        Ok(())
    }

    /// Frees the memory that only arriving points need.
    pub(crate) fn rest(&mut self) {
        self.cursor.rest();
    }

    /// Writes the position of each end to `positions`, whose contents it replaces. The inner error
    /// is the smallest end that was not found, and its record.
    ///
    /// If `is_last`, frees the chunks.
    pub(crate) fn positions(
        &mut self,
        is_last: bool,
        store: &ChunkStore,
        positions: &mut Vec<Point>,
    ) -> io::Result<Result<(), (u32, u64)>> {
        let mut visited = Vec::new();
        let found = self
            .found
            .positions(self.ends, store, positions, |extent| visited.push(extent))?;
        if let Err(end) = found {
            return Ok(Err((end, self.record_of(end, store)?)));
        }
        if is_last {
            let pairs = std::mem::take(&mut self.pairs).into_iter().map(|pairs| pairs.chunk);
            pairs.for_each(|chunk| store.free(chunk));
            std::mem::take(&mut self.found).free(store);
            visited.into_iter().for_each(|extent| store.free(Chunk::File(extent)));
        }
        Ok(Ok(()))
    }

    /// Returns the record that an end waits for.
    fn record_of(&self, end: u32, store: &ChunkStore) -> io::Result<u64> {
        let mut bytes = Vec::new();
        for PairChunk { first, chunk } in &self.pairs {
            let pairs = Pairs::new(store.read(chunk, &mut bytes)?, self.is_wide);
            let mut its = (0..pairs.len()).map(|at| pairs.get(at));
            if let Some((more, _)) = its.find(|&(_, other)| other == end) {
                return Ok(first + more);
            }
        }
        Err(damaged("an end of a segment waits for nothing"))
    }
}

impl Cursor {
    /// Moves to the first pair with a record of at least `record`, or to an earlier pair for which
    /// no points were seen.
    fn seek(&mut self, record: u64, pairs: &[PairChunk]) {
        let goes_on = self.seen.is_none_or(|seen| seen < record);
        let is_far = pairs.get(self.chunk + 1).is_some_and(|next| next.first < record);
        if !goes_on || is_far {
            let from = pairs.partition_point(|chunk| chunk.first < record).saturating_sub(1);
            (self.chunk, self.pair) = (from, 0);
        }
    }

    fn rest(&mut self) {
        self.loaded = None;
        self.buffer = Vec::new();
    }
}

/// The pairs of a chunk: the record minus the chunk's first record, and the end.
#[derive(Clone, Copy)]
enum Pairs<'a> {
    Narrow(&'a [[u8; NARROW]]),
    Wide(&'a [[u8; WIDE]]),
}

impl<'a> Pairs<'a> {
    fn new(bytes: &'a [u8], is_wide: bool) -> Self {
        if is_wide {
            Self::Wide(bytes.as_chunks().0)
        } else {
            Self::Narrow(bytes.as_chunks().0)
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::Narrow(pairs) => pairs.len(),
            Self::Wide(pairs) => pairs.len(),
        }
    }

    #[inline]
    fn get(&self, at: usize) -> (u64, u32) {
        match self {
            Self::Narrow(pairs) => {
                let word = u64::from_le_bytes(pairs[at]);
                (word >> END_BITS, (word & ((1 << END_BITS) - 1)) as u32)
            }
            Self::Wide(pairs) => {
                let [a, b, c, d, e, f, g, h, end @ ..] = pairs[at];
                (u64::from_le_bytes([a, b, c, d, e, f, g, h]), u32::from_le_bytes(end))
            }
        }
    }
}
