//! Polygons of an area.

use std::iter;

use super::rings::signed_area;
use crate::geometry::Point;

/// A polygon of the area within a walking distance, with straight edges.
///
/// No ring repeats its first point at its end, none crosses itself or another one, and none has a
/// point twice. Rings may touch at points.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct AreaPolygon {
    /// The outline, counter-clockwise.
    pub outline: Vec<Point>,
    /// The holes, each clockwise.
    pub holes: Vec<Vec<Point>>,
}

impl AreaPolygon {
    /// Returns the outline and the holes.
    pub fn rings(&self) -> impl Iterator<Item = &[Point]> {
        iter::once(&self.outline).chain(&self.holes).map(Vec::as_slice)
    }

    /// Returns the area, without that of the holes, in squares of the unit of the coordinates.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.rings().map(signed_area).sum()
    }
}
