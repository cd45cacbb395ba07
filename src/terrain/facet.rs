//! The plane of a triangle: heights, slopes and positions on it.
//!
//! In: the corners of a triangle with z. Out: z at a point of the triangle, and its gradient.
//!
//! Nothing depends on which corner comes first, nor on the tile that the triangle is read from: a
//! facet begins with its lexicographically smallest corner. A height on an edge is computed from the
//! ends of the edge alone, and at a corner it is the corner's, so that all triangles at a point give
//! the same bits.

use crate::geometry::{Orientation, Point, doubled_area, orient2d};

/// A corner of a triangle: a position with its z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// The position.
    pub point: Point,
    /// The height.
    pub z: f64,
}

/// The place of a point on a closed triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// On a corner.
    Corner(usize),
    /// Between corners `i` and `i + 1`.
    Edge(usize),
    Inside,
}

/// A triangle of a surface, counter-clockwise and not of zero area.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facet {
    corners: [Corner; 3],
    /// Twice the area.
    area: f64,
    gradient: [f64; 2],
    /// Whether the triangle is so thin that the gradient's error could be seen at its far end.
    is_thin: bool,
}

impl Facet {
    /// Below this ratio of height and length, z is computed without the gradient.
    const THIN: f64 = 1.0 / 65536.0;

    /// Creates the facet of a triangle with these corners, counter-clockwise.
    pub(crate) fn new(mut corners: [Corner; 3]) -> Self {
        let smaller = |i: usize, j: usize| corners[i].point.lex_cmp(corners[j].point).is_lt();
        let first = match (smaller(1, 0), smaller(2, 0), smaller(2, 1)) {
            (false, false, _) => 0,
            (true, _, false) => 1,
            _ => 2,
        };
        corners.rotate_left(first);
        let [a, b, c] = corners;
        let area = doubled_area(a.point, b.point, c.point);
        let [(bx, by), (cx, cy)] = [b, c].map(|corner| (corner.point.x - a.point.x, corner.point.y - a.point.y));
        let [bz, cz] = [b, c].map(|corner| corner.z - a.z);
        let longest = (bx * bx + by * by).max(cx * cx + cy * cy);
        Self {
            corners,
            area,
            gradient: [(bz * cy - cz * by) / area, (cz * bx - bz * cx) / area],
            is_thin: area < Self::THIN * longest,
        }
    }

    /// Returns the corners, the lexicographically smallest one first.
    pub(crate) fn corners(&self) -> [Corner; 3] {
        self.corners
    }

    /// Returns twice the area.
    pub(crate) fn doubled_area(&self) -> f64 {
        self.area
    }

    /// Returns the change of z for each unit of x and of y.
    pub(crate) fn gradient(&self) -> [f64; 2] {
        self.gradient
    }

    /// Returns the place of a point; `None` if it is outside. Exact.
    pub(crate) fn place(&self, p: Point) -> Option<Place> {
        let mut on = [false; 3];
        for (i, on) in on.iter_mut().enumerate() {
            match orient2d(self.corners[i].point, self.corners[(i + 1) % 3].point, p) {
                Orientation::Clockwise => return None,
                Orientation::Collinear => *on = true,
                Orientation::CounterClockwise => {}
            }
        }
        Some(match on {
            [false, false, false] => Place::Inside,
            [true, false, false] => Place::Edge(0),
            [false, true, false] => Place::Edge(1),
            [false, false, true] => Place::Edge(2),
            [true, _, true] => Place::Corner(0),
            [true, true, _] => Place::Corner(1),
            [_, true, true] => Place::Corner(2),
        })
    }

    /// Returns z at a point at its place.
    #[inline]
    pub(crate) fn z_at(&self, p: Point, place: Place) -> f64 {
        match place {
            Place::Corner(i) => self.corners[i].z,
            Place::Edge(i) => z_on_edge([self.corners[i], self.corners[(i + 1) % 3]], p),
            Place::Inside => self.z_inside(p),
        }
    }

    /// Returns z at a point inside the triangle.
    #[inline]
    pub(crate) fn z_inside(&self, p: Point) -> f64 {
        let [a, b, c] = self.corners;
        let z = if self.is_thin {
            let of_b = doubled_area(a.point, p, c.point) / self.area;
            let of_c = doubled_area(a.point, b.point, p) / self.area;
            a.z + of_b * (b.z - a.z) + of_c * (c.z - a.z)
        } else {
            a.z + self.gradient[0] * (p.x - a.point.x) + self.gradient[1] * (p.y - a.point.y)
        };
        // No point of a triangle is higher or lower than all of its corners.
        z.max(a.z.min(b.z).min(c.z)).min(a.z.max(b.z).max(c.z))
    }

    /// Returns whether a point at this place is still in the triangle after a move by an infinitesimal
    /// distance to the right, and by an infinitesimal share of it upwards. Around each point, this holds
    /// for exactly one triangle of the plane.
    pub(crate) fn has_moved(&self, place: Place) -> bool {
        let stays = |i: usize| {
            let [from, to] = [self.corners[i].point, self.corners[(i + 1) % 3].point];
            to.y < from.y || (to.y == from.y && to.x > from.x)
        };
        match place {
            Place::Corner(i) => stays(i) && stays((i + 2) % 3),
            Place::Edge(i) => stays(i),
            Place::Inside => true,
        }
    }
}

/// Returns z at a point of an edge, the same for both directions of the edge.
pub(crate) fn z_on_edge(mut ends: [Corner; 2], p: Point) -> f64 {
    if ends[1].point.lex_cmp(ends[0].point).is_lt() {
        ends.swap(0, 1);
    }
    let [a, b] = ends;
    let (dx, dy) = (b.point.x - a.point.x, b.point.y - a.point.y);
    let share = match dx.abs() >= dy.abs() {
        true => (p.x - a.point.x) / dx,
        false => (p.y - a.point.y) / dy,
    };
    let z = a.z + share * (b.z - a.z);
    z.max(a.z.min(b.z)).min(a.z.max(b.z))
}

/// Returns the point of an edge at a height between those of its ends, the same for both directions of
/// the edge. At the height of an end it is that end. Exact predicates can take it.
pub(crate) fn point_on_edge(mut ends: [Corner; 2], z: f64) -> Point {
    if ends[1].point.lex_cmp(ends[0].point).is_lt() {
        ends.swap(0, 1);
    }
    let [a, b] = ends;
    if let Some(end) = ends.into_iter().find(|end| end.z == z) {
        return end.point;
    }
    // Halves, because the difference of two numbers may be too large for a number.
    let share = (z / 2.0 - a.z / 2.0) / (b.z / 2.0 - a.z / 2.0);
    let between = |from: f64, to: f64| {
        let v = from + share * (to - from);
        v.max(from.min(to)).min(from.max(to))
    };
    Point::new(between(a.point.x, b.point.x), between(a.point.y, b.point.y)).representable()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(x: f64, y: f64, z: f64) -> Corner {
        Corner {
            point: Point::new(x, y),
            z,
        }
    }

    #[test]
    fn every_rotation_of_the_corners_gives_the_same_bits() {
        let corners = [corner(3.1, 0.2, 7.0), corner(9.3, 4.4, -1.5), corner(0.7, 5.9, 2.25)];
        let p = Point::new(4.0, 3.0);
        let results: Vec<u64> = (0..3)
            .map(|turns| {
                let mut corners = corners;
                corners.rotate_left(turns);
                let facet = Facet::new(corners);
                assert_eq!(facet.corners()[0].point, corners_min(corners));
                facet.z_at(p, facet.place(p).unwrap()).to_bits()
            })
            .collect();
        assert!(results.iter().all(|&bits| bits == results[0]));
    }

    fn corners_min(corners: [Corner; 3]) -> Point {
        corners
            .map(|c| c.point)
            .into_iter()
            .min_by(|a, b| a.lex_cmp(*b))
            .unwrap()
    }

    #[test]
    fn a_needle_keeps_its_heights() {
        // 10⁶ long, 10⁻⁶ high, and steep across.
        let facet = Facet::new([corner(0.0, 0.0, 10.0), corner(1e6, 1e-6, 20.0), corner(5e5, 1e-6, 30.0)]);
        assert!(facet.is_thin);
        // On the line from the first corner to the middle of the opposite edge, at two thirds.
        let p = Point::new(5e5, 1e-6 * (2.0 / 3.0));
        let z = facet.z_at(p, facet.place(p).unwrap());
        assert!((z - (10.0 + 2.0 / 3.0 * 15.0)).abs() < 1e-9, "{z}");
    }

    #[test]
    fn points_on_edges_are_between_their_ends() {
        let ends = [corner(3.5, 0.25, 7.0), corner(-0.5, 5.25, -1.0)];
        for (z, x, y) in [(7.0, 3.5, 0.25), (-1.0, -0.5, 5.25), (1.0, 0.5, 4.0)] {
            let reversed = [ends[1], ends[0]];
            assert_eq!(point_on_edge(ends, z), Point::new(x, y));
            assert_eq!(point_on_edge(reversed, z), Point::new(x, y));
        }
        let far = [corner(0.0, 0.0, f64::MIN), corner(8.0, 4.0, f64::MAX)];
        assert_eq!(point_on_edge(far, 0.0), Point::new(4.0, 2.0));
    }

    #[test]
    fn places_are_exact_and_one_triangle_around_a_point_has_the_moved_point() {
        let centre = corner(0.0, 0.0, 5.0);
        let around = [
            corner(1.0, 0.0, 1.0),
            corner(0.0, 1.0, 2.0),
            corner(-1.0, 0.0, 3.0),
            corner(0.0, -1.0, 4.0),
        ];
        let facets: Vec<Facet> = (0..4)
            .map(|i| Facet::new([centre, around[i], around[(i + 1) % 4]]))
            .collect();
        for (p, touching, z) in [
            (Point::new(0.0, 0.0), 4, 5.0),
            (Point::new(0.5, 0.0), 2, 3.0),
            (Point::new(0.0, -0.25), 2, 4.75),
            (Point::new(-0.25, 0.25), 1, 3.75),
        ] {
            let places: Vec<_> = facets.iter().map(|facet| facet.place(p)).collect();
            assert_eq!(places.iter().flatten().count(), touching, "{p:?}");
            let at = || {
                facets
                    .iter()
                    .zip(&places)
                    .filter_map(|(facet, place)| Some((facet, (*place)?)))
            };
            assert_eq!(
                at().filter(|(facet, place)| facet.has_moved(*place)).count(),
                1,
                "{p:?}"
            );
            assert!(at().all(|(facet, place)| facet.z_at(p, place) == z), "{p:?}");
        }
    }
}
