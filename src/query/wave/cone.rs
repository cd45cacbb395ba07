//! What a root sees through a side, and from below how far that is.
//!
//! A cone is a root and the two vertices on its bounding rays, so that every turn is one of three input points. Only the
//! estimates, which decide about the order of work and not about what is found, use computed points.

use crate::geometry::Point;

/// What is seen from a root between the rays through two vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    pub(super) root: Point,
    pub(super) right: Point,
    pub(super) left: Point,
}

/// The error of a crossing of ray and side, relative to the distance of the side's far end, is at most this, where the two
/// meet at an angle whose sine is not below [`SLANT`]: a determinant of differences is right to 4 ulp of its products.
const ERROR: f64 = 2e-11;
const SLANT: f64 = 1e-4;

/// The distance between two points. Its error is below two units in the last place.
#[inline]
pub(in crate::query) fn distance(a: Point, b: Point) -> f64 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    (dx * dx + dy * dy).sqrt()
}

#[inline]
fn cross(a: Point, b: Point) -> f64 {
    a.x * b.y - a.y * b.x
}

#[inline]
fn minus(a: Point, b: Point) -> Point {
    Point::new(a.x - b.x, a.y - b.y)
}

/// The sum of the magnitudes of the coordinates: at least the length.
#[inline]
fn size(v: Point) -> f64 {
    v.x.abs() + v.y.abs()
}

impl Cone {
    /// At most the length of a shortest way from the root through the part of a side that the cone holds, to the goal if there
    /// is one. The cone reaches over the side, whose ends are seen on its right and on its left.
    #[inline]
    pub(super) fn estimate(&self, right: Point, left: Point, goal: Option<Point>) -> f64 {
        let side = minus(left, right);
        let from = self.hit(self.right, right, left, side);
        let to = self.hit(self.left, left, right, side);
        let (near, far) = (minus(from, self.root), minus(to, self.root));
        let slack = ERROR * (size(near) + size(far));
        let length = match goal {
            None => to_segment(near, far),
            Some(goal) => {
                let mut goal = minus(goal, self.root);
                // What is on the root's side is reached as its mirror image would be.
                let corner = minus(right, self.root);
                let off = cross(side, minus(goal, corner));
                if off > 0.0 {
                    let push = 2.0 * off / (side.x * side.x + side.y * side.y);
                    goal = Point::new(goal.x + push * side.y, goal.y - push * side.x);
                }
                through(near, far, goal)
            }
        };
        (length - slack).max(0.0)
    }

    /// Where the ray through a vertex crosses a side; where that is not to be told well, the side's end, which is farther out.
    #[inline]
    fn hit(&self, via: Point, end: Point, other: Point, side: Point) -> Point {
        if via == end {
            return end;
        }
        if via == other {
            return other;
        }
        let ray = minus(via, self.root);
        let determinant = cross(ray, side);
        if determinant.abs() <= SLANT * size(ray) * size(side) {
            return end;
        }
        let along = cross(minus(end, self.root), side) / determinant;
        Point::new(self.root.x + along * ray.x, self.root.y + along * ray.y)
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

/// The length of the shortest way from the origin to a goal by way of a segment, given its right and left end as seen.
fn through(right: Point, left: Point, goal: Point) -> f64 {
    let origin = Point::new(0.0, 0.0);
    if cross(right, goal) < 0.0 {
        distance(origin, right) + distance(right, goal)
    } else if cross(left, goal) > 0.0 {
        distance(origin, left) + distance(left, goal)
    } else {
        distance(origin, goal)
    }
}
