//! The memory of an edit.

use super::shortage::{MemoryShortage, MemoryUse};

/// Bytes of a segment that is inserted: itself, its ends while they are looked for, and the vertices that these are.
const EDIT_SEGMENT_BYTES: u64 = 184;

/// Who gets how much of an edit's memory, beside its segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EditShares {
    /// Threads that put tiles together.
    pub(crate) threads: usize,
    /// Bytes of the tiles in the cache.
    pub(crate) tiles: u64,
}

impl EditShares {
    /// The shares of an edit that inserts `segments`. The largest tile has `largest_tile` bytes in the file.
    pub(crate) fn new(memory: u64, segments: u64, threads: usize, largest_tile: u64) -> Self {
        /// Bytes of memory for each thread, at least.
        const OF_THREAD: u64 = 256 << 20;
        /// A thread has a tile as it was read, or its drafts and what they are encoded in; beside it another tile is read or
        /// written.
        const TILES_IN_WORK: u64 = 5;
        let threads = threads.min((memory / OF_THREAD) as usize).max(1);
        let in_work = threads as u64 * TILES_IN_WORK * largest_tile;
        let regions = memory / 8;
        let others = segments * EDIT_SEGMENT_BYTES + in_work + regions;
        Self {
            threads,
            // Tiles in use are in memory in any case.
            tiles: memory.saturating_sub(others).clamp(memory / 8, memory / 8 * 5),
        }
    }

    /// Fails if `segments` take more than half of the memory.
    pub(crate) fn check_segments(memory: u64, segments: u64) -> Result<(), MemoryShortage> {
        check(memory, 2 * EDIT_SEGMENT_BYTES * segments)
    }

    /// Fails if regions, which have `bytes` by now, take more than a quarter of the memory.
    pub(crate) fn check_regions(memory: u64, bytes: u64) -> Result<(), MemoryShortage> {
        check(memory, 4 * bytes)
    }
}

fn check(budget: u64, needed: u64) -> Result<(), MemoryShortage> {
    if needed <= budget {
        return Ok(());
    }
    Err(MemoryShortage {
        of: MemoryUse::Edit,
        needed,
        budget,
    })
}
