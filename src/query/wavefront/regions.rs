//! The regions that the wavefront has seen, for the callers that ask for them.
//!
//! Together the regions cover everything that is not farther away than the wavefront has come. Each
//! point is in a region whose root is the last bend of a shortest path to the point. Regions of one
//! root overlap in their edges only; regions of different roots may overlap.

use crate::geometry::Point;

/// A region that a root sees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VisibleRegion {
    /// The number of the root.
    pub(crate) root: u32,
    pub(crate) shape: RegionShape,
}

impl VisibleRegion {
    /// Returns the triangle that contains the region; `None` if the region is outside the hull.
    pub(crate) fn triangle(&self) -> Option<[Point; 3]> {
        match self.shape {
            RegionShape::Triangle { corners, .. } => Some(corners),
            RegionShape::BehindHullEdge { .. } | RegionShape::HalfPlane { .. } => None,
        }
    }
}

/// The shape of a region.
#[derive(Clone, Copy, Debug)]
pub(crate) enum RegionShape {
    /// A closed triangle, with counter-clockwise corners, or only its part between the rays through
    /// two points: right, then left.
    Triangle {
        corners: [Point; 3],
        between: Option<[Point; 2]>,
    },
    /// Outside the hull: the part beyond a hull edge between two rays. The ends of the edge are
    /// those seen on the right and on the left.
    BehindHullEdge { edge: [Point; 2], between: [Point; 2] },
    /// Outside the hull: a half-plane, except for the part in another half-plane.
    HalfPlane {
        half_plane: HalfPlane,
        except: Option<HalfPlane>,
    },
}

/// The half-plane on one side of the line from the root through a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HalfPlane {
    pub(crate) towards: Point,
    pub(crate) is_left: bool,
}

/// A triangle, all of which is within the limit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WholeTriangle {
    /// The corners, counter-clockwise.
    pub(crate) corners: [Point; 3],
    /// Whether other tiles have the triangle, too.
    pub(crate) is_shared: bool,
}
