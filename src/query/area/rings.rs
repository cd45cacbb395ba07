//! Rings of edges with an area on their left.

use std::cmp::Ordering;

use foldhash::{HashMap, HashMapExt};

use crate::geometry::{Orientation, Point, orient2d};

/// The bits of a point.
pub(super) type PointKey = [u64; 2];

pub(super) fn point_key(p: Point) -> PointKey {
    [p.x, p.y].map(|x| (x + 0.0).to_bits())
}

pub(super) fn point_of(key: PointKey) -> Point {
    let [x, y] = key.map(f64::from_bits);
    Point::new(x, y)
}

/// Returns the rings of edges whose left sides belong to an area. At each point, as many edges end
/// as begin, and edges meet at their ends only.
///
/// No ring has a point twice, and rings do not cross where they meet.
pub(super) fn rings_of(mut edges: Vec<[Point; 2]>) -> Vec<Vec<Point>> {
    edges.sort_unstable_by(|a, b| a[0].lex_cmp(b[0]).then(a[1].lex_cmp(b[1])));
    let mut is_used = vec![false; edges.len()];
    let mut rings = Vec::new();
    // The points of a walk along unused edges, and where each of them is in it.
    let mut walk: Vec<Point> = Vec::new();
    let mut places: HashMap<PointKey, usize> = HashMap::new();
    for first in 0..edges.len() {
        let mut next = Some(first);
        while let Some(edge) = next.filter(|&edge| !is_used[edge]) {
            is_used[edge] = true;
            let [from, to] = edges[edge];
            places.insert(point_key(from), walk.len());
            walk.push(from);
            if let Some(&start) = places.get(&point_key(to)) {
                let ring = walk.split_off(start);
                ring.iter().for_each(|&point| {
                    places.remove(&point_key(point));
                });
                rings.push(ring);
            }
            let leaving = edges.partition_point(|edge| edge[0].lex_cmp(to).is_lt())..edges.len();
            let leaving = leaving.take_while(|&edge| edges[edge][0] == to);
            // Between the edge that ends here and this one is a corner of the area.
            next = leaving.reduce(|best, edge| {
                let [a, b] = [edge, best].map(|edge| edges[edge][1]);
                if is_earlier(to, from, a, b) { edge } else { best }
            });
        }
    }
    rings
}

/// Returns whether a clockwise turn about `centre` that starts towards `start` meets the direction
/// of `a` before that of `b`.
fn is_earlier(centre: Point, start: Point, a: Point, b: Point) -> bool {
    // The first half of the turn, its middle, and the second half.
    let part = |p: Point| match orient2d(centre, start, p) {
        Orientation::Clockwise => 0,
        Orientation::Collinear => 1,
        Orientation::CounterClockwise => 2,
    };
    match part(a).cmp(&part(b)) {
        Ordering::Equal => orient2d(centre, a, b) == Orientation::Clockwise,
        order => order.is_lt(),
    }
}

/// Returns whether a ring is clockwise. It does not cross itself.
pub(super) fn is_clockwise(ring: &[Point]) -> bool {
    let at = |index: usize| ring[index % ring.len()];
    // The ring is convex at its least point.
    let least = (0..ring.len()).min_by(|&a, &b| at(a).lex_cmp(at(b)));
    least.is_some_and(|least| {
        let [before, after] = [least + ring.len() - 1, least + 1].map(at);
        orient2d(before, at(least), after) == Orientation::Clockwise
    })
}

/// Returns the area of a ring, negative if it is clockwise.
pub(super) fn signed_area(ring: &[Point]) -> f64 {
    // Products of large coordinates are rounded more.
    let Some(&near) = ring.first() else { return 0.0 };
    let next = ring.iter().cycle().skip(1);
    let doubled = ring.iter().zip(next).map(|(a, b)| {
        let [(ax, ay), (bx, by)] = [a, b].map(|p| (p.x - near.x, p.y - near.y));
        ax * by - bx * ay
    });
    0.5 * doubled.sum::<f64>()
}

/// Returns a ring without the points that are at most `slack` away from the line between their
/// neighbours.
pub(super) fn straightened(ring: &[Point], slack: f64) -> Vec<Point> {
    let is_straight = |a: Point, b: Point, c: Point| {
        let (dx, dy) = (c.x - a.x, c.y - a.y);
        let off = (dx * (b.y - a.y) - dy * (b.x - a.x)).abs();
        let along = dx * (b.x - a.x) + dy * (b.y - a.y);
        let square = dx * dx + dy * dy;
        off <= slack * square.sqrt() && (0.0..=square).contains(&along)
    };
    let mut kept = Vec::new();
    for &point in ring {
        while let [.., before, last] = kept[..]
            && is_straight(before, last, point)
        {
            kept.pop();
        }
        kept.push(point);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring<const N: usize>(corners: [[f64; 2]; N]) -> Vec<Point> {
        corners.map(|[x, y]| Point::new(x, y)).to_vec()
    }

    fn edges_of(ring: &[Point]) -> impl Iterator<Item = [Point; 2]> {
        let next = ring.iter().cycle().skip(1);
        ring.iter().zip(next).map(|(&a, &b)| [a, b])
    }

    #[test]
    fn rings_that_touch_are_apart() {
        // Four triangles with a common corner, of which two are opposite of each other.
        let wedges = [
            [1.0, 0.0],
            [1.0, 1.0],
            [0.0, 1.0],
            [-1.0, 0.0],
            [-1.0, -1.0],
            [0.0, -1.0],
        ];
        let wedges: Vec<_> = wedges
            .chunks(2)
            .map(|ends| ring([[0.0, 0.0], ends[0], ends[1]]))
            .collect();
        let edges: Vec<_> = wedges.iter().flat_map(|wedge| edges_of(wedge)).collect();
        let rings = rings_of(edges.clone());
        assert_eq!(rings.len(), 3);
        assert!(rings.iter().all(|ring| !is_clockwise(ring) && signed_area(ring) == 0.5));
        // With the edges turned round, the area is outside of the triangles.
        let rings = rings_of(edges.into_iter().map(|[a, b]| [b, a]).collect());
        assert_eq!(rings.len(), 3);
        assert!(rings.iter().all(|ring| is_clockwise(ring) && signed_area(ring) == -0.5));
    }

    #[test]
    fn a_hole_that_touches_the_outline_is_a_ring_of_its_own() {
        let outline = ring([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]);
        let hole = ring([[0.0, 0.0], [1.0, 2.0], [2.0, 1.0]]);
        let rings = rings_of(edges_of(&outline).chain(edges_of(&hole)).collect());
        let mut areas: Vec<f64> = rings.iter().map(|ring| signed_area(ring)).collect();
        areas.sort_by(f64::total_cmp);
        assert_eq!(areas, [-1.5, 16.0]);
    }

    #[test]
    fn the_area_of_rings_far_from_the_origin_is_exact() {
        let [x, y] = [4_500_123.25, 5_400_321.75];
        let square = ring([[0.0, 0.0], [0.5, 0.0], [0.5, 0.25], [0.0, 0.25]].map(|[u, v]| [x + u, y + v]));
        assert_eq!(signed_area(&square), 0.125);
        let reversed: Vec<_> = square.into_iter().rev().collect();
        assert_eq!(signed_area(&reversed), -0.125);
        assert_eq!(signed_area(&[]), 0.0);
    }

    #[test]
    fn points_on_straight_lines_are_removed() {
        let all = ring([
            [0.0, 0.0],
            [1.0, 1e-10],
            [2.0, 0.0],
            [3.0, 0.0],
            [3.0, 1.0],
            [3.0, 0.5],
            [0.0, 0.5],
        ]);
        let kept = ring([[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [3.0, 0.5], [0.0, 0.5]]);
        assert_eq!(straightened(&all, 1e-8), kept);
        assert_eq!(straightened(&all[..2], 1e-8), all[..2]);
    }
}
