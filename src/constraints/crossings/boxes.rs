//! Bounding boxes and ends of segments, compared without branches.
//!
//! Which comparison fails is as good as random here, and a branch that is mispredicted takes longer than the others.

use crate::geometry::{Point, Rect};

/// The smaller and the larger of two numbers, of which none is NaN: that takes one instruction each.
#[inline]
pub(crate) fn in_order(a: f64, b: f64) -> [f64; 2] {
    [if a < b { a } else { b }, if a > b { a } else { b }]
}

/// The bounding box of a segment.
#[inline]
pub(crate) fn bounds([a, b]: [Point; 2]) -> Rect {
    let ([min_x, max_x], [min_y, max_y]) = (in_order(a.x, b.x), in_order(a.y, b.y));
    Rect::new(min_x, min_y, max_x, max_y)
}

/// Whether two segments have an end in common.
#[inline]
pub(crate) fn share_an_end([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let same = |p: Point, q: Point| (p.x == q.x) & (p.y == q.y);
    same(a, c) | same(a, d) | same(b, c) | same(b, d)
}

/// Whether two bounding boxes meet, without a branch for each side.
#[inline]
pub(crate) fn boxes_meet(a: &Rect, b: &Rect) -> bool {
    (a.min_x <= b.max_x) & (b.min_x <= a.max_x) & (a.min_y <= b.max_y) & (b.min_y <= a.max_y)
}

/// What two rectangles have in common.
pub(crate) fn common(a: Rect, b: Rect) -> Rect {
    Rect::new(
        in_order(a.min_x, b.min_x)[1],
        in_order(a.min_y, b.min_y)[1],
        in_order(a.max_x, b.max_x)[0],
        in_order(a.max_y, b.max_y)[0],
    )
}
