//! Rings around the whole triangles of an area.

use foldhash::{HashMap, HashMapExt};

use crate::geometry::{Orientation, Point, orient2d};

/// The bits of a point.
pub(super) type PointKey = [u64; 2];

pub(super) fn point_key(p: Point) -> PointKey {
    [p.x, p.y].map(|x| (x + 0.0).to_bits())
}

fn point_of(key: PointKey) -> Point {
    let [x, y] = key.map(f64::from_bits);
    Point::new(x, y)
}

/// The rings around the whole triangles of an [`AreaCover`](super::AreaCover).
///
/// The whole triangles are on the left of each ring. The points are vertices, no ring has a point
/// twice, and the first point is not repeated at the end. Rings may touch at points.
///
/// The area is the union of the outlines, with the nonzero winding rule, and the pieces, without
/// the holes.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AreaRings {
    /// The rings around the area, and around holes that pieces may fill in part.
    pub outlines: Vec<Vec<Point>>,
    /// The rings around holes that have no part of the area in them. They meet neither pieces nor
    /// outlines, except those of other holes, and lie in the union. Each is clockwise.
    pub holes: Vec<Vec<Point>>,
}

impl AreaRings {
    /// Takes the rings, each as an outline or as a hole.
    pub(super) fn new(rings: &[Vec<PointKey>], is_hole: impl Fn(&[PointKey]) -> bool) -> Self {
        let mut this = Self::default();
        for ring in rings {
            let list = match is_hole(ring) {
                true => &mut this.holes,
                false => &mut this.outlines,
            };
            list.push(ring.iter().copied().map(point_of).collect());
        }
        this
    }
}

/// Returns whether a ring is clockwise. It does not cross itself.
pub(super) fn is_clockwise(ring: &[PointKey]) -> bool {
    let at = |index: usize| point_of(ring[index % ring.len()]);
    // The ring is convex at its least point.
    let least = (0..ring.len()).min_by(|&a, &b| at(a).lex_cmp(at(b)));
    least.is_some_and(|least| {
        let [before, after] = [least + ring.len() - 1, least + 1].map(at);
        orient2d(before, at(least), after) == Orientation::Clockwise
    })
}

/// Returns the rings of sorted edges. At each point, as many edges end as begin.
pub(super) fn rings_of(edges: &[[PointKey; 2]]) -> Vec<Vec<PointKey>> {
    let mut is_used = vec![false; edges.len()];
    let mut rings = Vec::new();
    // The points of a walk along unused edges, and where each of them is in it.
    let mut walk: Vec<PointKey> = Vec::new();
    let mut places: HashMap<PointKey, usize> = HashMap::new();
    for first in 0..edges.len() {
        let mut next = Some(first);
        while let Some(edge) = next.filter(|&edge| !is_used[edge]) {
            is_used[edge] = true;
            let [from, to] = edges[edge];
            places.insert(from, walk.len());
            walk.push(from);
            if let Some(&start) = places.get(&to) {
                let ring = walk.split_off(start);
                ring.iter().for_each(|key| {
                    places.remove(key);
                });
                rings.push(ring);
            }
            let leaving = edges.partition_point(|edge| edge[0] < to)..edges.len();
            let mut leaving = leaving.take_while(|&edge| edges[edge][0] == to);
            next = leaving.find(|&edge| !is_used[edge]);
        }
    }
    rings
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(x: u32, y: u32) -> PointKey {
        [x, y].map(|x| f64::from(x).to_bits())
    }

    #[test]
    fn rings_that_touch_are_apart() {
        // Two squares with a common corner.
        let squares = [[(0, 0), (1, 0), (1, 1), (0, 1)], [(1, 1), (2, 1), (2, 2), (1, 2)]];
        let edges = squares
            .iter()
            .flat_map(|square| (0..4).map(|i| [square[i], square[(i + 1) % 4]]));
        let mut edges: Vec<[PointKey; 2]> = edges.map(|ends| ends.map(|(x, y)| key(x, y))).collect();
        edges.sort_unstable();
        let mut rings = rings_of(&edges);
        assert_eq!(rings.len(), 2);
        assert!(rings.iter().all(|ring| ring.len() == 4 && !is_clockwise(ring)));
        rings.iter_mut().for_each(|ring| ring.reverse());
        assert!(rings.iter().all(|ring| is_clockwise(ring)));
    }
}
