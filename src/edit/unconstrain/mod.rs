//! Removal of lines: edges that no line holds any more become free.
//!
//! In: lines, by geometry or by number. Out: the file without them; and their ends, which go if
//! nothing else holds them.
//!
//! ```text
//!   lines by geometry ──▶ the edges along each segment (chains, given) ──┐
//!   lines by number ───▶ all edges that have them (numbered) ───────────┴─▶ sources go (remover)
//!                                                                              │
//!                                     edges without sources are flipped (flips) ◀┘
//! ```
//!
//! An edge without a source is free. It may violate the Delaunay property, and it alone: all other
//! edges satisfied it before. So flips spread from there, until the property holds again (Lawson,
//! "Software for C1 surface interpolation", 1977). The result is the constrained Delaunay
//! triangulation of the remaining constraints, which is unique.

mod chains;
mod flips;
mod given;
mod gone;
mod numbered;
mod remover;

use crate::edit::error::EditError;
use crate::edit::tiles::Tiles;

pub(crate) use gone::GoneLines;
use remover::LineRemover;
pub(crate) use remover::Removed;

/// Removes lines.
pub(crate) fn remove(
    tiles: &mut Tiles,
    lines: &GoneLines,
    is_stopped: &dyn Fn() -> bool,
) -> Result<Removed, EditError> {
    if lines.is_empty() {
        return Ok(Removed::default());
    }
    let directory = tiles.directory();
    if directory.has_split_lines() {
        return Err(EditError::SplitLines);
    }
    let polygon_lines = directory.lists.polygon_lines.clone();
    let mut remover = LineRemover::default();
    given::remove(tiles, lines, &polygon_lines, &mut remover, is_stopped)?;
    numbered::remove(tiles, lines, &polygon_lines, &mut remover, is_stopped)?;
    Ok(remover.removed)
}
