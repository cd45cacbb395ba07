//! What the wave has seen, part by part, for those who ask for it.
//!
//! Together the parts cover all that is not farther away than the wave has come; each point lies in one whose root a shortest way to it
//! bends around last. Parts of one root do not overlap but along their sides; those of several do.

use super::*;

/// What is seen from a root.
#[derive(Clone, Copy, Debug)]
pub(in crate::query) struct Part {
    /// The number of the root.
    pub(in crate::query) root: u32,
    pub(in crate::query) shape: Shape,
}

/// Where that is.
#[derive(Clone, Copy, Debug)]
pub(in crate::query) enum Shape {
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
pub(in crate::query) struct Side {
    pub(in crate::query) towards: Point,
    pub(in crate::query) is_left: bool,
}

impl Wave {
    /// Keeps parts from now on.
    pub(in crate::query) fn keep_parts(&mut self) {
        self.parts.get_or_insert_default();
    }

    /// The parts seen since they were taken last.
    pub(in crate::query) fn parts(&self) -> &[Part] {
        self.parts.as_deref().unwrap_or_default()
    }

    /// Takes the parts seen since this was asked last.
    pub(in crate::query) fn take_parts(&mut self) -> Vec<Part> {
        self.parts.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Where a root is, and how long the way to it is.
    pub(in crate::query) fn root_at(&self, root: u32) -> (Point, f64) {
        let root = &self.roots[root as usize];
        (root.point, root.length)
    }

    /// Keeps a part, if parts are asked for.
    #[inline]
    pub(super) fn keep(&mut self, root: u32, shape: Shape) {
        if let Some(parts) = &mut self.parts {
            parts.push(Part { root, shape });
        }
    }
}
