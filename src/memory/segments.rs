//! The memory of segments on their way: chunks, the join of record numbers with points, and the check of polygons.

/// Who gets how much of the share of segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpoolShares {
    /// Bytes of chunks in memory; the rest goes to the disk.
    pub(crate) chunks: u64,
    /// Bytes of segments that wait to fill a chunk.
    pub(crate) pending: u64,
    pub(crate) join: JoinShares,
}

/// Who gets how much of the share of the join.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JoinShares {
    /// The most ends of a part: as many as half of the share can sort, or put in their places.
    pub(crate) part_ends: u64,
    /// Bytes of a chunk of pairs.
    pub(crate) chunk: usize,
    /// Chunks of pairs that stay in memory.
    pub(crate) kept_chunks: usize,
    /// Bytes of all buffers of what is found.
    pub(crate) found: u64,
}

impl SpoolShares {
    /// The shares of `memory` bytes.
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

/// Who gets how much of the share of the check of polygons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PolygonShares {
    /// Bytes of a polygon that is checked in memory.
    pub(crate) polygon: u64,
    /// Bytes of the spool of a larger one.
    pub(crate) spool: u64,
}

impl PolygonShares {
    /// The shares of `memory` bytes.
    pub(crate) fn new(memory: u64) -> Self {
        Self {
            polygon: memory,
            spool: memory / 8,
        }
    }
}
