//! What a root sees through a side, and from below how far that is.
//!
//! A cone is a root and the two vertices on its bounding rays, so that every turn is one of three input points. Only the
//! estimates, which decide about the order of work and not about what is found, use computed points.

use crate::geometry::Point;
use crate::query::answer::distance;

/// What is seen from a root between the rays through two vertices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone {
    pub(crate) root: Point,
    pub(crate) right: Point,
    pub(crate) left: Point,
}

/// The error of a crossing of ray and side, relative to the distance of the side's far end, is at most this, where the two
/// meet at an angle whose sine is not below [`SLANT`]: a determinant of differences is right to 4 ulp of its products.
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

/// The sum of the magnitudes of the coordinates: at least the length.
#[inline]
fn size(v: Point) -> f64 {
    v.x.abs() + v.y.abs()
}

impl Cone {
    /// Where the cone crosses a side, whose ends are seen on its right and on its left, beyond or on its rays.
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

    /// Where the ray through a vertex crosses a side, seen from the root; where that is not to be told well, the side's end, which is farther out.
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

/// Where a cone crosses a side, as seen from the root; what is on the right comes first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// Where the rays cross it, and how far that is.
    pub(crate) rays: [Point; 2],
    pub(crate) lengths: [f64; 2],
    /// Its ends.
    pub(crate) ends: [Point; 2],
    /// More than lengths by way of where the rays cross may be wrong by.
    pub(crate) slack: f64,
}

impl Crossing {
    /// At most the length of a shortest way from the root through the crossing, to the goal, as seen from the root, if there is one.
    #[inline]
    pub(crate) fn estimate(&self, goal: Option<Point>) -> f64 {
        let [right, left] = self.rays;
        let length = match goal {
            None => to_segment(right, left),
            Some(goal) => {
                let mut goal = goal;
                // What is on the root's side is reached as its mirror image would be.
                let side = minus(self.ends[1], self.ends[0]);
                let off = cross(side, minus(goal, self.ends[0]));
                if off > 0.0 {
                    let push = 2.0 * off / (side.x * side.x + side.y * side.y);
                    goal = Point::new(goal.x + push * side.y, goal.y - push * side.x);
                }
                if cross(right, goal) < 0.0 {
                    self.lengths[0] + distance(right, goal)
                } else if cross(left, goal) > 0.0 {
                    self.lengths[1] + distance(left, goal)
                } else {
                    (goal.x * goal.x + goal.y * goal.y).sqrt()
                }
            }
        };
        (length - self.slack).max(0.0)
    }
}

/// The distance of a segment from the origin.
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
