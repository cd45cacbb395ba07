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

pub(crate) mod blocks;
pub(crate) mod cells;
pub(crate) mod chunk_store;
mod codec;
mod found_ends;
mod join;
mod join_part;
mod lookup;
mod radix;
pub(crate) mod spool;
