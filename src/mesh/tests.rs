//! Compares the engines with brute force and with each other.

use proptest::prelude::*;

use super::triangulation::smallest_first;
use super::*;
use crate::geometry::{Orientation, Point, in_circle, orient2d};

/// Returns the triangles, each from its smallest corner on, sorted.
pub(super) fn sorted_triangles(mesh: &Triangulation) -> Vec<[u32; 3]> {
    let mut triangles: Vec<_> = mesh.triangles.iter().map(|&t| smallest_first(t)).collect();
    triangles.sort_unstable();
    triangles
}

/// Returns every counter-clockwise triple whose circle is empty by the tie rule.
fn brute_force(points: &[Point]) -> Vec<[u32; 3]> {
    let n = points.len() as u32;
    let p = |i: u32| points[i as usize];
    let mut triangles = Vec::new();
    for a in 0..n {
        for b in a + 1..n {
            for c in (a + 1..n).filter(|&c| c != b) {
                let empty = || {
                    (0..n)
                        .filter(|v| ![a, b, c].contains(v))
                        .all(|v| !in_circle(p(a), p(b), p(c), p(v)))
                };
                if orient2d(p(a), p(b), p(c)) == Orientation::CounterClockwise && empty() {
                    triangles.push([a, b, c]);
                }
            }
        }
    }
    triangles.sort_unstable();
    triangles
}

/// Checks that twins are mutual and run along the same edge, and that the hull consists of the
/// half-edges without a twin, in order.
pub(super) fn check_topology(points: &[Point], mesh: &Triangulation) {
    assert_eq!(mesh.triangles.len(), mesh.neighbours.len());
    let mut hull_edges = std::collections::HashMap::new();
    for edge in mesh.half_edges() {
        let (from, to) = (mesh.origin(edge).0, mesh.destination(edge).0);
        match mesh.twin(edge) {
            Twin::HalfEdge(twin) => {
                assert_eq!(mesh.twin(twin), Twin::HalfEdge(edge));
                assert_eq!((mesh.origin(twin).0, mesh.destination(twin).0), (to, from));
            }
            hull => {
                assert_eq!(hull, Twin::Hull);
                assert_eq!(hull_edges.insert(from, to), None);
            }
        }
    }
    if mesh.triangles.is_empty() {
        assert_eq!(mesh.hull.len(), points.len());
        return;
    }
    assert_eq!(hull_edges.len(), mesh.hull.len());
    for (i, &v) in mesh.hull.iter().enumerate() {
        assert_eq!(hull_edges[&v], mesh.hull[(i + 1) % mesh.hull.len()]);
    }
    assert_eq!(mesh.triangles.len(), 2 * points.len() - 2 - mesh.hull.len());
}

pub(super) fn distinct(mut points: Vec<Point>) -> Vec<Point> {
    let mut seen = std::collections::HashSet::new();
    points.retain(|p| seen.insert((p.x.to_bits(), p.y.to_bits())));
    points
}

fn check_engines(points: &[Point], expected: Option<Vec<[u32; 3]>>) {
    let mut expected = expected;
    for &kind in EngineKind::ALL {
        let mut mesh = Triangulation::default();
        kind.create().triangulate(points, &mut mesh);
        check_topology(points, &mesh);
        let triangles = sorted_triangles(&mesh);
        match &expected {
            Some(expected) => assert_eq!(&triangles, expected, "{kind}"),
            None => expected = Some(triangles),
        }
    }
}

pub(super) fn on_grid(size: i32, count: usize) -> impl Strategy<Value = Vec<Point>> {
    prop::collection::vec(
        (0..size, 0..size).prop_map(|(x, y)| Point::new(x.into(), y.into())),
        0..count,
    )
    .prop_map(distinct)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn engines_match_brute_force_on_small_grids(points in on_grid(5, 16)) {
        check_engines(&points, Some(brute_force(&points)));
    }

    #[test]
    fn engines_match_brute_force_in_general_position(
        points in prop::collection::vec((-1.0..1.0, -1.0..1.0).prop_map(|(x, y)| Point::new(x, y)), 0..14)
    ) {
        check_engines(&points, Some(brute_force(&points)));
    }

    #[test]
    fn engines_agree_on_larger_grids(points in on_grid(20, 500)) {
        check_engines(&points, None);
    }
}

#[test]
fn engines_agree_on_full_grids_and_lines() {
    for (columns, rows) in [(1, 1), (1, 50), (50, 1), (2, 50), (50, 2), (37, 41)] {
        let grid = |turned: bool| -> Vec<_> {
            (0..columns * rows)
                .map(|i| (f64::from(i % columns), f64::from(i / columns)))
                .map(|(x, y)| {
                    if turned {
                        Point::new(x + y, y - x)
                    } else {
                        Point::new(x, y)
                    }
                })
                .collect()
        };
        check_engines(&grid(false), None);
        check_engines(&grid(true), None);
    }
}

#[test]
fn engines_match_brute_force_on_four_points_in_any_order() {
    // No three are collinear, and no four cocircular.
    let at = |i: u32| {
        let (column, row) = (f64::from(i % 3), f64::from(i / 3));
        Point::new(
            column + 0.1 * row * row,
            row + 0.13 * column - 0.01 * column * column * row,
        )
    };
    let mut shapes = std::collections::HashMap::new();
    for order in 0..9u32.pow(4) {
        let chosen = [order % 9, order / 9 % 9, order / 81 % 9, order / 729];
        let points = distinct(chosen.map(at).to_vec());
        if points.len() == 4 {
            let expected = brute_force(&points);
            *shapes.entry(expected.clone()).or_insert(0) += 1;
            check_engines(&points, Some(expected));
        }
    }
    // Each of the four points inside the triangle of the others, in both directions, and each of the six
    // orders of a quadrilateral, with either diagonal.
    assert_eq!(shapes.len(), 20);
}

#[test]
fn the_kernel_reuses_the_memory_of_the_result() {
    let points: Vec<Point> = (0..100)
        .map(|i| Point::new(f64::from(i % 10), f64::from(i / 10)))
        .collect();
    let mut engine = EngineKind::Native.create();
    let mut mesh = Triangulation::default();
    engine.triangulate(&points, &mut mesh);
    let memory = |mesh: &Triangulation| (mesh.triangles.as_ptr().addr(), mesh.neighbours.as_ptr().addr());
    let before = memory(&mesh);
    engine.triangulate(&points, &mut mesh);
    assert_eq!(memory(&mesh), before);
}
