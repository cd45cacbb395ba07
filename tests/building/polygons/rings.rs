//! The oracle: polygons as their files have them, read without the library's readers.

use std::fs;
use std::path::Path;

use delaunay_tiles::geometry::{Orientation, Point, orient2d, segments_cross};
use serde_json::Value;

/// A polygon. The outer ring is counter-clockwise, holes are clockwise; no ring repeats its first
/// position at its end.
#[derive(Clone, Debug)]
pub(crate) struct Polygon {
    pub(crate) rings: Vec<Vec<Point>>,
}

impl Polygon {
    /// Creates a polygon from rings of any winding, closed or not. Leaves out positions that repeat
    /// the one before, and rings of one position.
    pub(crate) fn new(rings: &[Vec<[f64; 2]>]) -> Self {
        let directed = rings.iter().enumerate().map(|(number, ring)| {
            let mut ring: Vec<Point> = ring.iter().map(|&[x, y]| Point::new(x, y).normalized()).collect();
            ring.dedup();
            if ring.len() > 1 && ring.first() == ring.last() {
                ring.pop();
            }
            if (area(&ring) > 0.0) != (number == 0) {
                ring.reverse();
            }
            ring
        });
        Self {
            rings: directed.filter(|ring| ring.len() > 1).collect(),
        }
    }

    pub(crate) fn segments(&self) -> impl Iterator<Item = [Point; 2]> {
        self.rings.iter().flat_map(|ring| edges(ring))
    }

    pub(crate) fn vertices(&self) -> usize {
        self.rings.iter().map(Vec::len).sum()
    }

    pub(crate) fn area(&self) -> f64 {
        self.rings.iter().map(|ring| area(ring)).sum()
    }

    /// Returns what keeps it from being one connected area in which no vertex is on another vertex
    /// or edge.
    pub(crate) fn flaws(&self) -> Vec<Flaw> {
        let segments: Vec<[Point; 2]> = self.segments().collect();
        // A vertex is on the two edges that end in it.
        let touches = |p: Point| segments.iter().filter(|[a, b]| lies_on(p, *a, *b)).count() > 2;
        // Only vertices that touch nothing else decide.
        let is_nested = |(number, hole): (usize, &Vec<Point>)| {
            let others = self.rings.iter().enumerate().filter(|(other, _)| *other != number);
            let others: Vec<[Point; 2]> = others.flat_map(|(_, ring)| edges(ring)).collect();
            let mut free = hole.iter().filter(|p| !touches(**p));
            free.all(|p| winding(&others, *p) == 1)
        };
        let mut flaws = Vec::new();
        for (flaw, is_there) in [
            (Flaw::Flat, self.rings.iter().any(|ring| area(ring) == 0.0)),
            (Flaw::Crosses, crossings(&segments) > 0),
            (Flaw::Touches, self.rings.iter().flatten().any(|p| touches(*p))),
            (Flaw::Misnested, !self.rings.iter().enumerate().skip(1).all(is_nested)),
        ] {
            if is_there {
                flaws.push(flaw);
            }
        }
        flaws
    }
}

fn edges(ring: &[Point]) -> impl Iterator<Item = [Point; 2]> {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| [*a, *b])
}

/// A flaw of a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flaw {
    /// A ring has no area.
    Flat,
    /// Edges cross each other.
    Crosses,
    /// A vertex is on another vertex or on an edge.
    Touches,
    /// A hole is outside of the outer ring, or in a hole.
    Misnested,
}

/// Returns the area of a ring, negative if it is clockwise.
pub(crate) fn area(ring: &[Point]) -> f64 {
    let Some((&o, rest)) = ring.split_first() else {
        return 0.0;
    };
    let doubled = rest.windows(2).map(|pair| {
        let [a, b] = [pair[0], pair[1]];
        (a.x - o.x) * (b.y - o.y) - (b.x - o.x) * (a.y - o.y)
    });
    doubled.sum::<f64>() / 2.0
}

/// Returns the number of pairs of segments that cross, by brute force.
pub(crate) fn crossings(segments: &[[Point; 2]]) -> u64 {
    let low = |s: &[Point; 2]| (s[0].x.min(s[1].x), s[0].y.min(s[1].y));
    let high = |s: &[Point; 2]| (s[0].x.max(s[1].x), s[0].y.max(s[1].y));
    let mut count = 0;
    for (i, one) in segments.iter().enumerate() {
        let ((x0, y0), (x1, y1)) = (low(one), high(one));
        count += segments[i + 1..]
            .iter()
            .filter(|other| {
                let (from, to) = (low(other), high(other));
                from.0 <= x1 && from.1 <= y1 && to.0 >= x0 && to.1 >= y0
            })
            .filter(|other| segments_cross(one[0], one[1], other[0], other[1]))
            .count() as u64;
    }
    count
}

fn lies_on(p: Point, a: Point, b: Point) -> bool {
    let between = |p: f64, a: f64, b: f64| a.min(b) <= p && p <= a.max(b);
    between(p.x, a.x, b.x) && between(p.y, a.y, b.y) && orient2d(a, b, p) == Orientation::Collinear
}

/// Returns the winding number of segments around a point, counter-clockwise.
pub(crate) fn winding(segments: &[[Point; 2]], p: Point) -> i32 {
    let mut winding = 0;
    for &[from, to] in segments {
        if (from.y <= p.y) != (to.y <= p.y) {
            match (from.y <= p.y, orient2d(from, to, p)) {
                (true, Orientation::CounterClockwise) => winding += 1,
                (false, Orientation::Clockwise) => winding -= 1,
                _ => {}
            }
        }
    }
    winding
}

/// Returns the polygons of a FeatureCollection of polygons.
pub(crate) fn polygons_of(path: &Path) -> Vec<Polygon> {
    let mut document: Value = serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    let features = document["features"].as_array_mut().unwrap();
    let polygon = |feature: &mut Value| {
        assert_eq!(feature["geometry"]["type"], "Polygon");
        let rings: Vec<Vec<[f64; 2]>> = serde_json::from_value(feature["geometry"]["coordinates"].take()).unwrap();
        Polygon::new(&rings)
    };
    features.iter_mut().map(polygon).collect()
}
