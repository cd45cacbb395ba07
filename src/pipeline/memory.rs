//! How much memory there is, and who gets how much of it.
//!
//! M is what the caller allows. Shares of one column are in memory at the same time; their sum is at most M.
//!
//! | of a build | while points come | while blocks are in work | while lines that were put off are inserted |
//! | --- | --- | --- | --- |
//! | segments on their way, their join ([`crate::constraints::segments`]) | M/4 at most | M/8 at most, what is not in blocks | |
//! | sites and seeds | M/4 at most | the same | ids alone |
//! | points in memory | what is left, less tiles in work | none, or all | |
//! | points that do not fit | buffers of runs: an eighth of what is left, 64 MiB at most | blocks: three quarters of what tiles leave | |
//! | tiles in work, one for each thread | | `WORK_BYTES` a vertex | |
//! | seams that wait | | an eighth of what tiles leave; a merge takes the place of a tile | |
//! | border log | | an eighth of what tiles leave, 16 MiB at most | |
//! | triangles that are held | | an eighth of M for a node, in the place of a tile ([`crate::pipeline::conquer::constrain`]) | |
//! | the edit | | | M ([`edit_shares`]) |
//!
//! | of an edit | |
//! | --- | --- |
//! | segments, with their ends | `EDIT_SEGMENT_BYTES` each, M/2 at most |
//! | tiles that are read, put together and written | five of the largest for each thread |
//! | regions | M/8, and up to M/4 when the ends of segments are gone |
//! | the cache of tiles | the rest, from M/8 to 5 M/8 |
//!
//! A pass over a file keeps a sixteenth for what is on its way (`store/pass.rs`).
//!
//! The shares count what is asked of the allocator. What that keeps of what was given back comes on top: the program `tiletool` sets it
//! so that this is little. A caller of the library who must keep to a limit does so too: one arena, and large allocations mapped.

use std::fs;

use rustix::process::{Resource, getrlimit};

use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::spill::plan::Plan;
use crate::pipeline::options::BuildOptions;
use crate::pipeline::work_folder::WorkFolder;

/// Bytes of a point in work: kernel, mesh, draft and FlatBuffer of its tile, and tiles on their way to the file.
const WORK_BYTES: u64 = 400;

/// Bytes of a seam vertex while its node is merged: kernel, mesh, fates, and the triangles and the seam that come out.
pub(crate) const SEAM_WORK_BYTES: u64 = 250;

/// Bytes of a held triangle while its node is merged: glued to others, with constraints, and on its way to the log.
pub(crate) const HELD_WORK_BYTES: u64 = 250;

/// Bytes of a seam vertex that waits, with its share of unsettled triangles.
pub(crate) const SEAM_BYTES: u64 = 48;

/// Bytes of a point in a block, and more where it has z.
const POINT_BYTES: u64 = 20;
const POINT_WITH_Z_BYTES: u64 = 36;

/// Bytes of a segment in a block: itself, and its numbers among those of leaves.
pub(crate) const SEGMENT_BYTES: u64 = 56;

/// Bytes of a segment in work: pieces, marks, sources.
const SEGMENT_WORK_BYTES: u64 = 150;

/// Bytes of an edge's source in work: piece, note in the core or in the log, and their encoding.
const SOURCE_BYTES: u64 = 80;
/// Sources of a node's edges that any build has memory for.
const FEW_SOURCES: u64 = 1 << 20;

/// The most points of a block: more would gain nothing, and a build that goes on would lose more.
const MAX_BLOCK: u64 = 1 << 22;

/// Who gets how much of a build's memory while blocks are in work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shares {
    /// Threads that compute.
    pub(crate) threads: usize,
    /// Points of a block.
    pub(crate) block_points: u64,
    /// Bytes of all blocks in memory.
    pub(crate) blocks: u64,
    /// The most seam vertices that a merge of more than two nodes takes in.
    pub(crate) merge_vertices: usize,
    /// Bytes of the border log's buffers.
    pub(crate) border_log: usize,
}

/// How much there is to build from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Load {
    pub(crate) points: u64,
    pub(crate) segments: u64,
    pub(crate) has_z: bool,
}

impl Load {
    /// What a plan has, and so many segments.
    pub(crate) fn of(plan: &Plan, segments: u64) -> Self {
        Self {
            points: plan.points,
            segments,
            has_z: plan.has_z,
        }
    }

    /// Bytes that segments take for each point, of so many for each segment. Segments need not lie as evenly as points do, but
    /// none is without ends.
    fn per_point(self, bytes: u64) -> u64 {
        let all = self.segments.saturating_mul(bytes);
        all.div_ceil(self.points.max(1)).min(3 * bytes)
    }

    /// Bytes of a point in a block, with its share of segments.
    fn point_bytes(self) -> u64 {
        point_bytes(self.has_z) + self.per_point(SEGMENT_BYTES)
    }
}

/// Bytes of the tiles that are in work.
fn work_bytes(options: &BuildOptions, threads: usize, load: Load) -> u64 {
    let at_once = load.points.min((options.tile_vertices * threads) as u64);
    at_once * (WORK_BYTES + load.per_point(SEGMENT_WORK_BYTES))
}

/// Whether points that take so many bytes can stay in memory, with their segments.
pub(crate) fn fits(options: &BuildOptions, load: Load, bytes: u64) -> bool {
    let segments = load.segments.saturating_mul(SEGMENT_BYTES);
    let work = work_bytes(options, options.threads, load);
    bytes.saturating_add(segments).saturating_add(work) <= options.memory
}

/// Whether points that are still to come can stay in memory.
pub(crate) fn points_fit(options: &BuildOptions, load: Load) -> bool {
    fits(options, load, load.points.saturating_mul(point_bytes(load.has_z)))
}

/// How often lines may run along edges of a node, all in all: each edge knows all of them. Each thread has its share of half of the
/// memory.
pub(crate) fn most_sources(options: &BuildOptions) -> usize {
    let share = options.memory / 2 / options.threads.max(1) as u64;
    (share / SOURCE_BYTES).max(FEW_SOURCES) as usize
}

/// The memory of a build for which that many are not too many.
pub(crate) fn sources_memory(options: &BuildOptions, sources: u64) -> u64 {
    let share = sources.saturating_mul(SOURCE_BYTES);
    share.saturating_mul(2 * options.threads.max(1) as u64)
}

/// Bytes of a point in a block, without segments.
pub(crate) fn point_bytes(has_z: bool) -> u64 {
    if has_z { POINT_WITH_Z_BYTES } else { POINT_BYTES }
}

/// Bytes of the buffers of all runs, while points are distributed.
pub(crate) fn run_buffers(memory: u64) -> usize {
    (memory / 8).min(64 << 20) as usize
}

/// Cells that points are distributed to at once: no more than files that may be open, nor than buffers are worth it.
pub(crate) fn most_cells(memory: u64) -> usize {
    (run_buffers(memory) / (16 << 10)).clamp(16, 512)
}

/// The shares of a build of so many points, which do not fit in memory. Threads that there is no memory for are not used.
pub(crate) fn shares(options: &BuildOptions, load: Load) -> Result<Shares, BuildError> {
    /// A block is no more than one of so many.
    const BLOCKS: u64 = 32;
    let (tile_vertices, points) = (options.tile_vertices as u64, load.points);
    // Two blocks of a tile each are the least.
    let least = 2 * tile_vertices.min(points) * load.point_bytes() * 4 / 3;
    let threads = (1..=options.threads).rev();
    let mut fitting = threads.filter(|&threads| work_bytes(options, threads, load) + least <= options.memory);
    let Some(threads) = fitting.next() else {
        return Err(BuildError::Memory {
            needed: work_bytes(options, 1, load) + least,
            budget: options.memory,
        });
    };
    if threads < options.threads {
        tracing::warn!(threads, "there is memory for the tiles of so many threads only");
    }
    let rest = options.memory - work_bytes(options, threads, load);
    let blocks = rest / 4 * 3;
    let share = blocks / 2 / load.point_bytes();
    let wanted = (points / BLOCKS).max(4 * tile_vertices);
    let block_points = share.min(MAX_BLOCK).min(wanted).max(1);
    Ok(Shares {
        threads,
        block_points,
        // More than the next one ahead would gain nothing.
        blocks: blocks.min(2 * block_points * load.point_bytes()),
        merge_vertices: merge_vertices(options, rest / 8),
        border_log: (rest / 8).min(16 << 20) as usize,
    })
}

/// The shares of a build whose points fit in memory.
pub(crate) fn shares_in_memory(options: &BuildOptions, point_bytes: u64) -> Shares {
    let rest = options.memory.saturating_sub(point_bytes);
    Shares {
        threads: options.threads,
        block_points: u64::MAX,
        blocks: point_bytes,
        merge_vertices: merge_vertices(options, rest / 8),
        border_log: (rest / 8).min(16 << 20) as usize,
    }
}

/// Seam vertices of a merge, of which a few wait at each level, in so many bytes. A merge may be as large as a tile.
fn merge_vertices(options: &BuildOptions, bytes: u64) -> usize {
    ((bytes / 3 / SEAM_BYTES) as usize).max(options.tile_vertices)
}

/// The shares of a build that goes on with a plan, which may be another budget's: with as many threads as its blocks leave
/// memory for.
pub(crate) fn resumed_shares(options: &BuildOptions, plan: &Plan) -> Result<Shares, BuildError> {
    let load = Load::of(plan, 0);
    let shares = shares(options, load)?;
    let largest = plan.blocks.iter().map(|block| block.points).max().unwrap_or(0);
    let needed = 2 * largest * point_bytes(plan.has_z);
    let left = |threads| options.memory.checked_sub(work_bytes(options, threads, load) + needed);
    match (1..=shares.threads).rev().find(|&threads| left(threads).is_some()) {
        Some(threads) => Ok(Shares {
            threads,
            blocks: needed.max(shares.blocks),
            ..shares
        }),
        None => Err(BuildError::Memory {
            needed: work_bytes(options, 1, load) + needed,
            budget: options.memory,
        }),
    }
}

/// Who gets how much of an edit's memory, beside its segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EditShares {
    /// Threads that put tiles together.
    pub(crate) threads: usize,
    /// Bytes of the tiles in the cache.
    pub(crate) tiles: u64,
}

/// Bytes of a segment that is inserted: itself, its ends while they are looked for, and the vertices that these are.
const EDIT_SEGMENT_BYTES: u64 = 184;

/// The memory of an edit for which so many segments are not too many.
pub(crate) fn least_edit(segments: u64) -> u64 {
    2 * EDIT_SEGMENT_BYTES * segments
}

/// The shares of an edit that inserts so many segments. The largest tile has so many bytes in the file.
pub(crate) fn edit_shares(memory: u64, segments: u64, threads: usize, largest_tile: u64) -> EditShares {
    /// Bytes of memory for each thread, at least.
    const OF_THREAD: u64 = 256 << 20;
    /// A thread has a tile as it was read, or its drafts and what they are encoded in; beside it another tile is read or written.
    const TILES_IN_WORK: u64 = 5;
    let threads = threads.min((memory / OF_THREAD) as usize).max(1);
    let in_work = threads as u64 * TILES_IN_WORK * largest_tile;
    let regions = memory / 8;
    let others = segments * EDIT_SEGMENT_BYTES + in_work + regions;
    EditShares {
        threads,
        // Tiles in use are in memory in any case.
        tiles: memory.saturating_sub(others).clamp(memory / 8, memory / 8 * 5),
    }
}

/// What a build has still to write.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DiskLoad {
    pub(crate) points: u64,
    pub(crate) has_z: bool,
    pub(crate) segments: u64,
    /// Bytes of segments that go to the disk, while all of them are there.
    pub(crate) segment_bytes: u64,
    /// Bytes of points and segments that stand there already, and go away meanwhile.
    pub(crate) spilled_bytes: u64,
}

impl DiskLoad {
    /// Bytes of the file, and of what is spilled.
    ///
    /// Points at one place take less; nobody knows how many there are.
    fn bytes(self) -> [u64; 2] {
        /// Bytes of a vertex in the file, as measured without z.
        const VERTEX_BYTES: u64 = 53;
        /// Bytes of the border log for each point, where points lie evenly.
        const BORDER_BYTES: u64 = 5;
        /// Bytes of an edge's source in the file, and of a segment in the border log: a fifth of the edges are there.
        const SOURCE_BYTES: u64 = 8;
        let of_points = self
            .points
            .saturating_mul(VERTEX_BYTES + if self.has_z { 8 } else { 0 });
        let of_segments = self.segments.saturating_mul(SOURCE_BYTES);
        let log = self.points.saturating_mul(BORDER_BYTES).saturating_add(of_segments);
        let spilled = log.saturating_add(self.segment_bytes);
        [of_points.saturating_add(of_segments), spilled]
    }
}

/// Fails if there is not enough room on the disk for what a build has still to write.
pub(crate) fn check_disk(folder: &WorkFolder, load: DiskLoad) -> Result<(), BuildError> {
    let [output, spilled] = load.bytes();
    let there = load.spilled_bytes;
    let needs = if folder.spill() == folder.path() {
        vec![(folder.path(), output.saturating_add(spilled).saturating_sub(there))]
    } else {
        vec![(folder.path(), output), (folder.spill(), spilled.saturating_sub(there))]
    };
    for (path, needed) in needs {
        // Where the system does not tell, nothing is lost.
        let Ok(room) = rustix::fs::statvfs(path) else { continue };
        let free = room.f_bavail.saturating_mul(room.f_frsize);
        if needed > free {
            return Err(BuildError::Disk {
                path: path.to_owned(),
                needed,
                free,
            });
        }
    }
    Ok(())
}

/// A quarter of the smallest of the machine's memory, the limit of the process's cgroup, and its own limits (`RLIMIT_AS`,
/// `RLIMIT_DATA`); 1 GiB where neither is known.
#[must_use]
pub fn default_memory() -> u64 {
    let limit = |resource| getrlimit(resource).current;
    let limits = [
        installed_memory(),
        cgroup_limit(),
        limit(Resource::As),
        limit(Resource::Data),
    ];
    limits.into_iter().flatten().min().map_or(1 << 30, |bytes| bytes / 4)
}

fn installed_memory() -> Option<u64> {
    kibibytes("/proc/meminfo", "MemTotal:")
}

/// The limit of the cgroup of this process or of any above it (version 2, or version 1's memory controller).
fn cgroup_limit() -> Option<u64> {
    let groups = fs::read_to_string("/proc/self/cgroup").ok()?;
    let limits = groups.lines().filter_map(|line| {
        let mut fields = line.splitn(3, ':').skip(1);
        let (controllers, path) = (fields.next()?, fields.next()?);
        let (root, file) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max"),
            c if c.split(',').any(|c| c == "memory") => ("/sys/fs/cgroup/memory", "memory.limit_in_bytes"),
            _ => return None,
        };
        let group = std::path::Path::new(path.trim_start_matches('/'));
        group
            .ancestors()
            .filter_map(|group| fs::read_to_string(format!("{root}/{}/{file}", group.display())).ok())
            .filter_map(|limit| limit.trim().parse::<u64>().ok())
            .min()
    });
    limits.min()
}

/// The largest resident size of this process so far, in bytes.
#[must_use]
pub fn peak_memory() -> Option<u64> {
    kibibytes("/proc/self/status", "VmHWM:")
}

fn kibibytes(file: &str, key: &str) -> Option<u64> {
    let text = fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    let number: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(number * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_disk_has_room_for_segments_too() {
        let points = DiskLoad {
            points: 1000,
            ..DiskLoad::default()
        };
        assert_eq!(points.bytes(), [53_000, 5000]);
        let with_segments = DiskLoad {
            segments: 500,
            segment_bytes: 500 * 60,
            has_z: true,
            ..points
        };
        assert_eq!(with_segments.bytes(), [61_000 + 4000, 5000 + 4000 + 30_000]);
        let absurd = DiskLoad {
            points: u64::MAX,
            segments: u64::MAX,
            segment_bytes: u64::MAX,
            ..points
        };
        assert_eq!(absurd.bytes(), [u64::MAX; 2]);
    }
}
