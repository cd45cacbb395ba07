//! Sizes of tiles: before an edit, tiles that would become too large are cut; after it, small ones
//! that are siblings in the k-d tree are merged.
//!
//! ```text
//!   ┌───────┐      ┌───┬───┐        A tile has 1.5 times the vertices that the build aimed at,
//!   │   7   │  →   │ 7 │ 9 │        or fewer. The new tile has the next number. The vertices of
//!   └───────┘      └───┴───┘        both get new ids, which the tiles around have to learn.
//! ```
//!
//! Vertices get new ids only before the first and after the last change, when no step has any.

mod coming;
mod cut;
mod merge;

pub(crate) use cut::cut_tiles;
pub(crate) use merge::merge_tiles;
