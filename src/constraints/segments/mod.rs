//! The segments of a build, in any number, from their arrival to the block that needs them, within
//! a share of the memory.
//!
//! In: segments by their ends, or by the record numbers of points that come later; then the points.
//! Out: the ends, which become points too; all segments, any number of times; the segments of each
//! block.
//!
//! ```text
//! push          ─▶ ends, z, source ───────────────────────────────┐
//! push_between  ─▶ sources ───────────────────────────────────────┤ spool   ─▶ ends
//!               ─▶ join: parts of consecutive ends                ├─▶ for_each_chunk
//!                    (record, end), sorted ─┐                     │   distribute ─▶ blocks by cell
//! points        ─▶ resolve ─────────────────┴─▶ (end, position) ──┘
//! ```
//!
//! All data is in chunks (`chunk_store`). They stay in memory as long as they fit there. Further
//! chunks go to a file without a name, with checksums. Chunks that distribution has read make room,
//! in memory and in the file, for those that it writes. A build that may be resumed saves all
//! segments at the same time (`saved`), so the file need not be found again.

pub(crate) mod blocks;
pub(crate) mod cells;
pub(crate) mod chunk_store;
mod codec;
pub(crate) mod distribution;
mod found_ends;
mod join;
mod join_part;
mod lookup;
mod radix;
mod saved;
pub(crate) mod spool;
