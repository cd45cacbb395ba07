//! What tasks have found so far, and what they must keep to.

use std::time::{Duration, Instant};

use crate::constraints::crossings::first::FirstCrossings;
use crate::geometry::Point;
use crate::pipeline::conquer::constrain::refusal::Crossed;
use crate::pipeline::conquer::growth::SeamGrowth;
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::missing_z::FoundWithoutZ;
use crate::pipeline::records::{BlockFound, Nexts};
use crate::pipeline::summary::LevelSummary;

/// What conquest must keep to, and what it knows of its input.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConquestLimits {
    /// All points.
    pub(crate) points: u64,
    /// Bytes that blocks may take, as long as there are any.
    pub(crate) block_bytes: u64,
    /// Whether finished blocks go to the journal.
    pub(crate) has_journal: bool,
}

/// What tasks have found so far.
#[derive(Default)]
pub(crate) struct Found {
    /// The blocks that were divided, in order.
    pub(crate) blocks: Vec<BlockFound>,
    /// Levels of nodes above the blocks.
    pub(crate) levels: Vec<LevelSummary>,
    /// Why there is no going on.
    pub(crate) failed: Option<BuildError>,
    /// Where they are an error: the first record on an earlier one, after that, and their place.
    pub(crate) first_duplicate: Option<([u64; 2], Point)>,
    pub(crate) growth: SeamGrowth,
    /// Points of the leaves that are done.
    pub(crate) points_done: u64,
    /// Segments that cross.
    pub(crate) crossings: FirstCrossings,
    /// Vertices that have no z where others have: an error, or those that got 0.
    pub(crate) without_z: FoundWithoutZ,
    /// Whether it is an error.
    pub(crate) lacks_z: bool,
    /// Two of them that one insertion met.
    pub(crate) crossed: Option<Crossed>,
    /// Without triangles: of tiles, the vertex of another one that an edge leads to.
    pub(crate) next_on_line: Nexts,
    /// Tiles, and components of theirs that seeds lie in.
    pub(crate) seeded: Vec<(u32, u32)>,
    /// When the first block was divided.
    pub(crate) conquer_began: Option<Instant>,
    /// The time that threads waited for the writing of tiles.
    pub(crate) waited_to_write: Duration,
}

impl Found {
    /// Whether there is no file to come, and blocks are looked at only for what is wrong with the input.
    pub(crate) fn has_refused(&self) -> bool {
        self.first_duplicate.is_some() || self.crossed.is_some() || self.crossings.count() > 0 || self.lacks_z
    }
}
