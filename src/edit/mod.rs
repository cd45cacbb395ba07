//! Edits of a file on disk: lines become constraints of an existing triangulation.
//!
//! In: a tile file, and segments within its hull. Out: the same file in its next state, or
//! unchanged.
//!
//! ```text
//!   segments ─▶ vertices at ends (vertices) ──▶ segments in curve order ─▶ strips (strip, patch)
//!                                                                        │  ▲
//!   file ──── tiles in use, in a cache that evicts the least recent ◀────▼──┘ (tiles, tile)
//!     ▲                                                                  │
//!     └── new tiles, directory, superblock ◀── regions, renumbered ◀─────┘ (regions)
//! ```
//!
//! Inserting a segment changes exactly the triangles that it crosses, and the result does not
//! depend on the order of insertion (Wu, Lemma 3.3.6). So an edited file has the triangles that a
//! build with these lines would give. New tiles and a new directory are appended. Then one
//! superblock is replaced, which puts all of it in force at once. A reader that has the file open
//! sees its former state.

mod chain;
mod contradiction;
mod disk;
mod drape;
mod editor;
mod ends;
mod error;
mod exchange;
mod hull;
mod labelling;
mod new_links;
mod patch;
mod points;
mod region_numbers;
mod regions;
mod run;
mod shared_triangles;
mod strip;
mod summary;
mod target;
mod tile;
mod tiles;
mod vertex;
mod vertices;
mod work;
mod workers;

pub use editor::Editor;
pub use error::EditError;
pub(crate) use points::PointCalls;
pub(crate) use run::edit;
pub use summary::{EditSummary, PointCounts};
pub(crate) use target::Target;
pub(crate) use work::Work;
