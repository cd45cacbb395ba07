//! Takes changes of a file on disk, and makes them.
//!
//! In: a tile file, and changes of its points, lines and sites. Out: the same file in its next state,
//! or unchanged.
//!
//! ```text
//!   editor ──▶ transaction ──▶ ways ──┬──▶ the tiles that they touch are changed (edit)
//!      │         intake          ▲    └──▶ all tiles are built anew (rebuild) ──▶ and edited, if need be
//!      ▼         drape, pieces   │ checkpoint
//!   locked ──▶ pending ──▶ log of the file
//!                logged, look_up, position_filters
//! ```
//!
//! Both ways lead to the same triangles. Building is faster if much is changed, and it needs no
//! triangles to begin with.

mod drape;
#[allow(clippy::module_inception)]
mod editor;
mod intake;
mod locked;
mod logged;
mod look_up;
mod options;
mod pending;
mod pieces;
mod position_filters;
mod rebuild;
mod transaction;
mod ways;

pub use editor::Editor;
pub use options::{Durability, EditOptions};
pub use transaction::Transaction;
