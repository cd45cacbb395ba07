//! Finds the pairs of segments that cross.

use std::ops::ControlFlow;

use crate::constraints::crossings::ends::Ends;
use crate::constraints::crossings::search;
use crate::geometry::{ExactCrossing, Point, Rect, cross_outside, segments_cross};

/// Finds the pairs of segments that cross in a cell, each once, in any order.
///
/// `found` gets the places of the two segments and their crossing point, rounded; it may break off the search. A pair
/// belongs to the cell that has its *exact* crossing point: right and top sides are a cell's own, left and bottom ones are
/// not. So each pair is found in exactly one cell of a partition, if each cell is given those segments that meet it, or
/// more. (The rounded point may be on the other side of a cell's side, where the segments are not.)
///
/// Ends are valid points, sides of the cell valid coordinates or infinite; there are at most 2^32 segments. Takes about 12
/// bytes of memory a segment.
pub(crate) fn find<S: Ends>(
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
