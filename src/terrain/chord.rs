//! Where a segment of a line passes through a triangle.
//!
//! In: a facet and a segment. Out: the stations where the segment enters and leaves the closed triangle:
//! an end of the segment, a vertex on it, or an edge that it crosses. Which stations there are and which
//! comes first is exact. A station is the same to the last bit for all triangles that have it.

use super::facet::{Corner, Facet};
use crate::geometry::{Orientation, Point, crossing_point, doubled_area, orient2d};

/// What a line meets at a station. All triangles there agree on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Mark {
    /// A corner of the line, by its number.
    Corner(u32),
    /// A vertex inside a segment, by the segment's number and the bits of the coordinates.
    Vertex(u32, [u64; 2]),
    /// An edge that crosses a segment, by the segment's number and the bits of the coordinates of the
    /// ends, the lexicographically smaller one first.
    Edge(u32, [[u64; 2]; 2]),
}

/// A point of a line, with the height of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Station {
    pub(crate) mark: Mark,
    pub(crate) point: Point,
    pub(crate) z: f64,
}

/// What a triangle has of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Link {
    /// One point.
    Touch(Station),
    /// The part from one station to another.
    Chord(Station, Station),
}

/// A station, and whether the segment is before it or behind it in the triangle, if that is known.
struct End {
    station: Station,
    is_entry: Option<bool>,
}

/// Returns what a facet has of segment `number`, which runs from a corner of the line with this number
/// to the next one.
pub(crate) fn chord(facet: &Facet, number: u32, [a, b]: [Point; 2]) -> Option<Link> {
    let corners = facet.corners();
    let sides = corners.map(|corner| orient2d(a, b, corner.point));
    if sides[0] != Orientation::Collinear && sides.iter().all(|&side| side == sides[0]) {
        return None;
    }
    let mut ends: Vec<End> = Vec::with_capacity(2);
    for (p, corner, is_entry) in [(a, number, true), (b, number + 1, false)] {
        if let Some(place) = facet.place(p) {
            let station = Station {
                mark: Mark::Corner(corner),
                point: p,
                z: facet.z_at(p, place),
            };
            ends.push(End {
                station,
                is_entry: Some(is_entry),
            });
        }
    }
    for i in 0..3 {
        let (from, to) = (corners[i], corners[(i + 1) % 3]);
        if sides[i] == Orientation::Collinear && is_between(from.point, [a, b]) {
            let station = Station {
                mark: Mark::Vertex(number, bits(from.point)),
                point: from.point,
                z: from.z,
            };
            ends.push(End {
                station,
                is_entry: None,
            });
        }
        if let Some(point) = crossing_point(a, b, from.point, to.point) {
            ends.push(End {
                station: crossing(number, [a, b], [from, to], point),
                is_entry: Some(orient2d(from.point, to.point, a) == Orientation::Clockwise),
            });
        }
    }
    in_order(ends, [a, b])
}

/// Returns the station where a segment crosses an edge.
fn crossing(number: u32, [a, b]: [Point; 2], [from, to]: [Corner; 2], point: Point) -> Station {
    let [from, to] = match from.point.lex_cmp(to.point).is_lt() {
        true => [from, to],
        false => [to, from],
    };
    // The distances of the ends of the edge from the segment, which have relative errors far below
    // those of the rounded point.
    let [before, after] = [from, to].map(|end| doubled_area(a, b, end.point).abs());
    let z = from.z + before / (before + after) * (to.z - from.z);
    Station {
        mark: Mark::Edge(number, [bits(from.point), bits(to.point)]),
        point,
        z: z.max(from.z.min(to.z)).min(from.z.max(to.z)),
    }
}

/// Orders at most two stations along a segment.
fn in_order(mut ends: Vec<End>, [a, b]: [Point; 2]) -> Option<Link> {
    let (last, first) = (ends.pop()?, ends.pop());
    let Some(first) = first else {
        return Some(Link::Touch(last.station));
    };
    let is_swapped = match (first.is_entry, last.is_entry) {
        (Some(is_entry), _) => !is_entry,
        (None, Some(is_entry)) => is_entry,
        (None, None) => first.station.point.lex_cmp(last.station.point) != a.lex_cmp(b),
    };
    let [first, last] = if is_swapped { [last, first] } else { [first, last] };
    Some(Link::Chord(first.station, last.station))
}

/// Returns whether a point on the line through a segment is inside the segment.
fn is_between(p: Point, [a, b]: [Point; 2]) -> bool {
    let order = a.lex_cmp(b);
    a.lex_cmp(p) == order && p.lex_cmp(b) == order
}

fn bits(point: Point) -> [u64; 2] {
    let Point { x, y } = point.normalized();
    [x.to_bits(), y.to_bits()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn facet() -> Facet {
        Facet::new(
            [(0.0, 0.0, 0.0), (4.0, 0.0, 8.0), (0.0, 4.0, 4.0)].map(|(x, y, z)| Corner {
                point: Point::new(x, y),
                z,
            }),
        )
    }

    /// Returns the positions and heights of the stations of a segment.
    fn stations(a: (f64, f64), b: (f64, f64)) -> Vec<(f64, f64, f64)> {
        let ends = [a, b].map(|(x, y)| Point::new(x, y));
        let stations = match chord(&facet(), 0, ends) {
            None => vec![],
            Some(Link::Touch(station)) => vec![station],
            Some(Link::Chord(from, to)) => vec![from, to],
        };
        stations.iter().map(|s| (s.point.x, s.point.y, s.z)).collect()
    }

    #[test]
    fn segments_enter_and_leave_a_triangle_at_its_edges_its_vertices_and_their_ends() {
        for (a, b, expected) in [
            // Through two edges, through a vertex and an edge, along an edge and a part of it.
            ((-1.0, 1.0), (9.0, 1.0), vec![(0.0, 1.0, 1.0), (3.0, 1.0, 7.0)]),
            ((-1.0, -1.0), (5.0, 5.0), vec![(0.0, 0.0, 0.0), (2.0, 2.0, 6.0)]),
            ((-1.0, 0.0), (5.0, 0.0), vec![(0.0, 0.0, 0.0), (4.0, 0.0, 8.0)]),
            ((1.0, 0.0), (5.0, 0.0), vec![(1.0, 0.0, 2.0), (4.0, 0.0, 8.0)]),
            ((1.0, 0.0), (3.0, 0.0), vec![(1.0, 0.0, 2.0), (3.0, 0.0, 6.0)]),
            ((0.0, 0.0), (4.0, 0.0), vec![(0.0, 0.0, 0.0), (4.0, 0.0, 8.0)]),
            // From inside to outside, and all inside.
            ((1.0, 1.0), (1.0, 5.0), vec![(1.0, 1.0, 3.0), (1.0, 3.0, 5.0)]),
            ((1.0, 1.0), (1.0, 2.0), vec![(1.0, 1.0, 3.0), (1.0, 2.0, 4.0)]),
            // Touching, and beside.
            ((-1.0, 1.0), (1.0, -1.0), vec![(0.0, 0.0, 0.0)]),
            ((2.0, 2.0), (5.0, 5.0), vec![(2.0, 2.0, 6.0)]),
            ((4.0, 0.0), (5.0, 0.0), vec![(4.0, 0.0, 8.0)]),
            ((5.0, 0.0), (6.0, 0.0), vec![]),
            ((-1.0, 0.5), (0.5, -1.0), vec![]),
        ] {
            assert_eq!(stations(a, b), expected, "{a:?} {b:?}");
            let mut back = stations(b, a);
            back.reverse();
            assert_eq!(back, expected, "{b:?} {a:?}");
        }
    }
}
