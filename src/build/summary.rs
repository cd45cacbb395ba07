//! What a finished build tells of itself.

use std::time::Duration;

use super::options::Phase;

/// What a finished build tells of itself.
#[derive(Clone, Debug, Default)]
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
    /// Tiles of the file.
    pub tiles: u64,
    /// Bytes of the file.
    pub file_bytes: u64,
    /// The phases, in order.
    pub phases: Vec<PhaseSummary>,
    /// The levels of the merge tree: the leaves first, the root last.
    pub levels: Vec<LevelSummary>,
    /// The largest resident size of the process so far, in bytes, where the system tells.
    pub peak_memory: Option<u64>,
}

/// Time and bytes of a phase.
#[derive(Clone, Copy, Debug)]
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
#[derive(Clone, Copy, Debug, Default)]
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
