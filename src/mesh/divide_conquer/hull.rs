//! The extreme vertices of a part.

use std::hint::select_unpredictable;

use super::half_edges::BitHalfEdge;
use crate::geometry::{Point, Rect};

/// The axis whose extent a cut halves.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Axis {
    X,
    Y,
}

/// The smallest and the largest of some vertices by x, then by y: `left` and `right`; and by y,
/// then by x: `bottom` and `top`.
#[derive(Clone, Copy)]
pub(super) struct Extremes<T> {
    pub(super) left: T,
    pub(super) right: T,
    pub(super) bottom: T,
    pub(super) top: T,
}

/// A vertex of a hull, and the ghost of the hull edge that leaves it.
///
/// A ghost is named by its real half-edge, which runs against the hull edge.
#[derive(Clone, Copy)]
pub(super) struct End {
    pub(super) vertex: u32,
    pub(super) leaves: BitHalfEdge,
}

/// The hull of a part. A merge starts from its extreme vertices.
pub(super) type Hull = Extremes<End>;

impl<T> Extremes<T> {
    #[inline]
    pub(super) fn map<U>(self, mut f: impl FnMut(T) -> U) -> Extremes<U> {
        Extremes {
            left: f(self.left),
            right: f(self.right),
            bottom: f(self.bottom),
            top: f(self.top),
        }
    }
}

impl Extremes<u32> {
    /// Returns the numbers of the extreme points.
    #[inline(always)]
    pub(super) fn of<const N: usize>(points: [Point; N]) -> Self {
        let start = (0, points[0]);
        let mut found = Extremes {
            left: start,
            right: start,
            bottom: start,
            top: start,
        };
        for next @ (_, p) in (0..).zip(points) {
            let pick = |is_next: bool, best| select_unpredictable(is_next, next, best);
            found.left = pick(xy_less(p, found.left.1), found.left);
            found.right = pick(xy_less(found.right.1, p), found.right);
            found.bottom = pick(yx_less(p, found.bottom.1), found.bottom);
            found.top = pick(yx_less(found.top.1, p), found.top);
        }
        found.map(|(number, _)| number)
    }
}

impl Hull {
    /// Returns the hull around two parts. A cut across `axis` separates them, `one` on the left or
    /// below.
    #[inline(always)]
    pub(super) fn joined(axis: Axis, one: Self, other: Self, points: &[Point]) -> Self {
        let point = |end: End| points[end.vertex as usize];
        let pick = |first: bool, a: End, b: End| select_unpredictable(first, a, b);
        match axis {
            Axis::X => Self {
                left: one.left,
                right: other.right,
                bottom: pick(
                    yx_less(point(one.bottom), point(other.bottom)),
                    one.bottom,
                    other.bottom,
                ),
                top: pick(yx_less(point(one.top), point(other.top)), other.top, one.top),
            },
            Axis::Y => Self {
                left: pick(xy_less(point(one.left), point(other.left)), one.left, other.left),
                right: pick(xy_less(point(one.right), point(other.right)), other.right, one.right),
                bottom: one.bottom,
                top: other.top,
            },
        }
    }

    /// Returns the same vertices, after `leaves` has become the ghost of the hull edge that leaves
    /// `vertex`.
    #[inline(always)]
    pub(super) fn with_leaving(self, vertex: u32, leaves: BitHalfEdge) -> Self {
        self.map(|end| End {
            leaves: select_unpredictable(end.vertex == vertex, leaves, end.leaves),
            ..end
        })
    }

    /// Returns the smallest rectangle around both parts.
    #[inline(always)]
    pub(super) fn bounds_with(&self, other: &Self, points: &[Point]) -> Rect {
        let point = |end: End| points[end.vertex as usize];
        Rect::new(
            point(self.left).x.min(point(other.left).x),
            point(self.bottom).y.min(point(other.bottom).y),
            point(self.right).x.max(point(other.right).x),
            point(self.top).y.max(point(other.top).y),
        )
    }
}

/// Returns whether `a` comes before `b` by x, then by y.
#[inline]
pub(super) fn xy_less(a: Point, b: Point) -> bool {
    (a.x < b.x) | ((a.x == b.x) & (a.y < b.y))
}

/// Returns whether `a` comes before `b` by y, then by x.
#[inline]
pub(super) fn yx_less(a: Point, b: Point) -> bool {
    (a.y < b.y) | ((a.y == b.y) & (a.x < b.x))
}
