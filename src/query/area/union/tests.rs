//! Unions of random rings, compared with winding numbers of points.

use proptest::collection::vec;
use proptest::prelude::*;

use super::*;
use crate::geometry::{Orientation, orient2d};

type Corner = [i8; 2];

fn point([x, y]: Corner) -> Point {
    Point::new(f64::from(x), f64::from(y))
}

fn edges_of<'a>(rings: impl IntoIterator<Item = &'a [Point]>) -> Vec<[Point; 2]> {
    let edges = |ring: &'a [Point]| ring.iter().copied().zip(ring.iter().copied().cycle().skip(1));
    rings.into_iter().flat_map(edges).map(|(a, b)| [a, b]).collect()
}

/// Returns how often edges go round a point that is on none of them.
fn winding(edges: &[[Point; 2]], p: Point) -> i32 {
    let crossed = edges.iter().map(|&[a, b]| match [a.y <= p.y, b.y <= p.y] {
        [true, false] if orient2d(a, b, p) == Orientation::CounterClockwise => 1,
        [false, true] if orient2d(a, b, p) == Orientation::Clockwise => -1,
        _ => 0,
    });
    crossed.sum()
}

/// Returns whether an end of an edge is within the other one, or both cross.
fn meet_within([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let is_within = |p: Point, [a, b]: [Point; 2]| {
        let (low, high) = if a.lex_cmp(b).is_lt() { (a, b) } else { (b, a) };
        orient2d(a, b, p) == Orientation::Collinear && low.lex_cmp(p).is_lt() && p.lex_cmp(high).is_lt()
    };
    let are_apart = |[a, b]: [Point; 2], ends: [Point; 2]| {
        let [c, d] = ends.map(|p| orient2d(a, b, p));
        c != d && c != Orientation::Collinear && d != Orientation::Collinear
    };
    [c, d].into_iter().any(|p| is_within(p, [a, b]))
        || [a, b].into_iter().any(|p| is_within(p, [c, d]))
        || (are_apart([a, b], [c, d]) && are_apart([c, d], [a, b]))
}

fn distance_to(p: Point, [a, b]: [Point; 2]) -> f64 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let along = (((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
    (p.x - a.x - along * dx).hypot(p.y - a.y - along * dy)
}

/// Checks that polygons are valid: edges meet at their ends only, each hole is in its outline, and no
/// ring has a point twice.
fn check_polygons(polygons: &[AreaPolygon]) {
    let edges = edges_of(polygons.iter().flat_map(AreaPolygon::rings));
    for (index, &edge) in edges.iter().enumerate() {
        assert!(
            edges[..index]
                .iter()
                .all(|&other| !meet_within(edge, other) && edge != other),
            "{edge:?}"
        );
    }
    for polygon in polygons {
        assert!(polygon.area() > 0.0);
        for ring in polygon.rings() {
            let mut points = ring.to_vec();
            points.sort_by(|a, b| a.lex_cmp(*b));
            points.dedup();
            assert_eq!(points.len(), ring.len());
        }
        let outline = edges_of([polygon.outline.as_slice()]);
        for hole in &polygon.holes {
            assert!(is_clockwise(hole));
            let corners = hole.iter().filter(|&&p| !polygon.outline.contains(&p));
            assert!(corners.clone().all(|&p| winding(&outline, p) == 1));
            assert!(corners.count() > 0);
        }
    }
}

/// A triangle, counter-clockwise.
fn triangle() -> impl Strategy<Value = Vec<Point>> {
    let corner = || [-20..20i8, -20..20i8];
    [corner(), corner(), corner()].prop_map(|corners| {
        let [a, b, c] = corners.map(point);
        match orient2d(a, b, c) {
            Orientation::Clockwise => vec![a, c, b],
            _ => vec![a, b, c],
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(7), ..ProptestConfig::default() })]

    /// On a grid as coarse as the corners, crossings are moved by up to 0.71, and edges with them.
    #[test]
    fn snapped_edges_meet_at_their_ends_and_stay_near(rings in vec(triangle(), 1..14)) {
        let edges = snap(rings.iter().map(Vec::as_slice), 1.0);
        let ends: Vec<_> = edges.iter().map(|edge| [edge.low, edge.high]).collect();
        for (index, &edge) in ends.iter().enumerate() {
            prop_assert!(ends[..index].iter().all(|&other| !meet_within(edge, other) && edge != other), "{edge:?}");
        }
        let polygons = polygons(boundary(&rings, 1.0), vec![]);
        check_polygons(&polygons);
        let before = edges_of(rings.iter().map(Vec::as_slice));
        let after = edges_of(polygons.iter().flat_map(AreaPolygon::rings));
        for x in -21..21i8 {
            for y in -21..21i8 {
                let p = Point::new(f64::from(x) + 0.4, f64::from(y) + 0.3);
                if before.iter().filter(|[a, b]| a != b).all(|&edge| distance_to(p, edge) > 0.75) {
                    prop_assert_eq!(winding(&after, p), i32::from(winding(&before, p) > 0), "{:?}", p);
                }
            }
        }
    }

    /// On the grid that is used, only points next to edges change sides.
    #[test]
    fn unions_have_the_points_of_their_rings(rings in vec(triangle(), 1..20), scale in 0..3usize) {
        let [scale, offset] = [[1.0, 0.0], [1e-3, 5e6], [1e6, -1e3]][scale];
        let place = |p: &Point| Point::new(offset + scale * p.x, offset - scale * p.y);
        let rings: Vec<Vec<Point>> = rings.iter().map(|ring| ring.iter().rev().map(place).collect()).collect();
        let polygons = united(rings.clone(), vec![], vec![], 1e-8 * scale);
        check_polygons(&polygons);
        let before = edges_of(rings.iter().map(Vec::as_slice));
        let after = edges_of(polygons.iter().flat_map(AreaPolygon::rings));
        for x in -21..21i8 {
            for y in -21..21i8 {
                let p = place(&Point::new(f64::from(x) + 0.437, f64::from(y) + 0.311));
                if before.iter().filter(|[a, b]| a != b).all(|&edge| distance_to(p, edge) > 1e-4 * scale) {
                    prop_assert_eq!(winding(&after, p), i32::from(winding(&before, p) > 0), "{:?}", p);
                }
            }
        }
    }

    /// Unions of rectangles on the grid are exact.
    #[test]
    fn unions_of_rectangles_are_exact(rectangles in vec([0..12i8, 0..12i8, 1..6i8, 1..6i8], 1..25)) {
        let ring = |&[x, y, w, h]: &[i8; 4]| [[x, y], [x + w, y], [x + w, y + h], [x, y + h]].map(point).to_vec();
        let rings: Vec<_> = rectangles.iter().map(ring).collect();
        // All ways to unite them give the same area.
        let few = rings.len() / 3;
        let polygons = united(rings[..few].to_vec(), rings[few..].to_vec(), vec![], 1e-8);
        check_polygons(&polygons);
        let after = edges_of(polygons.iter().flat_map(AreaPolygon::rings));
        let mut cells = 0;
        for (x, y) in (0..18i8).flat_map(|x| (0..18i8).map(move |y| (x, y))) {
            let is_in = rectangles.iter().any(|&[a, b, w, h]| (a..a + w).contains(&x) && (b..b + h).contains(&y));
            cells += i32::from(is_in);
            let centre = Point::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            prop_assert_eq!(winding(&after, centre), i32::from(is_in));
        }
        let area: f64 = polygons.iter().map(AreaPolygon::area).sum();
        prop_assert_eq!(area, f64::from(cells));
        // Corners only are left.
        prop_assert!(after.iter().all(|[a, b]| a.x == b.x || a.y == b.y));
    }
}

fn square(at: f64, size: f64) -> Vec<Point> {
    let corners = [[0.0, 0.0], [size, 0.0], [size, size], [0.0, size]];
    corners.map(|[x, y]| Point::new(at + x, at + y)).to_vec()
}

#[test]
fn holes_go_to_the_outlines_around_them() {
    let hole = |at: f64, size: f64| square(at, size).into_iter().rev().collect::<Vec<_>>();
    // One outline lies in a hole of another one.
    let rings = [square(0.0, 10.0), hole(3.0, 4.0), square(4.0, 2.0)];
    let holes = vec![
        hole(1.0, 0.5),
        hole(5.0, 0.5),
        hole(8.0, 0.5),
        hole(8.5, 0.25),
        hole(1.5, 1.0),
    ];
    let mut found = united(rings.to_vec(), vec![], holes.clone(), 1e-8);
    found.sort_by(|a, b| a.outline[0].lex_cmp(b.outline[0]));
    let [outer, inner] = &found[..] else {
        panic!("{found:?}")
    };
    assert_eq!(inner.holes, [hole(5.0, 0.5)]);
    assert_eq!(outer.holes.len(), 5);
    assert!([0, 2, 3, 4].iter().all(|&number| outer.holes.contains(&holes[number])));
    check_polygons(&found);
    assert_eq!(united(vec![], vec![], vec![hole(1.0, 1.0)], 1e-8), []);
}
