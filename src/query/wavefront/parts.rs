//! What the wave has seen, part by part, for those who ask for it.
//!
//! Together the parts cover all that is not farther away than the wave has come; each point lies in one whose root a shortest way to it
//! bends around last. Parts of one root do not overlap but along their sides; those of several do.

use crate::geometry::Point;

/// What is seen from a root.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    /// The number of the root.
    pub(crate) root: u32,
    pub(crate) shape: Shape,
}

impl Part {
    /// The triangle that it lies in, unless it lies outside the hull.
    pub(crate) fn triangle(&self) -> Option<[Point; 3]> {
        match self.shape {
            Shape::Triangle { corners, .. } => Some(corners),
            Shape::Beyond { .. } | Shape::Half { .. } => None,
        }
    }
}

/// Where that is.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Shape {
    /// In a closed triangle, corners counter-clockwise: what lies between the rays through two points, right and left, or all of it.
    Triangle {
        corners: [Point; 3],
        between: Option<[Point; 2]>,
    },
    /// Outside the hull: what lies beyond a hull edge, ends as seen on the right and on the left, between two rays.
    Beyond { edge: [Point; 2], between: [Point; 2] },
    /// Outside the hull: all on one side of a line, but for what is on a side of another one.
    Half { side: Side, except: Option<Side> },
}

/// A side of the line from the root through a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side {
    pub(crate) towards: Point,
    pub(crate) is_left: bool,
}
