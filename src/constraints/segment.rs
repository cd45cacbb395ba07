//! The record of a segment.

use crate::geometry::Point;
use crate::store::EdgeSource;

/// A line between two places, which will be a chain of edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Segment {
    /// Valid and normalized.
    pub(crate) ends: [Point; 2],
    /// What it makes of these edges, seen in the direction from the first end to the second.
    pub(crate) source: EdgeSource,
}

impl Segment {
    /// What tells it from others, to sort by.
    pub(crate) fn key(&self) -> ([[u64; 2]; 2], EdgeSource) {
        (self.ends.map(|end| [end.x.to_bits(), end.y.to_bits()]), self.source)
    }
}

/// Bytes that a segment takes in the memory of a block.
pub(crate) const SEGMENT_BYTES: u64 = size_of::<Segment>() as u64;

/// Segments of a full chunk, which takes about 64 KiB.
pub(crate) const CHUNK_SEGMENTS: usize = (64 << 10) / size_of::<Segment>();
