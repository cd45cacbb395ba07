//! What a finished build tells of itself.

use std::time::{Duration, Instant};

use crate::constraints::polygons::check::Inverted;
use crate::pipeline::options::Phase;

/// What a finished build tells of itself.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct BuildSummary {
    /// Points that came in.
    pub points: u64,
    /// Points that lay on another.
    pub duplicates: u64,
    /// Vertices of the file.
    pub vertices: u64,
    /// Triangles of the file.
    pub triangles: u64,
    /// Of these, triangles that stand in no core.
    pub border_triangles: u64,
    /// Edges with a triangle on one side only.
    pub hull_edges: u64,
    /// Vertices that are no points that came in, but ends of segments or sites.
    pub ends: u64,
    /// Edges that are constraints.
    pub constraint_edges: u64,
    /// Pairs of segments that crossed and were split.
    pub crossings: u64,
    /// Points at which segments were split: where they cross each other, and borders if that was asked for.
    pub split_points: u64,
    /// Sites.
    pub sites: u64,
    /// Regions: parts of the triangulation that no constraint passes through. 0 where there is no constraint.
    pub regions: u64,
    /// Of these, holes.
    pub hole_regions: u64,
    /// The triangles of holes.
    pub hole_triangles: u64,
    /// Parts of obstacles that their rings go round the wrong way. They are covered if crossings are split, else an error.
    pub inverted_regions: u64,
    /// The first of these: the smallest corner of the first obstacle that has any.
    pub first_inverted: Option<Inverted>,
    /// Triangles that were final in their tile, but went up, since a segment crosses them that goes on in other tiles.
    pub held_triangles: u64,
    /// Segments that would have held too many: they were inserted at the end, into the file.
    pub deferred_segments: u64,
    /// Vertices that got z = 0, since they have none and others have
    /// ([`MissingZ::Zero`](crate::input::MissingZ::Zero)).
    pub without_z: u64,
    /// Tiles of the file.
    pub tiles: u64,
    /// Bytes of the file.
    pub file_bytes: u64,
    /// The phases, in order.
    pub phases: Vec<PhaseSummary>,
    /// Blocks that the points were distributed to; 1 if all were in memory.
    pub blocks: u64,
    /// Of these, blocks that a build before this one had finished.
    pub resumed_blocks: u64,
    /// Who waited for whom.
    pub waits: Waits,
    /// The levels of the merge tree: the leaves first, the root last.
    pub levels: Vec<LevelSummary>,
    /// The largest resident size of the process so far, in bytes, where the system tells.
    pub peak_memory: Option<u64>,
}

/// Time and bytes of a phase.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PhaseSummary {
    /// Which.
    pub phase: Phase,
    /// From its start to its end.
    pub time: Duration,
    /// Bytes of work files read in it.
    pub bytes_read: u64,
    /// Bytes of work files and of the tile file written in it.
    pub bytes_written: u64,
}

/// One level of the merge tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct LevelSummary {
    /// Nodes of this level.
    pub nodes: u64,
    /// Points that they triangulated.
    pub vertices: u64,
    /// Triangles that they settled.
    pub settled: u64,
    /// Vertices that they handed up.
    pub seam_vertices: u64,
}

impl LevelSummary {
    /// Adds what others of this level have.
    pub(crate) fn add(&mut self, other: Self) {
        self.nodes += other.nodes;
        self.vertices += other.vertices;
        self.settled += other.settled;
        self.seam_vertices += other.seam_vertices;
    }
}

/// Who waited for whom while blocks were conquered and merged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Waits {
    /// The time that computing threads were idle because no block was in memory, summed over the threads.
    pub computing_for_blocks: Duration,
    /// The time that computing threads waited for tiles to be written, summed over the threads.
    pub computing_for_writing: Duration,
    /// The time that the next block was not read because those before took its memory.
    pub blocks_for_computing: Duration,
}

/// Time and bytes of each phase.
pub(crate) fn phases(
    read_began: Instant,
    began: &[(Phase, Instant)],
    bytes_read: [u64; 5],
    bytes_written: [u64; 5],
) -> Vec<PhaseSummary> {
    let now = Instant::now();
    let start = |phase| match phase {
        Phase::Read => Some(read_began),
        _ => began.iter().find(|(its, _)| *its == phase).map(|its| its.1),
    };
    let bytes = bytes_read.into_iter().zip(bytes_written);
    let phases = Phase::ALL.into_iter().enumerate().zip(bytes);
    let summary = |((place, phase), (bytes_read, bytes_written))| {
        let end = Phase::ALL[place + 1..]
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
