//! Search for pairs of segments that cross.

use std::ops::ControlFlow;

use crate::constraints::crossings::ends::Ends;
use crate::constraints::crossings::search;
use crate::geometry::{ExactCrossing, Point, Rect, cross_outside, segments_cross};

/// Finds the pairs of segments that cross in `cell`, each once, in any order.
///
/// `found` receives the indices of the two segments and their crossing point, rounded. It may stop
/// the search. A pair belongs to the cell that contains its *exact* crossing point. A cell owns its
/// right and top sides, but not its left and bottom sides. So each pair is found in exactly one
/// cell of a partition if each cell is given at least the segments that meet it. (The rounded point
/// may be on the other side of a cell's side, where the segments are not.)
///
/// Ends must be valid points, and the sides of `cell` valid coordinates or infinite. There may be
/// at most 2^32 segments. The search takes about 12 bytes of memory per segment.
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
