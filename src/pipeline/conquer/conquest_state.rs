//! The results of tasks so far, and the limits of conquest.

use std::time::{Duration, Instant};

use crate::constraints::crossings::first::FirstCrossings;
use crate::geometry::Point;
use crate::pipeline::conquer::constrain::refusal::Crossed;
use crate::pipeline::conquer::growth::SeamGrowth;
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::missing_z::FoundWithoutZ;
use crate::pipeline::records::{BlockState, Deferred, Nexts};
use crate::pipeline::summary::LevelSummary;

/// The limits of conquest, and the known size of its input.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConquestLimits {
    /// Number of all points.
    pub(crate) points: u64,
    /// Bytes that blocks may take, as long as there are any.
    pub(crate) block_bytes: u64,
    /// Whether finished blocks go to the journal.
    pub(crate) has_journal: bool,
}

/// The results of tasks so far.
#[derive(Default)]
pub(crate) struct ConquestState {
    /// The blocks that were divided, in order.
    pub(crate) blocks: Vec<BlockState>,
    /// Levels of nodes above the blocks.
    pub(crate) levels: Vec<LevelSummary>,
    /// The error that ended the work.
    pub(crate) failed: Option<BuildError>,
    /// If duplicates are an error: the first duplicate record, preceded by the smallest record
    /// number at its position, and that position.
    pub(crate) first_duplicate: Option<([u64; 2], Point)>,
    pub(crate) growth: SeamGrowth,
    /// Number of points of the leaves that are done.
    pub(crate) points_done: u64,
    /// Segments that cross.
    pub(crate) crossings: FirstCrossings,
    /// Vertices without z when others have z, if these are an error.
    pub(crate) without_z: FoundWithoutZ,
    /// Whether vertices without z are an error.
    pub(crate) lacks_z: bool,
    /// Two segments that cross, met by an insertion.
    pub(crate) crossed: Option<Crossed>,
    /// For collinear input: for a tile, the vertex of another tile to which an edge of it leads.
    pub(crate) next_on_line: Nexts,
    /// What the root and all nodes below it deferred, once the root is done.
    pub(crate) deferred: Deferred,
    /// When the first block was divided.
    pub(crate) conquer_began: Option<Instant>,
    /// Time that threads waited for tiles to be written, summed over the threads.
    pub(crate) waited_to_write: Duration,
}

impl ConquestState {
    /// Returns whether the input was found invalid, so that the remaining blocks are only examined
    /// for errors.
    pub(crate) fn has_refused(&self) -> bool {
        self.first_duplicate.is_some() || self.crossed.is_some() || self.crossings.count() > 0 || self.lacks_z
    }
}
