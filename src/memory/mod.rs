//! Memory budgets: who gets which share. No other module takes a fraction of a budget.
//!
//! M is the memory that the caller allows. Shares in the same column are in memory at the same
//! time, and their sum is at most M.
//!
//! | of a build (`MemoryPlan`) | while points arrive | while blocks are in work | while deferred lines are inserted |
//! | --- | --- | --- | --- |
//! | segments on their way, their join | at most M/4 | at most M/8, for those that are not in blocks | |
//! | the check of polygons | at most M/4, before points arrive | | |
//! | sites and seeds | at most M/4 | the same | only ids |
//! | the surface that vertices take their z from | M/8, at most 64 MiB, and the tiles in work while it is read back | M/8, at most 64 MiB, for tiles in its cache | |
//! | points in memory | what is left, less tiles in work | none, or all | |
//! | points that do not fit | buffers of runs: an eighth of what is left, at most 64 MiB | blocks: three quarters of what tiles leave | |
//! | tiles in work, one per thread | | `WORK_BYTES` per vertex | |
//! | sources of overlapping edges, per thread | | M/2 divided by the threads | |
//! | waiting seams | | an eighth of what tiles leave; a merge uses the memory of a tile | |
//! | border log | | an eighth of what tiles leave, at most 16 MiB | |
//! | held triangles | | an eighth of M for a node, in the memory of a tile | |
//! | the edit | | | M |
//!
//! | of the segments' share (`SpoolShares`) | |
//! | --- | --- |
//! | chunks of segments in memory | a half; the rest goes to the disk |
//! | the join with record numbers | a half: an eighth of it for results, and half of it for its chunks |
//!
//! | of an edit (`EditShares`) | |
//! | --- | --- |
//! | segments, with their ends | `EDIT_SEGMENT_BYTES` each, at most M/2 |
//! | tiles that ends of lines take their z from, before the edit | M/8 |
//! | tiles that are read, assembled and written | five of the largest tiles per thread |
//! | regions | M/8, and up to M/4 when the ends of segments are freed |
//! | the cache of tiles | the rest, from M/8 to 5 M/8 |
//!
//! | of an open file (`FileShares`) | |
//! | --- | --- |
//! | the reader's own cache, when no pass runs | M/8, at most 64 MiB |
//! | a pass: results in transit | M/16 |
//! | a pass: tiles at once, and what it keeps | the rest |
//! | a pass with lookups: these | three quarters of what the pass leaves |
//!
//! | of overviews (`OverviewShares`) | while vertices are chosen or proven | while a level is built |
//! | --- | --- | --- |
//! | a pass over the tiles of the finer level | M/4 | |
//! | tiles of coarser levels | M/4 | M/4, to read it back |
//! | chosen vertices; the rest goes to the disk | M/8 | M/8 |
//! | the build | | M/2 |
//!
//! | of the check of polygons (`PolygonShares`) | |
//! | --- | --- |
//! | segments of a polygon that is sorted in memory | M |
//! | the spool of a larger one | M/8 |
//!
//! The shares count what the library requests from the allocator. Freed memory that the allocator
//! keeps is not counted. The program `tiletool` configures the allocator to keep little: it uses
//! one arena, and maps large allocations. A caller of the library that must keep to a limit can do
//! the same.

mod edit;
mod file;
mod machine;
mod overviews;
mod plan;
mod segments;
mod shortage;

pub(crate) use edit::EditShares;
pub(crate) use file::FileShares;
pub(crate) use machine::available_memory;
pub use machine::{default_memory, peak_memory};
pub(crate) use overviews::OverviewShares;
pub(crate) use plan::{
    HELD_WORK_BYTES, Load, MemoryPlan, SEAM_BYTES, SEAM_WORK_BYTES, SEGMENT_BYTES, Shares, point_bytes,
};
pub(crate) use segments::{JoinShares, PolygonShares, SpoolShares};
pub use shortage::{MemoryShortage, MemoryUse};
