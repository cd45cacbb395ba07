//! Hole points: the regions that they lie in are holes.

use crate::geometry::{Orientation, Point, Rect, orient2d};

/// Points by their x.
#[derive(Clone, Debug, Default)]
pub(crate) struct Seeds(Vec<Point>);

impl Seeds {
    /// Puts points in order.
    pub(crate) fn new(mut points: Vec<Point>) -> Self {
        points.sort_unstable_by(|a, b| a.lex_cmp(*b));
        points.dedup();
        Self(points)
    }

    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Those in a closed rectangle.
    pub(crate) fn within(&self, rect: Rect) -> impl Iterator<Item = Point> {
        let start = self.0.partition_point(|p| p.x < rect.min_x);
        let by_x = self.0[start..].iter().take_while(move |p| p.x <= rect.max_x);
        by_x.copied().filter(move |p| rect.min_y <= p.y && p.y <= rect.max_y)
    }

    /// Whether one lies in a closed triangle, counter-clockwise. So one on a constraint is on both of its sides, whatever
    /// triangles the plane is cut into.
    pub(crate) fn any_in(&self, [a, b, c]: [Point; 3]) -> bool {
        let sides = [(a, b), (b, c), (c, a)];
        let is_in = |p: Point| {
            sides
                .iter()
                .all(|&(from, to)| orient2d(from, to, p) != Orientation::Clockwise)
        };
        self.within(Rect::around([a, b, c])).any(is_in)
    }
}

/// What makes a region a hole, beside obstacles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HoleRules {
    /// Whether there may be any.
    pub(crate) has_holes: bool,
    /// Whether regions that reach the hull without a constraint are.
    pub(crate) exterior: bool,
}

impl HoleRules {
    /// Whether a region is a hole that is covered so many times, that a seed lies in or not, and that reaches the hull without a
    /// constraint or not.
    pub(crate) fn is_hole(self, depth: i32, is_seeded: bool, reaches_hull: bool) -> bool {
        depth != 0 || is_seeded || self.exterior && reaches_hull
    }
}
