//! The memory of segments on their way: chunks, the join of record numbers with points, and the
//! check of polygons.

/// The shares of the segments' memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpoolShares {
    /// Bytes for chunks in memory. Other chunks go to the disk.
    pub(crate) chunks: u64,
    /// Bytes for segments that wait to fill a chunk.
    pub(crate) pending: u64,
    pub(crate) join: JoinShares,
}

/// The shares of the join's memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JoinShares {
    /// The most ends of a part: half of the share suffices to sort them, or to put them in their
    /// slots.
    pub(crate) part_ends: u64,
    /// Bytes per chunk of pairs.
    pub(crate) chunk: usize,
    /// The number of chunks of pairs that stay in memory.
    pub(crate) kept_chunks: usize,
    /// Bytes for all buffers of results.
    pub(crate) found: u64,
}

impl SpoolShares {
    /// Divides `memory` bytes.
    pub(crate) fn new(memory: u64) -> Self {
        let join = memory / 2;
        let chunk = (join / 512).clamp(1 << 10, 16 << 10) as usize;
        Self {
            chunks: memory / 2,
            pending: memory / 64,
            join: JoinShares {
                part_ends: join / 32,
                chunk,
                kept_chunks: join as usize / 2 / chunk,
                found: join / 8,
            },
        }
    }
}

/// The shares of the memory for the check of polygons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PolygonShares {
    /// Bytes for a polygon that is checked in memory.
    pub(crate) polygon: u64,
    /// Bytes for the spool of a larger polygon.
    pub(crate) spool: u64,
}

impl PolygonShares {
    /// Divides `memory` bytes.
    pub(crate) fn new(memory: u64) -> Self {
        Self {
            polygon: memory,
            spool: memory / 8,
        }
    }
}
