//! From points to a tile file: divide, conquer, merge, borders.
//!
//! ```text
//! push ─┬─▶ point_store ──────────────────────────┐ all points in memory: one block
//!       └─▶ spill ──▶ runs ──▶ plan ──▶ prefetch ─┤ or many on disk, read one ahead of those in work
//! push_lines ─▶ segments ─────────────────────────┤ those that meet a block go with it
//!                                                 ▼
//!              conquest: divide ──▶ leaf ──▶ merge ──▶ border_log ──▶ border ──▶ output ──▶ OUT
//!                        k-d tree   cores    late      spilled        the rest   writes,
//!                        and cells  seams    triangles by groups      of tiles   journal
//!                                    └─ node ─┘
//!                                    constrain and components, where there are segments; regions before borders
//! ```
//!
//! [`Builder`] takes batches; `assembly` makes the file of them and starts `pipeline` on computing threads, which share a board of tasks (`schedule`). What
//! they finish comes in the order of the file (`ordered`) through a channel to the task that writes (`output`).

mod assembly;
mod border;
mod border_log;
mod border_mesh;
mod borders;
mod bucket_sort;
mod budget;
mod builder;
mod codec;
mod components;
mod conquest;
mod constrain;
mod crossings;
mod divide;
mod edit;
mod error;
mod growth;
mod intake;
mod journal;
mod leaf;
mod merge;
mod missing_z;
mod node;
mod options;
mod ordered;
mod output;
mod pipeline;
mod point_store;
mod polygons;
mod prefetch;
mod regions;
mod schedule;
mod seeds;
mod segments;
mod sites;
mod spill;
mod split_lines;
mod summary;
mod union;
mod vertex_index;
mod work_folder;

use std::ops::Range;

use crate::geometry::Rect;
use crate::store::{KdTree, LineSource, Source};

pub use crate::input::MissingZ;
pub use budget::{default_memory, peak_memory};
pub use builder::Builder;
pub use crossings::{Crossing, SplitError};
pub use edit::{EditError, EditSummary, Editor};
pub use error::BuildError;
pub use missing_z::{VertexWithoutZ, WithoutZ};
pub use options::{BuildOptions, Crossings, Duplicates, Phase, Progress, Steiner, UnknownDuplicates};
pub use polygons::{Inverted, InvertedPolygons, PolygonCheck, PolygonFaults};
pub use split_lines::{LinesToSplit, SplitLines};
pub use summary::{BuildSummary, LevelSummary, PhaseSummary, Waits};

/// The generation that a new file starts with.
const GENERATION: u32 = 1;

/// What the caller knows of the points: metadata, and a note that a build that is resumed gives back.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Description {
    /// The files that the points come from.
    pub sources: Vec<Source>,
    /// The files that lines come from, in the order of their numbers.
    pub lines: Vec<LineSource>,
    /// The coordinate reference system.
    pub crs: Option<String>,
    /// Anything that whoever resumes the build wants to know; it does not go to the file.
    pub memo: String,
}

/// What is known of a block that was divided, more with each leaf and merge; of a finished one it goes to the journal.
#[derive(Clone, Debug, Default, PartialEq)]
struct BlockFound {
    first_tile: u32,
    tree: KdTree,
    tiles: Vec<TileState>,
    duplicates: u64,
    ends: u64,
    late_triangles: u64,
    held_triangles: u64,
    levels: Vec<LevelSummary>,
}

impl BlockFound {
    fn tile_range(&self) -> Range<u32> {
        self.first_tile..self.first_tile + self.tiles.len() as u32
    }
}

/// What is known of a tile, but for its extents.
#[derive(Clone, Debug, PartialEq)]
struct TileState {
    vertices: u32,
    core_triangles: u32,
    border_triangles: u32,
    owned_triangles: u32,
    bounds: Rect,
    constraint_edges: u64,
    /// The components of its core, and those of them that are open; none where there are no regions to be told apart.
    components: u32,
    open_components: u32,
}

impl Default for TileState {
    fn default() -> Self {
        Self {
            vertices: 0,
            core_triangles: 0,
            border_triangles: 0,
            owned_triangles: 0,
            constraint_edges: 0,
            components: 0,
            open_components: 0,
            bounds: Rect::EMPTY,
        }
    }
}
