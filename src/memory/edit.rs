//! The memory of an edit.

use super::shortage::{MemoryShortage, MemoryUse};

/// Bytes per inserted segment: the segment, its ends during the search for them, and the vertices
/// that these become.
const EDIT_SEGMENT_BYTES: u64 = 200;

/// Bytes per end of a line that is removed by its number: its position, also in the order of tiles.
const REMOVED_END_BYTES: u64 = 56;

/// The shares of an edit's memory, without its segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EditShares {
    /// The number of threads that assemble tiles.
    pub(crate) threads: usize,
    /// Bytes for the tiles in the cache.
    pub(crate) tiles: u64,
    /// Bytes for what the search for regions needs to know of changed tiles.
    pub(crate) surveys: u64,
}

impl EditShares {
    /// Bytes per change of a point: the call, its place in the order of tiles, and the position of a
    /// point that goes.
    pub(crate) const POINT_BYTES: u64 = 80;
    /// The same with moves: also all positions, and what lies there before and after.
    pub(crate) const MOVED_POINT_BYTES: u64 = 240;

    /// Bytes per change of a site, without the text of its id: the call, its place in the order of
    /// tiles, the vertex that it becomes, and the position of a site that goes.
    pub(crate) const SITE_BYTES: u64 = 160;

    /// Computes the shares of an edit whose changes of points and sites take `points` bytes, and which
    /// inserts or removes `segments` segments. The largest tile has `largest_tile` bytes in the file.
    pub(crate) fn new(memory: u64, [points, segments]: [u64; 2], threads: usize, largest_tile: u64) -> Self {
        /// The minimum number of bytes per thread.
        const OF_THREAD: u64 = 256 << 20;
        /// The number of tiles in memory per thread: the tile as it was read, or its drafts and
        /// their encoding, while another tile is read or written.
        const TILES_IN_WORK: u64 = 5;
        let threads = threads.min((memory / OF_THREAD) as usize).max(1);
        let in_work = threads as u64 * TILES_IN_WORK * largest_tile;
        let (regions, surveys) = (memory / 8, memory / 16);
        let input = points + segments * EDIT_SEGMENT_BYTES;
        let others = input + in_work + regions + surveys;
        Self {
            threads,
            // Tiles in use are in memory in any case.
            tiles: memory.saturating_sub(others).clamp(memory / 8, memory / 16 * 9),
            surveys,
        }
    }

    /// Returns the bytes for tiles while ends of lines take their z from the file, before the edit.
    pub(crate) fn for_draping(memory: u64) -> u64 {
        memory / 8
    }

    /// Checks that changes of points and sites, which take `points` bytes, and `segments` segments take
    /// at most half of the memory.
    ///
    /// # Errors
    /// Fails with the memory that they need, if they take more.
    pub(crate) fn check_input(memory: u64, points: u64, segments: u64) -> Result<(), MemoryShortage> {
        check(memory, 2 * (points + EDIT_SEGMENT_BYTES * segments))
    }

    /// Checks that `ends` ends of removed lines take at most half of the memory.
    ///
    /// # Errors
    /// Fails with the memory that they need, if they take more.
    pub(crate) fn check_removed(memory: u64, ends: usize) -> Result<(), MemoryShortage> {
        check(memory, 2 * REMOVED_END_BYTES * ends as u64)
    }

    /// Checks that regions, which take `bytes` now, take at most a quarter of the memory.
    ///
    /// # Errors
    /// Fails with the memory that they need, if they take more.
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
