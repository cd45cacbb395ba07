//! Summary of a finished build.

use std::time::{Duration, Instant};

use crate::constraints::polygons::check::Inverted;
use crate::pipeline::options::Phase;

/// Summary of a finished build.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct BuildSummary {
    /// Number of points that arrived.
    pub points: u64,
    /// Number of points at the position of another one, which were merged with it.
    pub duplicates: u64,
    /// Number of vertices of the file.
    pub vertices: u64,
    /// Number of triangles of the file.
    pub triangles: u64,
    /// Number of triangles that are in no core.
    pub border_triangles: u64,
    /// Number of edges with a triangle on one side only.
    pub hull_edges: u64,
    /// Number of vertices that are no input points, but ends of segments, split points or sites.
    pub added_vertices: u64,
    /// Number of edges that are constraints.
    pub constraint_edges: u64,
    /// Number of pairs of segments that crossed and were split.
    pub crossings: u64,
    /// Number of points at which segments were split: where they cross each other, and borders if
    /// that was asked for.
    pub split_points: u64,
    /// Number of sites.
    pub sites: u64,
    /// Number of sites in holes, which no path can reach. Sites on the boundaries of holes are not
    /// among them.
    pub sites_in_holes: u64,
    /// Number of regions: parts of the triangulation that no constraint passes through. 0 if there
    /// are no constraints.
    pub regions: u64,
    /// Number of regions that are holes.
    pub hole_regions: u64,
    /// Number of triangles in holes.
    pub hole_triangles: u64,
    /// Number of parts of obstacles whose rings have the wrong orientation. Such parts are covered
    /// if crossings are split; otherwise they are an error.
    pub inverted_parts: u64,
    /// The first of these parts: the smallest corner of the first obstacle that has any.
    pub first_inverted: Option<Inverted>,
    /// Number of triangles that were final in their tile but passed up, because a segment that
    /// extends to other tiles crosses them.
    pub held_triangles: u64,
    /// Number of deferred segments: they would have held too many triangles, so they were inserted
    /// into the file at the end.
    pub deferred_segments: u64,
    /// Number of vertices that got z = 0 because they have none and others have
    /// ([`MissingZ::Zero`](crate::input::MissingZ::Zero)).
    pub without_z: u64,
    /// Number of vertices that took their z from the triangulation of the points, because they have
    /// none and points have ([`MissingZ::Drape`](crate::input::MissingZ::Drape)).
    pub draped: u64,
    /// Number of these vertices outside the hull of the points. They have the z of the nearest point
    /// of the hull.
    pub draped_outside: u64,
    /// Number of ponds.
    pub ponds: u64,
    /// Number of points in ponds, on their shores too. They have the z of their pond.
    pub flattened: u64,
    /// Number of tiles of the file.
    pub tiles: u64,
    /// Bytes of the file.
    pub file_bytes: u64,
    /// The phases, in order.
    pub phases: Vec<PhaseSummary>,
    /// Number of blocks that the points were distributed to; 1 if all were in memory.
    pub blocks: u64,
    /// Number of blocks that an earlier build had finished.
    pub resumed_blocks: u64,
    /// Waiting times.
    pub waits: Waits,
    /// The levels of the merge tree: the leaves first, the root last.
    pub levels: Vec<LevelSummary>,
    /// The largest resident size of the process so far, in bytes, or `None` if the system does not
    /// report it.
    pub peak_memory: Option<u64>,
}

/// Time and bytes of a phase.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PhaseSummary {
    /// The phase.
    pub phase: Phase,
    /// Time from the start of the phase to its end.
    pub time: Duration,
    /// Bytes of work files read in the phase.
    pub bytes_read: u64,
    /// Bytes of work files and of the tile file written in the phase.
    pub bytes_written: u64,
}

/// One level of the merge tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct LevelSummary {
    /// Number of nodes of the level.
    pub nodes: u64,
    /// Number of points that the nodes triangulated.
    pub vertices: u64,
    /// Number of triangles that the nodes settled.
    pub settled: u64,
    /// Number of vertices that the nodes passed up.
    pub seam_vertices: u64,
}

impl LevelSummary {
    /// Adds the counts of other nodes of this level.
    pub(crate) fn add(&mut self, other: Self) {
        self.nodes += other.nodes;
        self.vertices += other.vertices;
        self.settled += other.settled;
        self.seam_vertices += other.seam_vertices;
    }
}

/// Waiting times while blocks were conquered and merged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Waits {
    /// Time that computing threads were idle because no block was in memory, summed over the
    /// threads.
    pub computing_for_blocks: Duration,
    /// Time that computing threads waited for tiles to be written, summed over the threads.
    pub computing_for_writing: Duration,
    /// Time that the next block was not read because earlier blocks occupied the memory.
    pub blocks_for_computing: Duration,
}

/// Returns time and bytes of each phase.
pub(crate) fn phases(
    read_began: Instant,
    began: &[(Phase, Instant)],
    bytes_read: [u64; 5],
    bytes_written: [u64; 5],
) -> Vec<PhaseSummary> {
    let now = Instant::now();
    let start = |phase| match phase {
        Phase::Read => Some(read_began),
        _ => began.iter().find(|(other, _)| *other == phase).map(|found| found.1),
    };
    let bytes = bytes_read.into_iter().zip(bytes_written);
    let phases = Phase::ALL.into_iter().enumerate().zip(bytes);
    let summary = |((index, phase), (bytes_read, bytes_written))| {
        let end = Phase::ALL[index + 1..]
            .iter()
            .find_map(|&next| start(next))
            .unwrap_or(now);
        PhaseSummary {
            phase,
            time: start(phase).map_or(Duration::ZERO, |start| end - start),
            bytes_read,
            bytes_written,
        }
    };
    phases.map(summary).collect()
}
