//! The segments of each block, from their distribution until the block is processed.

use std::io;
use std::sync::Arc;

use parking_lot::Mutex;

use crate::constraints::segment::{SEGMENT_BYTES, Segment};
use crate::constraints::segments::cells::SegmentCells;
use crate::constraints::segments::chunk_store::{Chunk, ChunkStore, damaged};
use crate::constraints::segments::codec::{SegmentChunk, encode_segments};
use crate::geometry::Rect;
use crate::store::{KdTree, list_for};

/// Largest number of segments of a chunk.
const BLOCK_CHUNK: u64 = 256;

/// The segments of each block: in memory if all fit there, otherwise in a file.
#[derive(Debug)]
pub(crate) struct BlockSegments {
    counts: Vec<u64>,
    /// The blocks, `None` once taken.
    blocks: Mutex<Vec<Option<BlockContent>>>,
    store: Arc<ChunkStore>,
}

/// The segments of a block: first those in chunks.
#[derive(Debug, Default)]
struct BlockContent {
    chunks: Vec<Chunk>,
    rest: Vec<Segment>,
}

impl BlockSegments {
    /// Starts to distribute segments to the leaves of a tree. `segments` is a hint of their number.
    /// Chunks go to `store`.
    pub(crate) fn writer(tree: &KdTree, segments: u64, memory: u64, store: Arc<ChunkStore>) -> BlockWriter<'_> {
        let count = tree.tiles() as usize;
        let mut blocks: Vec<BlockContent> = Vec::new();
        blocks.resize_with(count, BlockContent::default);
        let mut held = 0;
        if let [block] = &mut *blocks
            && segments.saturating_mul(SEGMENT_BYTES) <= memory
        {
            block.rest.reserve_exact(segments as usize);
            held = block.rest.capacity() as u64 * SEGMENT_BYTES;
        }
        // The capacity of a buffer is a power of two of segments, so all of it is used. Small
        // chunks fit where others were freed.
        let share = (memory / SEGMENT_BYTES / count.max(1) as u64).clamp(16, BLOCK_CHUNK);
        BlockWriter {
            cells: SegmentCells::new(tree, Rect::PLANE),
            counts: vec![0; count],
            blocks,
            capacity: 1 << share.ilog2(),
            held,
            memory,
            is_spilling: false,
            store,
            bytes: Vec::new(),
        }
    }

    /// Returns the number of segments of a block. Each takes [`SEGMENT_BYTES`].
    pub(crate) fn count(&self, block: u32) -> u64 {
        self.counts.get(block as usize).copied().unwrap_or(0)
    }

    /// Returns the bytes that all segments take in memory now.
    #[cfg(test)]
    pub(crate) fn byte_size(&self) -> u64 {
        let content = |block: &BlockContent| {
            block.rest.capacity() as u64 * SEGMENT_BYTES + (block.chunks.capacity() * size_of::<Chunk>()) as u64
        };
        self.blocks.lock().iter().flatten().map(content).sum()
    }

    /// Takes the segments of a block, in the order in which they came. Each block can be taken
    /// once, on any thread.
    ///
    /// Returns the system's error, or an error if the segments are damaged or were taken before.
    pub(crate) fn take(&self, block: u32) -> io::Result<Vec<Segment>> {
        let content = self.blocks.lock().get_mut(block as usize).and_then(Option::take);
        let taken = || io::Error::new(io::ErrorKind::NotFound, "the segments of a block were taken before");
        let BlockContent { chunks, rest } = content.ok_or_else(taken)?;
        if chunks.is_empty() {
            return Ok(rest);
        }
        // Allocated on one thread and freed on another: the allocator must not keep such a list for
        // each thread.
        let mut segments = list_for(self.count(block) as usize);
        let mut bytes = Vec::new();
        for chunk in &chunks {
            let chunk = SegmentChunk::decode(self.store.read(chunk, &mut bytes)?);
            segments.extend(chunk.ok_or_else(|| damaged("a chunk is not of segments"))?.segments());
        }
        segments.extend(rest);
        Ok(segments)
    }

    /// Returns the store of the chunks.
    #[cfg(test)]
    pub(crate) fn store(&self) -> &ChunkStore {
        &self.store
    }
}

/// A distributor of segments to blocks.
#[derive(Debug)]
pub(crate) struct BlockWriter<'a> {
    cells: SegmentCells<'a>,
    counts: Vec<u64>,
    blocks: Vec<BlockContent>,
    /// Number of segments of a full chunk.
    capacity: usize,
    /// Bytes in memory, counted until they exceed `memory`.
    held: u64,
    memory: u64,
    is_spilling: bool,
    store: Arc<ChunkStore>,
    bytes: Vec<u8>,
}

impl BlockWriter<'_> {
    /// Adds segments.
    pub(crate) fn push(&mut self, segments: &[Segment]) -> io::Result<()> {
        let Self {
            cells,
            counts,
            blocks,
            capacity,
            held,
            is_spilling,
            store,
            bytes,
            ..
        } = self;
        let mut spilled = Ok(());
        cells.for_each(segments, |leaf, at| {
            counts[leaf as usize] += 1;
            let block = &mut blocks[leaf as usize];
            let before = block.rest.capacity();
            block.rest.push(segments[at]);
            if !*is_spilling {
                *held += (block.rest.capacity() - before) as u64 * SEGMENT_BYTES;
            } else if block.rest.len() >= *capacity && spilled.is_ok() {
                spilled = block.spill(*capacity, store, bytes);
            }
        });
        spilled?;
        if !self.is_spilling && self.held > self.memory {
            self.is_spilling = true;
            self.spill_all()?;
        }
        Ok(())
    }

    fn spill_all(&mut self) -> io::Result<()> {
        for block in &mut self.blocks {
            block.spill(self.capacity, &self.store, &mut self.bytes)?;
            block.rest = Vec::new();
        }
        Ok(())
    }

    /// Finishes the distribution.
    pub(crate) fn finish(mut self) -> io::Result<BlockSegments> {
        if self.is_spilling {
            self.spill_all()?;
        }
        Ok(BlockSegments {
            counts: self.counts,
            blocks: Mutex::new(self.blocks.into_iter().map(Some).collect()),
            store: self.store,
        })
    }
}

impl BlockContent {
    /// Writes the segments in memory, in chunks of `capacity` segments.
    fn spill(&mut self, capacity: usize, store: &ChunkStore, bytes: &mut Vec<u8>) -> io::Result<()> {
        for segments in self.rest.chunks(capacity) {
            encode_segments(segments, &[], bytes);
            self.chunks.push(store.append(bytes)?);
        }
        self.rest.clear();
        Ok(())
    }
}

#[cfg(test)]
mod tests;
