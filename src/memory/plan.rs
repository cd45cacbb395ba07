//! The memory of a build.

use std::fmt;

use super::shortage::{MemoryShortage, MemoryUse};

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

/// Bytes that held triangles take at most: beyond that an edit takes less time for a segment than nodes that hold its
/// triangles up to the root (tried with 1,000 segments across 1 million points).
const MAX_HELD: u64 = 128 << 20;

/// Who gets how much of a build's memory.
///
/// What depends on the input alone is told by methods that take a [`Load`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MemoryPlan {
    /// Bytes in all.
    total: u64,
    threads: usize,
    tile_vertices: usize,
    merge_vertices: usize,
    /// Bytes that segments keep while points come.
    segments: u64,
    /// Bytes that sites and seeds keep to the end.
    sites: u64,
}

/// How much there is to build from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Load {
    pub(crate) points: u64,
    pub(crate) segments: u64,
    pub(crate) has_z: bool,
}

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

impl MemoryPlan {
    /// The plan of a build that may take `total` bytes.
    pub(crate) fn new(total: u64, threads: usize, tile_vertices: usize, merge_vertices: usize) -> Self {
        Self {
            total,
            threads,
            tile_vertices,
            merge_vertices,
            segments: 0,
            sites: 0,
        }
    }

    /// All bytes.
    pub(crate) fn total(&self) -> u64 {
        self.total
    }

    /// Bytes for segments on their way.
    pub(crate) fn for_segments(&self) -> u64 {
        self.total / 4
    }

    /// Bytes for the check of polygons.
    pub(crate) fn for_polygons(&self) -> u64 {
        self.total / 4
    }

    /// The plan when segments and sites have come that take so many bytes.
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

    /// Bytes that segments and sites leave.
    pub(crate) fn rest(&self) -> u64 {
        self.total - self.segments - self.sites
    }

    /// Bytes that segments may take that no block is in work for.
    pub(crate) fn for_waiting_segments(&self) -> u64 {
        (self.segments + self.sites) / 2
    }

    /// A shortage of what segments and sites leave.
    pub(crate) fn shortage(&self, of: MemoryUse, needed: u64) -> MemoryShortage {
        let budget = self.rest();
        MemoryShortage { of, needed, budget }
    }

    /// Whether points that take `bytes` can stay in memory, with their segments.
    pub(crate) fn fits(&self, load: Load, bytes: u64) -> bool {
        let segments = load.segments.saturating_mul(SEGMENT_BYTES);
        let work = self.work_bytes(self.threads, load);
        bytes.saturating_add(segments).saturating_add(work) <= self.rest()
    }

    /// Whether points that are still to come can stay in memory.
    pub(crate) fn points_fit(&self, load: Load) -> bool {
        self.fits(load, load.points.saturating_mul(point_bytes(load.has_z)))
    }

    /// How often lines may run along edges of a node, all in all: each edge knows all of them. Each thread has its share of
    /// half of the memory.
    pub(crate) fn most_sources(&self) -> usize {
        let share = self.rest() / 2 / self.threads.max(1) as u64;
        (share / SOURCE_BYTES).max(FEW_SOURCES) as usize
    }

    /// The memory of a build for which that many are not too many.
    pub(crate) fn sources_memory(&self, sources: u64) -> u64 {
        let share = sources.saturating_mul(SOURCE_BYTES);
        share.saturating_mul(2 * self.threads.max(1) as u64)
    }

    /// Triangles that may be held in a leaf, and in a node above. A quarter of the memory is for a node, and a merge may have
    /// many leaves below.
    pub(crate) fn most_held(&self) -> [usize; 2] {
        let all = ((self.rest() / 4).min(MAX_HELD) / HELD_WORK_BYTES) as usize;
        [all / 32, all / 2]
    }

    /// Bytes of the buffers of all runs, while points are distributed.
    pub(crate) fn run_buffers(&self) -> usize {
        (self.rest() / 8).min(64 << 20) as usize
    }

    /// Cells that points are distributed to at once: no more than files that may be open, nor than buffers are worth it.
    pub(crate) fn most_cells(&self) -> usize {
        (self.run_buffers() / (16 << 10)).clamp(16, 512)
    }

    /// The shares of a build whose points do not fit in memory. Threads that there is no memory for are not used.
    pub(crate) fn shares(&self, load: Load) -> Result<Shares, MemoryShortage> {
        /// A block is no more than one of so many.
        const BLOCKS: u64 = 32;
        let (tile_vertices, points) = (self.tile_vertices as u64, load.points);
        // Two blocks of a tile each are the least.
        let least = 2 * tile_vertices.min(points) * load.point_bytes() * 4 / 3;
        let threads = (1..=self.threads).rev();
        let mut fitting = threads.filter(|&threads| self.work_bytes(threads, load) + least <= self.rest());
        let Some(threads) = fitting.next() else {
            return Err(self.shortage(MemoryUse::Tile, self.work_bytes(1, load) + least));
        };
        if threads < self.threads {
            tracing::warn!(threads, "there is memory for the tiles of so many threads only");
        }
        let rest = self.rest() - self.work_bytes(threads, load);
        let blocks = rest / 4 * 3;
        let share = blocks / 2 / load.point_bytes();
        let wanted = (points / BLOCKS).max(4 * tile_vertices);
        let block_points = share.min(MAX_BLOCK).min(wanted).max(1);
        Ok(Shares {
            threads,
            block_points,
            // More than the next one ahead would gain nothing.
            blocks: blocks.min(2 * block_points * load.point_bytes()),
            merge_vertices: self.merge_vertices_in(rest / 8),
            border_log: (rest / 8).min(16 << 20) as usize,
        })
    }

    /// The shares of a build whose points fit in memory, where they take `point_bytes` with their segments.
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

    /// The shares of a build that goes on with blocks which another budget may have made, the largest of `largest_block`
    /// points: with as many threads as these leave memory for.
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

    /// Bytes of the tiles that are in work.
    fn work_bytes(&self, threads: usize, load: Load) -> u64 {
        let at_once = load.points.min((self.tile_vertices * threads) as u64);
        at_once * (WORK_BYTES + load.per_point(SEGMENT_WORK_BYTES))
    }

    /// Seam vertices of a merge, of which a few wait at each level, in so many bytes. A merge may be as large as a tile.
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
            "{} MiB in all: segments {} and sites {} of it, runs {}, held triangles {}, {} sources of edges",
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
    /// Bytes that segments take for each point, of `bytes` for each segment. Segments need not lie as evenly as points do, but
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

/// Bytes of a point in a block, without segments.
pub(crate) fn point_bytes(has_z: bool) -> u64 {
    if has_z { POINT_WITH_Z_BYTES } else { POINT_BYTES }
}
