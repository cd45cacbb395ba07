//! What a root sees through an edge, and a lower bound of how far that is.
//!
//! A window is a root and the two vertices on its bounding rays, so every turn is a turn of three
//! input points. Only the estimates use computed points. They decide the order of work, not its
//! result.

use crate::geometry::Point;
use crate::query::answer::distance;

/// What a root sees between the rays through two vertices: right, then left.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    pub(crate) root: Point,
    pub(crate) right: Point,
    pub(crate) left: Point,
}

/// The maximum error of the crossing of a ray and an edge, relative to the distance of the edge's
/// far end, if the sine of the angle between the two is at least [`SLANT`]. A determinant of
/// differences is correct to 4 ulp of its products.
const ERROR: f64 = 2e-11;
const SLANT: f64 = 1e-4;

#[inline]
fn cross(a: Point, b: Point) -> f64 {
    a.x * b.y - a.y * b.x
}

#[inline]
pub(crate) fn minus(a: Point, b: Point) -> Point {
    Point::new(a.x - b.x, a.y - b.y)
}

/// Returns the sum of the magnitudes of the coordinates, which is at least the length.
#[inline]
fn size(v: Point) -> f64 {
    v.x.abs() + v.y.abs()
}

impl Window {
    /// Returns the crossing of the window and an edge. The ends of the edge are seen on the right
    /// and on the left of the window, beyond its rays or on them.
    #[inline]
    pub(crate) fn crossing(&self, right: Point, left: Point) -> Crossing {
        let ends = [right, left].map(|end| minus(end, self.root));
        let side = minus(left, right);
        let [on_right, on_left] = [self.right == right, self.left == left];
        let near = if on_right {
            ends[0]
        } else {
            self.hit(self.right, ends[0], left, ends[1], side)
        };
        let far = if on_left {
            ends[1]
        } else {
            self.hit(self.left, ends[1], right, ends[0], side)
        };
        let rays = [near, far];
        Crossing {
            rays,
            ends,
            lengths: rays.map(|ray| (ray.x * ray.x + ray.y * ray.y).sqrt()),
            slack: 4.0 * ERROR * (size(near) + size(far)),
        }
    }

    /// Returns the point, relative to the root, where the ray through a vertex crosses an edge. If
    /// the crossing is ill-conditioned, returns the end of the edge, which is farther out.
    #[inline]
    fn hit(&self, via: Point, end: Point, other: Point, other_end: Point, side: Point) -> Point {
        if via == other {
            return other_end;
        }
        let ray = minus(via, self.root);
        let determinant = cross(ray, side);
        if determinant.abs() <= SLANT * size(ray) * size(side) {
            return end;
        }
        let along = cross(end, side) / determinant;
        Point::new(along * ray.x, along * ray.y)
    }
}

/// The crossing of a window and an edge, relative to the root. What is on the right comes first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// The points where the rays cross the edge, and their distances.
    pub(crate) rays: [Point; 2],
    pub(crate) lengths: [f64; 2],
    /// The ends of the edge.
    pub(crate) ends: [Point; 2],
    /// An upper bound of the error of lengths by way of the crossings of the rays.
    pub(crate) slack: f64,
}

impl Crossing {
    /// Returns a lower bound of the distance of the crossing from the root.
    #[inline]
    pub(crate) fn length_to_edge(&self) -> f64 {
        let [right, left] = self.rays;
        (to_segment(right, left) - self.slack).max(0.0)
    }

    /// Returns a lower bound of the length of a shortest path from the root through the crossing,
    /// and on to a goal. The goal is relative to the root.
    #[inline]
    pub(crate) fn length_to_goal(&self, mut goal: Point) -> f64 {
        let [right, left] = self.rays;
        // A goal on the root's side of the edge is as far as its mirror image.
        let side = minus(self.ends[1], self.ends[0]);
        let off = cross(side, minus(goal, self.ends[0]));
        if off > 0.0 {
            let push = 2.0 * off / (side.x * side.x + side.y * side.y);
            goal = Point::new(goal.x + push * side.y, goal.y - push * side.x);
        }
        let length = if cross(right, goal) < 0.0 {
            self.lengths[0] + distance(right, goal)
        } else if cross(left, goal) > 0.0 {
            self.lengths[1] + distance(left, goal)
        } else {
            (goal.x * goal.x + goal.y * goal.y).sqrt()
        };
        (length - self.slack).max(0.0)
    }
}

/// Returns the distance of a segment from the origin.
fn to_segment(a: Point, b: Point) -> f64 {
    let d = minus(b, a);
    let square = d.x * d.x + d.y * d.y;
    let along = if square > 0.0 {
        -(a.x * d.x + a.y * d.y) / square
    } else {
        0.0
    };
    let along = along.clamp(0.0, 1.0);
    let foot = Point::new(a.x + along * d.x, a.y + along * d.y);
    (foot.x * foot.x + foot.y * foot.y).sqrt()
}
