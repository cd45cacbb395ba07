//! The record of a segment.

use crate::geometry::Point;
use crate::store::LinePart;

/// A line segment between two points, which will become a chain of edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Segment {
    /// The ends, valid and normalized.
    pub(crate) ends: [Point; 2],
    /// The source of these edges, seen in the direction from the first end to the second, and which
    /// of these ends are ends of a segment of the input. Those at which lines were split are not.
    pub(crate) source: LinePart,
}

impl Segment {
    /// Returns a sort key that distinguishes it from other segments.
    pub(crate) fn key(&self) -> ([[u64; 2]; 2], LinePart) {
        (self.ends.map(|end| [end.x.to_bits(), end.y.to_bits()]), self.source)
    }
}

/// Bytes of a segment in the memory of a block.
pub(crate) const SEGMENT_BYTES: u64 = size_of::<Segment>() as u64;

/// Number of segments of a full chunk, which takes about 64 KiB.
pub(crate) const CHUNK_SEGMENTS: usize = (64 << 10) / size_of::<Segment>();
