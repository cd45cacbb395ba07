//! Changes a file on disk: lines become constraints of a triangulation that is there already.
//!
//! In: a tile file, and segments within its hull. Out: the same file in its next state, or as it was.
//!
//! ```text
//!   segments ─▶ new vertices at ends (vertices) ─▶ pieces, in the order of a curve ─▶ strips   (strip, patch)
//!                                                                              │  ▲
//!   file ──── tiles that are needed, the least recently used go ◀──────────────▼──┘   (tiles, tile)
//!     ▲                                                                        │
//!     └── new tiles, directory, superblock ◀── regions, numbered anew ◀────────┘      (regions)
//! ```
//!
//! Inserting a piece changes exactly the triangles that it crosses, and the result does not depend on when it is inserted (Wu,
//! Lemma 3.3.6). So a file that was edited has the triangles that it would have been built with. New tiles and a new directory are
//! appended; then one superblock is replaced, which makes all of it the file, at once. Whoever has it open sees what it was.

mod contradiction;

mod disk;
mod editor;
mod ends;
mod error;
mod exchange;
mod labelling;
mod patch;
mod regions;
mod run;
mod strip;
mod summary;
mod target;
mod tile;
mod tiles;
mod vertices;
mod work;
mod workers;

pub use editor::Editor;
pub use error::EditError;
pub(crate) use run::edit;
pub use summary::EditSummary;
pub(crate) use target::Target;
pub(crate) use work::Work;
