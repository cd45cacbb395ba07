//! Edits of a file on disk: points and lines come and go.
//!
//! In: a tile file, and changes of its points and lines. Out: the same file in its next state, or
//! unchanged.
//!
//! ```text
//!   points that come ─▶ lines that go ─▶ lines that come ──────▶ vertices that go     (run)
//!   (points, vertices)  (unconstrain)    (ends, vertices, strip)  (points)
//!           │                 │                   │                    │
//!           ▼                 ▼                   ▼                    ▼
//!   file ──── tiles in use, in a cache that evicts the least recent      (tiles, tile, exchange)
//!     ▲                                                       │
//!     └── new tiles, directory, superblock ◀── regions, renumbered ◀──┘  (labelling, regions)
//! ```
//!
//! The constrained Delaunay triangulation is a function of the points and the lines, so an edited
//! file has the triangles that a build of the changed ones would give. Inserting a segment changes
//! exactly the triangles that it crosses (Wu, Lemma 3.3.6). New tiles and a new directory are
//! appended. Then one superblock is replaced, which puts all of it in force at once. A reader that
//! has the file open sees its former state.

mod chain;
mod contradiction;
mod disk;
mod ends;
mod error;
mod exchange;
mod held;
mod hull;
mod labelling;
mod leaving;
mod marks;
mod new_links;
mod next_directory;
mod patch;
mod point_parts;
mod points;
mod region_numbers;
mod regions;
mod run;
mod shared_triangles;
mod sites;
mod sizes;
mod strip;
mod summary;
mod survey;
mod target;
mod tile;
mod tile_vertices;
mod tiles;
mod touch;
mod unconstrain;
mod vertex;
mod vertex_z;
mod vertices;
mod work;
mod workers;

pub use error::EditError;
pub(crate) use next_directory::{EditTotals, enter};
pub(crate) use points::{
    Attributes, CallInTile, MAX_CALL_BYTES, Missing, PointCall, PointCalls, Positions, decode_call, encode_call,
};
pub(crate) use run::edit;
pub(crate) use sites::{SiteCall, SiteCalls};
pub use summary::{EditSummary, LineCounts, PointCounts, SiteCounts};
pub(crate) use target::Target;
pub(crate) use unconstrain::GoneLines;
pub(crate) use work::{Piece, Work};
