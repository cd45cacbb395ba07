//! Who gets how much memory, of which budget. Nobody else takes a fraction of anything.
//!
//! M is what the caller allows. Shares of one column are in memory at the same time; their sum is at most M.
//!
//! | of a build (`MemoryPlan`) | while points come | while blocks are in work | while lines that were put off are inserted |
//! | --- | --- | --- | --- |
//! | segments on their way, their join | M/4 at most | M/8 at most, what is not in blocks | |
//! | the check of polygons | M/4 at most, before points come | | |
//! | sites and seeds | M/4 at most | the same | ids alone |
//! | points in memory | what is left, less tiles in work | none, or all | |
//! | points that do not fit | buffers of runs: an eighth of what is left, 64 MiB at most | blocks: three quarters of what tiles leave | |
//! | tiles in work, one for each thread | | `WORK_BYTES` a vertex | |
//! | sources of edges along each other, for each thread | | M/2 divided by the threads | |
//! | seams that wait | | an eighth of what tiles leave; a merge takes the place of a tile | |
//! | border log | | an eighth of what tiles leave, 16 MiB at most | |
//! | triangles that are held | | an eighth of M for a node, in the place of a tile | |
//! | the edit | | | M |
//!
//! | of the segments' share (`SpoolShares`) | |
//! | --- | --- |
//! | chunks of segments in memory | a half; the rest goes to the disk |
//! | the join with record numbers | a half, of which an eighth is for what is found, and a half for its chunks |
//!
//! | of an edit (`EditShares`) | |
//! | --- | --- |
//! | segments, with their ends | `EDIT_SEGMENT_BYTES` each, M/2 at most |
//! | tiles that are read, put together and written | five of the largest for each thread |
//! | regions | M/8, and up to M/4 when the ends of segments are gone |
//! | the cache of tiles | the rest, from M/8 to 5 M/8 |
//!
//! | of an open file (`FileShares`) | |
//! | --- | --- |
//! | the reader's own cache, when no pass runs | M/8, 64 MiB at most |
//! | a pass: what was computed and is on its way | M/16 |
//! | a pass: tiles at once, and what it keeps | the rest |
//! | a pass that looks things up: these | three quarters of what the pass leaves |
//!
//! | of the check of polygons (`PolygonShares`) | |
//! | --- | --- |
//! | segments of a polygon that is sorted in memory | M |
//! | the spool of a larger one | M/8 |
//!
//! The shares count what is asked of the allocator. What that keeps of what was given back comes on top: the program `tiletool` sets it
//! so that this is little. A caller of the library who must keep to a limit does so too: one arena, and large allocations mapped.

mod edit;
mod file;
mod machine;
mod plan;
mod segments;
mod shortage;

pub(crate) use edit::EditShares;
pub(crate) use file::FileShares;
pub use machine::{default_memory, peak_memory};
pub(crate) use plan::{
    HELD_WORK_BYTES, Load, MemoryPlan, SEAM_BYTES, SEAM_WORK_BYTES, SEGMENT_BYTES, Shares, point_bytes,
};
pub(crate) use segments::{JoinShares, PolygonShares, SpoolShares};
pub use shortage::{MemoryShortage, MemoryUse};
