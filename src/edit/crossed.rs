//! The tiles whose cells a line crosses.
//!
//! A tile whose cell no constraint crosses is connected within its cell, even if its triangles are
//! not connected within the tile. So its component table stays valid as long as no line crosses the
//! cell.

use crate::geometry::{Orientation, Point, Rect, orient2d};
use crate::store::{KdNode, KdTree, TileId};

/// Calls `found` with the tiles whose cells a segment touches. `bounds` contains the cells' vertices
/// and the segment.
pub(crate) fn crossed_tiles(tree: &KdTree, bounds: Rect, ends: [Point; 2], mut found: impl FnMut(TileId)) {
    let mut left = Vec::new();
    if tree.tiles() > 0 {
        left.push((0, bounds));
    }
    let around = Rect::around(ends);
    while let Some((node, cell)) = left.pop() {
        let (right, low, high) = match tree.nodes()[node as usize] {
            KdNode::X { cut, right } => (right, Rect { max_x: cut, ..cell }, Rect { min_x: cut, ..cell }),
            KdNode::Y { cut, right } => (right, Rect { max_y: cut, ..cell }, Rect { min_y: cut, ..cell }),
            KdNode::Leaf(tile) => {
                found(tile);
                continue;
            }
        };
        for (node, cell) in [(node + 1, low), (right, high)] {
            if touches(cell, ends, around) {
                left.push((node, cell));
            }
        }
    }
}

/// Returns whether a segment touches a rectangle. `around` is the bounding box of the segment.
fn touches(cell: Rect, [a, b]: [Point; 2], around: Rect) -> bool {
    let is_apart = around.max_x < cell.min_x
        || around.min_x > cell.max_x
        || around.max_y < cell.min_y
        || around.min_y > cell.max_y;
    if is_apart {
        return false;
    }
    let corners = [
        Point::new(cell.min_x, cell.min_y),
        Point::new(cell.max_x, cell.min_y),
        Point::new(cell.max_x, cell.max_y),
        Point::new(cell.min_x, cell.max_y),
    ];
    let sides = corners.map(|corner| orient2d(a, b, corner));
    let is_beside = |side: Orientation| sides.iter().all(|&other| other == side);
    !is_beside(Orientation::Clockwise) && !is_beside(Orientation::CounterClockwise)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_segment_touches_the_cells_that_have_a_point_of_it() {
        let cell = Rect::new(0.0, 0.0, 2.0, 1.0);
        let p = Point::new;
        let cases = [
            ([p(0.5, 0.5), p(0.6, 0.5)], true),
            ([p(-1.0, 0.5), p(3.0, 0.5)], true),
            ([p(-1.0, 1.0), p(3.0, 1.0)], true),
            ([p(-1.0, 1.5), p(0.5, 0.5)], true),
            ([p(2.0, 1.0), p(3.0, 2.0)], true),
            ([p(1.0, 2.0), p(3.0, 0.0)], true),
            ([p(-1.0, 0.5), p(0.5, 2.0)], false),
            ([p(1.5, 2.0), p(3.0, 0.5)], false),
            ([p(-1.0, -1.0), p(3.0, -0.5)], false),
            ([p(1.0, 1.0), p(1.0, 1.0)], true),
            ([p(3.0, 3.0), p(3.0, 3.0)], false),
        ];
        for (ends, expected) in cases {
            let [a, b] = ends;
            for ends in [[a, b], [b, a]] {
                assert_eq!(touches(cell, ends, Rect::around(ends)), expected, "{ends:?}");
            }
        }
    }
}
