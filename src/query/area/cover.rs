//! Covers of areas: whole triangles, and pieces of the others.

use foldhash::{HashMap, HashSet};

use super::piece::AreaPiece;
use super::polygon::AreaPolygon;
use super::rings::{PointKey, is_clockwise, point_key, point_of, rings_of};
use super::union::united;
use crate::geometry::Point;
use crate::query::wavefront::WholeTriangle;

/// Points that are at most this fraction of the radius away from a straight line are removed.
const STRAIGHT: f64 = 1e-8;

/// The corners of a triangle, in an order that does not depend on which of them comes first.
type TriangleKey = [PointKey; 3];

fn triangle_key(corners: [Point; 3]) -> TriangleKey {
    let mut keys = corners.map(point_key);
    keys.sort_unstable();
    keys
}

/// An area as the union of triangles, which do not overlap, and of pieces elsewhere.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, Default)]
pub struct AreaCover {
    /// The half-edges of whole triangles whose twins are not half-edges of whole triangles.
    boundary: HashSet<[PointKey; 2]>,
    /// The whole triangles that several tiles have. Each tile may report them.
    shared: HashSet<TriangleKey>,
    /// The pieces of triangles that are not known to be whole.
    partial: HashMap<TriangleKey, Vec<AreaPiece>>,
    outside: Vec<AreaPiece>,
    radius: f64,
    /// Whether no limit ended the query.
    is_complete: bool,
}

impl AreaCover {
    /// Adds a triangle that lies in the area as a whole.
    pub(super) fn add_whole(&mut self, triangle: WholeTriangle) {
        let key = triangle_key(triangle.corners);
        if triangle.is_shared && !self.shared.insert(key) {
            return;
        }
        self.partial.remove(&key);
        let keys = triangle.corners.map(point_key);
        for [from, to] in [[0, 1], [1, 2], [2, 0]].map(|ends| ends.map(|i| keys[i])) {
            if !self.boundary.remove(&[to, from]) {
                self.boundary.insert([from, to]);
            }
        }
    }

    /// Adds a piece, which lies in a triangle or outside the hull.
    pub(super) fn add_piece(&mut self, triangle: Option<[Point; 3]>, piece: AreaPiece) {
        match triangle.map(triangle_key) {
            Some(key) if self.shared.contains(&key) => {}
            Some(key) => self.partial.entry(key).or_default().push(piece),
            None => self.outside.push(piece),
        }
    }

    /// Sets the radius of the area.
    pub(super) fn set_radius(&mut self, radius: f64) {
        self.radius = radius;
    }

    /// Says that the cover has the whole area.
    pub(super) fn complete(&mut self) {
        self.is_complete = true;
    }

    /// Returns the area as polygons that do not overlap.
    ///
    /// Arcs become chords inside the area, which are nowhere farther from the arc than `tolerance`
    /// times its radius: 1e-4 makes the area of a disc 0.014 % too small. A tolerance below 1e-9
    /// counts as 1e-9. Coordinates are rounded to a grid, whose step is at most 2^-35 of the area's
    /// size or, if that is more, 32 units in the last place of the coordinates. Points that are
    /// almost on a straight line, nearer than 1e-8 of the radius, are left out.
    ///
    /// [Examples](crate::query#examples).
    #[must_use]
    pub fn polygons(&self, tolerance: f64) -> Vec<AreaPolygon> {
        let boundary = self.boundary.iter().map(|ends| ends.map(point_of)).collect();
        let (holes, mut rings) = self.split(rings_of(boundary));
        let mut triangles: Vec<_> = self.partial.iter().collect();
        triangles.sort_unstable_by_key(|(key, _)| **key);
        let pieces = triangles.into_iter().flat_map(|(_, pieces)| pieces);
        rings.extend(pieces.map(|piece| piece.outline(tolerance)));
        // Beyond the hull, each root may see the same as all others.
        let outside = self.outside.iter().map(|piece| piece.outline(tolerance)).collect();
        united(rings, outside, holes, STRAIGHT * self.radius)
    }

    /// Splits the rings around whole triangles into holes without any part of the area in them,
    /// which most buildings are, and others. The holes meet neither pieces nor other rings, except
    /// those of other holes.
    fn split(&self, rings: Vec<Vec<Point>>) -> (Vec<Vec<Point>>, Vec<Vec<Point>>) {
        // Without the whole area, nobody knows what is in a hole.
        if !self.is_complete {
            return (Vec::new(), rings);
        }
        let (inner, mut outer): (Vec<_>, Vec<_>) = rings.into_iter().partition(|ring| is_clockwise(ring));
        let corners = outer.iter().flatten().map(|&point| point_key(point));
        let met: HashSet<PointKey> = self.partial.keys().flatten().copied().chain(corners).collect();
        let is_hole = |ring: &Vec<Point>| !ring.iter().any(|&point| met.contains(&point_key(point)));
        let (holes, others): (Vec<_>, Vec<_>) = inner.into_iter().partition(is_hole);
        outer.extend(others);
        (holes, outer)
    }
}
