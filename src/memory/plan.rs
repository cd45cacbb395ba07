//! The memory of a build.

use std::fmt;

use super::shortage::{MemoryShortage, MemoryUse};

/// Bytes per point in work: kernel, mesh, draft and FlatBuffer of its tile, and tiles on their way
/// to the file.
const WORK_BYTES: u64 = 400;

/// Bytes per point of a tile that is compressed: its plan, what it is made from, and the result.
const COMPRESSION_BYTES: u64 = 200;

/// Bytes per seam vertex while its node is merged: kernel, mesh, fates, and the triangles and the
/// seam that result.
pub(crate) const SEAM_WORK_BYTES: u64 = 310;

/// Bytes per held triangle while its node is merged: it is glued to others, gets constraints, and
/// is on its way to the log.
pub(crate) const HELD_WORK_BYTES: u64 = 280;

/// Bytes per waiting seam vertex, with its share of unsettled triangles.
pub(crate) const SEAM_BYTES: u64 = 56;

/// Bytes per point in a block without z. [`POINT_WITH_Z_BYTES`] is for points with z.
const POINT_BYTES: u64 = 20;
const POINT_WITH_Z_BYTES: u64 = 36;

/// Bytes per segment in a block: the segment, and its numbers in the lists of leaves.
pub(crate) const SEGMENT_BYTES: u64 = 56;

/// Bytes per segment in work: subsegments, marks, sources.
const SEGMENT_WORK_BYTES: u64 = 150;

/// Bytes per source of an edge in work: subsegment, note in the core or in the log, and the
/// encoding of both.
const SOURCE_BYTES: u64 = 80;
/// The number of sources of a node's edges for which any build has memory.
const FEW_SOURCES: u64 = 1 << 20;

/// The most points of a block. Larger blocks would gain nothing, and a resumed build would lose
/// more.
const MAX_BLOCK: u64 = 1 << 22;

/// The most bytes for held triangles. Beyond that, an edit takes less time per segment than nodes
/// that hold its triangles up to the root (measured with 1,000 segments across 1 million points).
const MAX_HELD: u64 = 128 << 20;

/// The shares of a build's memory.
///
/// Methods that take a [`Load`] compute what depends on the input alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MemoryPlan {
    /// The budget in bytes.
    total: u64,
    threads: usize,
    tile_vertices: usize,
    merge_vertices: usize,
    /// Whether tiles are compressed.
    compresses: bool,
    /// Bytes that segments keep while points arrive.
    segments: u64,
    /// Bytes that sites and seeds keep until the end.
    sites: u64,
    /// Bytes for tiles of the surface from which vertices take their z.
    surface: u64,
}

/// The size of a build's input.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Load {
    pub(crate) points: u64,
    pub(crate) segments: u64,
    pub(crate) has_z: bool,
}

/// The shares of a build's memory while blocks are in work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shares {
    /// The number of computing threads.
    pub(crate) threads: usize,
    /// The number of points of a block.
    pub(crate) block_points: u64,
    /// Bytes for all blocks in memory.
    pub(crate) blocks: u64,
    /// The most seam vertices that a merge of more than two nodes takes.
    pub(crate) merge_vertices: usize,
    /// Bytes for the border log's buffers.
    pub(crate) border_log: usize,
}

impl MemoryPlan {
    /// Creates the plan of a build that may take `total` bytes.
    pub(crate) fn new(total: u64, threads: usize, tile_vertices: usize, merge_vertices: usize) -> Self {
        Self {
            total,
            threads,
            tile_vertices,
            merge_vertices,
            compresses: false,
            segments: 0,
            sites: 0,
            surface: 0,
        }
    }

    /// Sets whether tiles are compressed.
    pub(crate) fn with_compression(self, compresses: bool) -> Self {
        Self { compresses, ..self }
    }

    /// Returns the budget in bytes.
    pub(crate) fn total(&self) -> u64 {
        self.total
    }

    /// Returns the bytes for segments on their way.
    pub(crate) fn for_segments(&self) -> u64 {
        self.total / 4
    }

    /// Returns the bytes for the check of polygons.
    pub(crate) fn for_polygons(&self) -> u64 {
        self.total / 4
    }

    /// Returns the plan after segments and sites have arrived. They take `segments` and `sites`
    /// bytes.
    ///
    /// # Errors
    /// Fails if sites, with ponds and seeds, take more than a quarter of the budget.
    pub(crate) fn with_arrivals(self, segments: u64, sites: u64) -> Result<Self, MemoryShortage> {
        if sites > self.total / 4 {
            return Err(MemoryShortage {
                of: MemoryUse::Sites,
                needed: 4 * sites,
                budget: self.total,
            });
        }
        Ok(Self {
            // Later they are sorted, and joined with points.
            segments: (4 * segments).min(self.for_segments()),
            sites,
            ..self
        })
    }

    /// Returns the bytes that segments keep, and sites and seeds.
    pub(crate) fn arrivals(&self) -> [u64; 2] {
        [self.segments, self.sites]
    }

    /// Returns the plan of a resumed build, whose segments and sites kept these
    /// [bytes](Self::arrivals) before.
    ///
    /// # Errors
    /// Fails if sites, with ponds and seeds, take more than a quarter of the budget.
    pub(crate) fn with_arrivals_before(self, [segments, sites]: [u64; 2]) -> Result<Self, MemoryShortage> {
        self.with_arrivals(segments.div_ceil(4), sites)
    }

    /// Returns the plan of a build whose vertices take their z from a surface.
    pub(crate) fn with_surface(self) -> Self {
        /// More would hardly save a read: blocks are adjacent cells, and so are the tiles they meet.
        const MOST: u64 = 64 << 20;
        Self {
            surface: (self.total / 8).min(MOST),
            ..self
        }
    }

    /// Returns the bytes for tiles of the surface from which vertices take their z.
    pub(crate) fn for_surface(&self) -> u64 {
        self.surface
    }

    /// Returns the bytes for reading the surface's `points` points back. No tile is in work
    /// meanwhile, and points that stay in memory leave room for these.
    pub(crate) fn for_reading_back(&self, points: u64) -> u64 {
        let load = Load {
            points,
            segments: 0,
            has_z: true,
        };
        self.surface + self.work_bytes(self.threads, load).min(self.rest() / 2)
    }

    /// Returns the bytes that segments, sites and the surface leave.
    pub(crate) fn rest(&self) -> u64 {
        self.total - self.segments - self.sites - self.surface
    }

    /// Returns the bytes for segments whose block is not in work.
    pub(crate) fn for_waiting_segments(&self) -> u64 {
        (self.segments + self.sites) / 2
    }

    /// Returns the error of work that needs more than segments and sites leave.
    pub(crate) fn shortage(&self, of: MemoryUse, needed: u64) -> MemoryShortage {
        let budget = self.rest();
        MemoryShortage { of, needed, budget }
    }

    /// Returns whether points that take `bytes` can stay in memory, with their segments. If more
    /// arrive, these points are distributed before their memory is released.
    pub(crate) fn fits(&self, load: Load, bytes: u64) -> bool {
        let segments = load.segments.saturating_mul(SEGMENT_BYTES);
        let beside = self.work_bytes(self.threads, load).max(self.distribution_bytes());
        bytes.saturating_add(segments).saturating_add(beside) <= self.rest()
    }

    /// Returns whether points that are still to arrive can stay in memory.
    pub(crate) fn points_fit(&self, load: Load) -> bool {
        self.fits(load, load.points.saturating_mul(point_bytes(load.has_z)))
    }

    /// Returns the most sources of edges in a node, over all its edges: an edge has a source for
    /// each line along it. Each thread has its share of half of the memory.
    pub(crate) fn most_sources(&self) -> usize {
        let share = self.rest() / 2 / self.threads.max(1) as u64;
        (share / SOURCE_BYTES).max(FEW_SOURCES) as usize
    }

    /// Returns the memory of a build that allows `sources` sources of edges in a node.
    pub(crate) fn sources_memory(&self, sources: u64) -> u64 {
        let share = sources.saturating_mul(SOURCE_BYTES);
        share.saturating_mul(2 * self.threads.max(1) as u64)
    }

    /// Returns the most held triangles in a leaf, and in a node above the leaves. A node gets a
    /// quarter of the memory, and a merge may have many leaves below it.
    pub(crate) fn most_held(&self) -> [usize; 2] {
        let all = ((self.rest() / 4).min(MAX_HELD) / HELD_WORK_BYTES) as usize;
        [all / 32, all / 2]
    }

    /// Returns the bytes for the buffers of all runs, while points are distributed.
    pub(crate) fn run_buffers(&self) -> usize {
        (self.rest() / 8).min(64 << 20) as usize
    }

    /// Returns the bytes for distributing points: the buffers of the runs, and the batches that wait
    /// for it.
    fn distribution_bytes(&self) -> u64 {
        self.run_buffers() as u64 + (self.rest() / 16).min(32 << 20)
    }

    /// Returns the number of cells to which points are distributed at once. The limits are the
    /// number of open files and the smallest buffer that is worthwhile.
    pub(crate) fn most_cells(&self) -> usize {
        (self.run_buffers() / (16 << 10)).clamp(16, 512)
    }

    /// Returns the number of cells to which the points of one of several inputs are distributed. Their
    /// files do not stay open.
    pub(crate) fn most_cells_of_input(&self) -> usize {
        (self.run_buffers() / (16 << 10)).clamp(16, 4096)
    }

    /// Returns the shares of a build whose points do not fit in memory. They use only threads for
    /// which there is memory.
    ///
    /// # Errors
    /// Fails if there is not enough memory for one thread.
    pub(crate) fn shares(&self, load: Load) -> Result<Shares, MemoryShortage> {
        /// A block has at most 1/32 of the points, or four tiles if these have more.
        const BLOCKS: u64 = 32;
        let (tile_vertices, points) = (self.tile_vertices as u64, load.points);
        // The minimum is two blocks of a tile each.
        let least = 2 * tile_vertices.min(points) * load.point_bytes() * 4 / 3;
        let threads = (1..=self.threads).rev();
        let mut fitting = threads.filter(|&threads| self.work_bytes(threads, load) + least <= self.rest());
        let Some(threads) = fitting.next() else {
            return Err(self.shortage(MemoryUse::Tile, self.work_bytes(1, load) + least));
        };
        if threads < self.threads {
            tracing::info!(
                threads,
                "using fewer threads: the memory does not suffice for the tiles of more"
            );
        }
        let rest = self.rest() - self.work_bytes(threads, load);
        let blocks = rest / 4 * 3;
        let share = blocks / 2 / load.point_bytes();
        let wanted = (points / BLOCKS).max(4 * tile_vertices);
        let block_points = share.min(MAX_BLOCK).min(wanted).max(1);
        Ok(Shares {
            threads,
            block_points,
            // More than the next block ahead would gain nothing.
            blocks: blocks.min(2 * block_points * load.point_bytes()),
            merge_vertices: self.merge_vertices_in(rest / 8),
            border_log: (rest / 8).min(16 << 20) as usize,
        })
    }

    /// Returns the shares of a build whose points fit in memory. They take `point_bytes` with their
    /// segments.
    pub(crate) fn shares_in_memory(&self, point_bytes: u64) -> Shares {
        let rest = self.rest().saturating_sub(point_bytes);
        Shares {
            threads: self.threads,
            block_points: u64::MAX,
            blocks: point_bytes,
            merge_vertices: self.merge_vertices_in(rest / 8),
            border_log: (rest / 8).min(16 << 20) as usize,
        }
    }

    /// Returns the shares of a resumed build, whose blocks may come from another budget. The
    /// largest block has `largest_block` points. The shares use only threads for which the blocks
    /// leave memory.
    ///
    /// # Errors
    /// Fails if there is not enough memory for one thread.
    pub(crate) fn resumed_shares(&self, load: Load, largest_block: u64) -> Result<Shares, MemoryShortage> {
        let shares = self.shares(load)?;
        let needed = 2 * largest_block * point_bytes(load.has_z);
        let left = |threads| self.rest().checked_sub(self.work_bytes(threads, load) + needed);
        match (1..=shares.threads).rev().find(|&threads| left(threads).is_some()) {
            Some(threads) => Ok(Shares {
                threads,
                blocks: needed.max(shares.blocks),
                ..shares
            }),
            None => Err(self.shortage(MemoryUse::Tile, self.work_bytes(1, load) + needed)),
        }
    }

    /// Returns the bytes for the tiles in work.
    fn work_bytes(&self, threads: usize, load: Load) -> u64 {
        let at_once = load.points.min((self.tile_vertices * threads) as u64);
        let compression = if self.compresses { COMPRESSION_BYTES } else { 0 };
        at_once * (WORK_BYTES + compression + load.per_point(SEGMENT_WORK_BYTES))
    }

    /// Returns the most seam vertices of a merge, if the few seams that wait at each level may take
    /// `bytes`. A merge may be as large as a tile.
    fn merge_vertices_in(&self, bytes: u64) -> usize {
        let fit = ((bytes / 3 / SEAM_BYTES) as usize).max(self.tile_vertices);
        fit.min(self.merge_vertices)
    }
}

impl fmt::Display for MemoryPlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mib = |bytes: u64| bytes >> 20;
        write!(
            f,
            "{} MiB in total, including {} for segments, {} for sites, {} for runs and {} for held triangles; {} sources of edges",
            mib(self.total),
            mib(self.segments),
            mib(self.sites),
            mib(self.run_buffers() as u64),
            mib(self.most_held()[1] as u64 * HELD_WORK_BYTES),
            self.most_sources()
        )
    }
}

impl fmt::Display for Shares {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} threads, blocks {} MiB, border log {} MiB, merges of {} seam vertices",
            self.threads,
            self.blocks >> 20,
            self.border_log >> 20,
            self.merge_vertices
        )
    }
}

impl Load {
    /// Returns the bytes of segments per point, if a segment takes `bytes`. Segments may be
    /// distributed less evenly than points, but every segment has ends.
    fn per_point(self, bytes: u64) -> u64 {
        let all = self.segments.saturating_mul(bytes);
        all.div_ceil(self.points.max(1)).min(3 * bytes)
    }

    /// Returns the bytes per point in a block, with its share of segments.
    fn point_bytes(self) -> u64 {
        point_bytes(self.has_z) + self.per_point(SEGMENT_BYTES)
    }
}

/// Returns the bytes per point in a block, without segments.
pub(crate) fn point_bytes(has_z: bool) -> u64 {
    if has_z { POINT_WITH_Z_BYTES } else { POINT_BYTES }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of unknown number stay in memory as long as they fit, and must be distributed then.
    #[test]
    fn points_that_outgrow_the_memory_leave_room_for_their_distribution() {
        for memory in [16, 64, 256, 512, 4096].map(|mebibytes| mebibytes << 20) {
            let plan = MemoryPlan::new(memory, 2, 32_768, 1 << 20);
            let bytes = |points: u64| points * point_bytes(false);
            let fits = |points: u64| {
                let load = Load {
                    points,
                    segments: 0,
                    has_z: false,
                };
                plan.fits(load, bytes(points))
            };
            let least = (0..).map(|exponent| 1 << exponent).find(|&points| !fits(points));
            let mut range = 0..least.unwrap();
            while range.end - range.start > 1 {
                let middle = range.start.midpoint(range.end);
                if fits(middle) {
                    range.start = middle;
                } else {
                    range.end = middle;
                }
            }
            let most = range.start;
            assert!(bytes(most) + plan.run_buffers() as u64 <= memory, "{most} points");
            assert!(bytes(most) > memory / 2 || memory <= 64 << 20, "{most} points");
        }
    }
}
