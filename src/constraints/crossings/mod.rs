//! Segments that cross: found exactly, and then reported in order or split.
//!
//! ```text
//!   segments ──▶ search: a grid, grids within its    ──▶ few: all pairs      ──▶ pairs that meet
//!   of a cell            cells, ... until few are left   many that cells do
//!                        or cells do not separate them   not separate: sweep
//!
//!   find    pairs that cross, each in the cell that owns its crossing point ──▶ FirstCrossings
//!   split   pairs that cross, then ends on cut segments ──▶ bent segments ──▶ find, ...
//! ```
//!
//! Two segments cross if they meet in one point that is interior to both (`segments_cross`). Ends
//! on other segments and overlaps are not crossings: they become vertices on segments, and
//! subsegments with several sources.

mod boxes;
mod cells;
pub(crate) mod ends;
pub(crate) mod find;
pub(crate) mod first;
mod grid;
mod pairs;
mod search;
mod segment_view;
pub(crate) mod split;
mod sweep;

#[cfg(test)]
mod tests;
