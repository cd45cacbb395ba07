//! Segments that cross: found exactly, reported in order, or split where they do.
//!
//! ```text
//!   segments ──▶ search: grid, in its cells grids ... ──▶ few: all pairs      ──▶ pairs that meet
//!   of a cell            until few are left               many all the same:
//!                        or cells do not part them        sweep
//!
//!   find    pairs that cross, each in the cell that owns its crossing point ──▶ FirstCrossings: ten to be told
//!   split   pairs that cross, and then ends on what crosses ──▶ bent segments ──▶ find ... until nothing crosses
//! ```
//!
//! To cross is to meet in one point within both (`segments_cross`). Ends on other segments and overlaps are no crossings:
//! they become vertices on segments, and pieces with several sources.

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
