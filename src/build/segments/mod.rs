//! Segments of a build, in any number: from their arrival to the block that needs them, within a share of the memory.
//!
//! In: segments by their ends, or by the record numbers of points that are still to come; then the points. Out: the ends, to
//! be points too; all segments, as often as wanted; the segments of each block.
//!
//! ```text
//! push          ─▶ ends, z, source ─────────────────────────────────┐
//! push_between  ─▶ sources ─────────────────────────────────────────┤ spool     ─▶ ends
//!               ─▶ join: parts, each of so many ends one by one     ├─▶ for_each_chunk
//!                    (record, end), sorted ─┐                       │     distribute ─▶ blocks, by cells
//! points        ─▶ resolve ─────────────────┴─▶ (end, place) ───────┘
//! ```
//!
//! All of it is made of chunks (`chunk_store`), which stay in memory as long as they fit there and go to a file without a name
//! then, with checksums. What distribution has read makes room, in memory and in the file, for what it writes. A build with
//! segments starts again if it is stopped, so nobody has to find that file.

mod blocks;
mod cells;
mod chunk_store;
mod codec;
mod found;
mod join;
mod lookup;
mod part;
mod radix;
mod spool;

use crate::geometry::Point;
use crate::store::EdgeSource;

pub(super) use blocks::BlockSegments;
pub(super) use cells::segments_of_leaves;
pub(super) use spool::SegmentSpool;

/// A line between two places, which will be a chain of edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Segment {
    /// Valid and normalized.
    pub(super) ends: [Point; 2],
    /// What it makes of these edges, seen in the direction from the first end to the second.
    pub(super) source: EdgeSource,
}

impl Segment {
    /// What tells it from others, to sort by.
    pub(super) fn key(&self) -> ([[u64; 2]; 2], EdgeSource) {
        (self.ends.map(|end| [end.x.to_bits(), end.y.to_bits()]), self.source)
    }
}

/// Bytes that a segment takes in the memory of a block.
pub(super) const SEGMENT_BYTES: u64 = size_of::<Segment>() as u64;

/// Segments of a full chunk, which takes about 64 KiB.
const CHUNK_SEGMENTS: usize = (64 << 10) / size_of::<Segment>();
