//! Binary search finds what a search of all half-edges finds.

use proptest::prelude::*;

use super::*;
use crate::geometry::{PackedHalfEdge, Rect};
use crate::mesh::EngineKind;

/// Returns points around a center, their mesh without every `gone`-th triangle, and the center's
/// index. If `gone` is 0, no triangle is missing.
fn wheel(spokes: &[(i32, i32)], center: (i32, i32), gone: u32) -> (Vec<Point>, Constrained, u32) {
    let point = |&(x, y): &(i32, i32)| Point::new(f64::from(x), f64::from(y));
    let mut points: Vec<Point> = spokes.iter().chain([&center]).map(point).collect();
    points.sort_by(|a, b| a.lex_cmp(*b));
    points.dedup();
    let middle = points.iter().position(|&p| p == point(&center)).unwrap() as u32;
    let mut mesh = Triangulation::default();
    EngineKind::Native.create().triangulate(&points, &mut mesh);
    let triangles = (0u32..)
        .zip(&mesh.triangles)
        .filter(|(index, _)| gone == 0 || index % gone != 0);
    let triangles: Vec<[u32; 3]> = triangles.map(|(_, corners)| *corners).collect();
    let ends = |edge: usize| [triangles[edge / 3][edge % 3], triangles[edge / 3][(edge + 1) % 3]];
    let mut neighbours = vec![[PackedHalfEdge::NONE; 3]; triangles.len()];
    for (a, b) in (0..3 * triangles.len()).flat_map(|a| (0..3 * triangles.len()).map(move |b| (a, b))) {
        let [from, to] = ends(a);
        if ends(b) == [to, from] {
            neighbours[a / 3][a % 3] = HalfEdge(b as u32).into();
        }
    }
    let count = triangles.len();
    let mesh = Triangulation {
        triangles,
        neighbours,
        hull: Vec::new(),
    };
    let mesh = Constrained::with_constraints(mesh, vec![0; count], points.len());
    (points, mesh, middle)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn binary_search_finds_what_a_search_of_the_whole_star_finds(
        spokes in prop::collection::vec((-9i32..10, -9i32..10), 3..60),
        center in (-3i32..4, -3i32..4),
        gone in 0u32..4,
        targets in prop::collection::vec((-30i32..31, -30i32..31), 1..60),
    ) {
        let (points, mesh, _) = wheel(&spokes, center, gone);
        prop_assume!(!mesh.mesh().triangles.is_empty());
        let bounds = Rect::around(points.iter().copied());
        let targets = targets.iter().map(|&(x, y)| Point::new(f64::from(x) / 2.0, f64::from(y) / 2.0));
        for to in targets.chain(points.iter().copied()).chain([Point::new(bounds.max_x, bounds.min_y)]) {
            for vertex in (0..points.len() as u32).filter(|&v| points[v as usize] != to) {
                let mut search = LeavingSearch::new(&mesh, vertex, to);
                let around = std::iter::from_fn(|| search.next(&points)).find_map(|start| start);
                let mut stars = Stars::default();
                stars.0.insert(vertex, sorted_star(&points, &mesh, vertex));
                let sorted = stars.start(&points, &mesh, vertex, to);
                // A line along an edge may be found from either side of it.
                let end = |start: Option<Leaving>| start.map(|start| match start {
                    Leaving::Edge(_, vertex) => Ok(vertex),
                    Leaving::Triangle(edge) => Err(edge),
                });
                prop_assert_eq!(end(sorted), end(around), "{} {:?}", vertex, to);
            }
        }
    }
}
