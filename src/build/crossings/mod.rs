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
mod first;
mod grid;
mod leaves;
mod pairs;
mod search;
mod split;
mod sweep;

use std::ops::ControlFlow;

use super::segments::Segment;
use crate::geometry::{ExactCrossing, Point, Rect, cross_outside, segments_cross};

pub use first::Crossing;
pub(super) use first::{FirstCrossings, KEPT};
pub(super) use leaves::{LeafLines, in_leaves};
pub use split::SplitError;
pub(super) use split::{Points, Segment as Bent, any_cross, split};

/// What has two ends.
pub(super) trait Ends {
    /// Both ends.
    fn ends(&self) -> [Point; 2];
}

impl Ends for [Point; 2] {
    #[inline]
    fn ends(&self) -> [Point; 2] {
        *self
    }
}

impl Ends for Segment {
    #[inline]
    fn ends(&self) -> [Point; 2] {
        self.ends
    }
}

/// Finds the pairs of segments that cross in a cell, each once, in any order.
///
/// `found` gets the places of the two segments and their crossing point, rounded; it may break off the search. A pair
/// belongs to the cell that has its *exact* crossing point: right and top sides are a cell's own, left and bottom ones are
/// not. So each pair is found in exactly one cell of a partition, if each cell is given those segments that meet it, or
/// more. (The rounded point may be on the other side of a cell's side, where the segments are not.)
///
/// Ends are valid points, sides of the cell valid coordinates or infinite; there are at most 2^32 segments. Takes about 12
/// bytes of memory a segment.
pub(super) fn find<S: Ends>(
    segments: &[S],
    cell: Rect,
    found: &mut impl FnMut(u32, u32, Point) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let meet = |one: [Point; 2], other: [Point; 2], rect: Rect| {
        let [[a, b], [c, d]] = [one, other];
        if !segments_cross(a, b, c, d) || cross_outside(one, other, rect) {
            return None;
        }
        ExactCrossing::of(one, other)?.rounded_if_in(cell)
    };
    search::search(segments, cell, &meet, found)
}

#[cfg(test)]
mod tests;
