//! Bounding boxes and shared ends of segments, compared without branches.
//!
//! Branch-free: which comparison fails is unpredictable here, and a mispredicted branch costs more
//! than the remaining comparisons.

use crate::geometry::{Point, Rect};

/// Returns the smaller and the larger of two numbers, neither of which is NaN. Each takes one
/// instruction.
#[inline]
pub(crate) fn in_order(a: f64, b: f64) -> [f64; 2] {
    [if a < b { a } else { b }, if a > b { a } else { b }]
}

/// Returns the bounding box of a segment.
#[inline]
pub(crate) fn bounds([a, b]: [Point; 2]) -> Rect {
    let ([min_x, max_x], [min_y, max_y]) = (in_order(a.x, b.x), in_order(a.y, b.y));
    Rect::new(min_x, min_y, max_x, max_y)
}

/// Returns whether two segments share an end.
#[inline]
pub(crate) fn share_an_end([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let same = |p: Point, q: Point| (p.x == q.x) & (p.y == q.y);
    same(a, c) | same(a, d) | same(b, c) | same(b, d)
}

/// Returns whether two bounding boxes meet, without a branch for each side.
#[inline]
pub(crate) fn boxes_meet(a: &Rect, b: &Rect) -> bool {
    (a.min_x <= b.max_x) & (b.min_x <= a.max_x) & (a.min_y <= b.max_y) & (b.min_y <= a.max_y)
}

/// Returns the intersection of two rectangles.
pub(crate) fn common(a: Rect, b: Rect) -> Rect {
    Rect::new(
        in_order(a.min_x, b.min_x)[1],
        in_order(a.min_y, b.min_y)[1],
        in_order(a.max_x, b.max_x)[0],
        in_order(a.max_y, b.max_y)[0],
    )
}
