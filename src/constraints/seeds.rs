//! Hole points. The regions that contain them are holes.

use crate::geometry::{Orientation, Point, Rect, orient2d};

/// Points, sorted by x.
#[derive(Clone, Debug, Default)]
pub(crate) struct Seeds(Vec<Point>);

impl Seeds {
    /// Sorts points.
    pub(crate) fn new(mut points: Vec<Point>) -> Self {
        points.sort_unstable_by(|a, b| a.lex_cmp(*b));
        points.dedup();
        Self(points)
    }

    /// Returns whether there are no points.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the points in a closed rectangle.
    pub(crate) fn within(&self, rect: Rect) -> impl Iterator<Item = Point> {
        let start = self.0.partition_point(|p| p.x < rect.min_x);
        let by_x = self.0[start..].iter().take_while(move |p| p.x <= rect.max_x);
        by_x.copied().filter(move |p| rect.min_y <= p.y && p.y <= rect.max_y)
    }

    /// Returns whether a point lies in a closed, counter-clockwise triangle. So a point on a
    /// constraint is on both of its sides, however the plane is triangulated.
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

/// The conditions under which a region is a hole, besides obstacles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HoleRules {
    /// Whether there may be holes.
    pub(crate) has_holes: bool,
    /// Whether regions that reach the hull without a constraint are holes.
    pub(crate) exterior: bool,
}

impl HoleRules {
    /// Returns whether a region is a hole. `depth` is the number of times that it is covered,
    /// `is_seeded` says whether it contains a seed, and `reaches_hull` whether it reaches the hull
    /// without a constraint.
    pub(crate) fn is_hole(self, depth: i32, is_seeded: bool, reaches_hull: bool) -> bool {
        depth != 0 || is_seeded || self.exterior && reaches_hull
    }
}
