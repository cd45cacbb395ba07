//! Proves constrained triangulations: exactly the subsegments are constraints, and every other edge
//! is locally Delaunay by the tie rule. Only one triangulation has these properties (Lee and Lin
//! 1986, and the tie rule).

use std::collections::BTreeSet;

use proptest::prelude::*;

use super::*;
use crate::geometry::{VertexIndex, in_circle};
use crate::mesh::tests::{check_topology, distinct, on_grid, sorted_triangles};
use crate::mesh::{EngineKind, Triangulation};

fn ordered([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Returns the subsegments between the vertices on a segment, by brute force.
fn subsegments(points: &[Point], [from, to]: [u32; 2]) -> Vec<[u32; 2]> {
    let [a, b] = [from, to].map(|v| points[v as usize]);
    let between = |p: Point| p.lex_cmp(a) != p.lex_cmp(b) || p == a || p == b;
    let on_it = |&(p, _): &(Point, u32)| orient2d(a, b, p) == Orientation::Collinear && between(p);
    let mut on_it: Vec<(Point, u32)> = points.iter().copied().zip(0..).filter(on_it).collect();
    if from == to {
        return Vec::new();
    }
    on_it.sort_by(|p, q| p.0.lex_cmp(q.0));
    on_it.windows(2).map(|pair| ordered([pair[0].1, pair[1].1])).collect()
}

/// Returns whether two subsegments cross in the interior of both.
fn cross(points: &[Point], [a, b]: [u32; 2], [c, d]: [u32; 2]) -> bool {
    let side_of =
        |p: u32, q: u32, r: u32| orient2d(points[p as usize], points[q as usize], points[r as usize]) as i8 - 1;
    side_of(a, b, c) * side_of(a, b, d) < 0 && side_of(c, d, a) * side_of(c, d, b) < 0
}

/// Returns the segments that cross no segment before them, and all their subsegments.
fn without_crossings(points: &[Point], segments: &[[u32; 2]]) -> (Vec<[u32; 2]>, BTreeSet<[u32; 2]>) {
    let mut all = BTreeSet::new();
    let mut kept = Vec::new();
    for &segment in segments {
        let own = subsegments(points, segment);
        if own.iter().all(|&p| all.iter().all(|&q| !cross(points, p, q))) {
            all.extend(own);
            kept.push(segment);
        }
    }
    (kept, all)
}

fn constrained(points: &[Point], segments: &[[u32; 2]]) -> Constrained {
    let mut mesh = Triangulation::default();
    EngineKind::Native.create().triangulate(points, &mut mesh);
    let mut mesh = Constrained::new(mesh, points.len());
    let mut inserter = Inserter::default();
    for &segment in segments {
        inserter.insert(points, &mut mesh, segment).unwrap();
    }
    mesh
}

fn constraints(mesh: &Constrained) -> BTreeSet<[u32; 2]> {
    let edges: Vec<_> = mesh.constraints().map(ordered).collect();
    let set: BTreeSet<_> = edges.iter().copied().collect();
    assert_eq!(set.len(), edges.len(), "an edge came twice");
    set
}

/// Proves that `mesh` is the triangulation of `points` that is constrained by `subsegments`.
fn prove(points: &[Point], mesh: &Constrained, subsegments: &BTreeSet<[u32; 2]>) {
    let topology = mesh.mesh();
    check_topology(points, topology);
    let point = |v: VertexIndex| points[v.index()];
    for edge in topology.half_edges() {
        let [a, b, c] = [edge, edge.next(), edge.prev()].map(|s| point(topology.origin(s)));
        assert_eq!(orient2d(a, b, c), Orientation::CounterClockwise);
        let Some(twin) = topology.twin(edge).half_edge() else {
            continue;
        };
        assert_eq!(mesh.is_constraint(edge), mesh.is_constraint(twin));
        if !mesh.is_constraint(edge) {
            let d = point(topology.apex(twin));
            assert!(!in_circle(a, b, c, d), "an edge is not locally Delaunay");
        }
    }
    assert_eq!(&constraints(mesh), subsegments);
}

/// Proves the triangulation with `segments`, and that it does not depend on their order and
/// direction.
fn check(points: &[Point], segments: &[[u32; 2]]) {
    let (kept, expected) = without_crossings(points, segments);
    let mesh = constrained(points, &kept);
    prove(points, &mesh, &expected);
    let turned: Vec<_> = kept.iter().rev().map(|&[a, b]| [b, a]).collect();
    let other = constrained(points, &turned);
    assert_eq!(sorted_triangles(mesh.mesh()), sorted_triangles(other.mesh()));
    assert_eq!(constraints(&other), expected);
}

fn with_segments(
    points: impl Strategy<Value = Vec<Point>>,
    count: usize,
) -> impl Strategy<Value = (Vec<Point>, Vec<[u32; 2]>)> {
    points.prop_flat_map(move |points| {
        let n = points.len().max(1) as u32;
        let segments = prop::collection::vec((0..n, 0..n).prop_map(|(a, b)| [a, b]), 0..count);
        let empty = points.is_empty();
        (Just(points), segments).prop_map(move |(points, segments)| (points, if empty { Vec::new() } else { segments }))
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn segments_on_small_grids_become_constraints((points, segments) in with_segments(on_grid(5, 20), 20)) {
        check(&points, &segments);
    }

    #[test]
    fn segments_on_larger_grids_become_constraints((points, segments) in with_segments(on_grid(14, 90), 60)) {
        check(&points, &segments);
    }

    #[test]
    fn segments_in_general_position_become_constraints((points, segments) in with_segments(
        prop::collection::vec((-1.0..1.0, -1.0..1.0).prop_map(|(x, y)| Point::new(x, y)), 0..60).prop_map(distinct), 40,
    )) {
        check(&points, &segments);
    }

    #[test]
    fn a_crossing_is_an_error((points, segments) in with_segments(on_grid(9, 40), 30)) {
        let (kept, all) = without_crossings(&points, &segments);
        let mut mesh = constrained(&points, &kept);
        let mut inserter = Inserter::default();
        for segment in segments {
            let own = subsegments(&points, segment);
            let crossed = |edge: [u32; 2]| own.iter().any(|&subsegment| cross(&points, subsegment, edge));
            match inserter.insert(&points, &mut mesh, segment) {
                Ok(()) => prop_assert!(!all.iter().any(|&edge| crossed(edge)), "{segment:?}"),
                Err(error) => {
                    prop_assert_eq!(error.segment, segment);
                    prop_assert!(crossed(error.edge), "{:?}", error);
                    // The part that was inserted before the crossing would block later segments.
                    mesh = constrained(&points, &kept);
                }
            }
        }
    }
}

/// Returns a generator of random numbers. Each call returns a number below its argument.
fn random() -> impl FnMut(u32) -> u32 {
    let mut state = 7u64;
    move |n| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) % u64::from(n)) as u32
    }
}

/// Returns `count` random points in a square with the vertices of `lines`, and the segments of the
/// lines.
fn lines_among_points(count: u32, lines: &[Vec<(f64, f64)>]) -> (Vec<Point>, Vec<[u32; 2]>) {
    let mut random = random();
    let mut points: Vec<Point> = (0..count)
        .map(|_| Point::new(f64::from(random(1 << 20)), f64::from(random(1 << 20))))
        .collect();
    let mut segments = Vec::new();
    for line in lines {
        let first = points.len() as u32;
        points.extend(line.iter().map(|&(x, y)| Point::new(x * 1_048_576.0, y * 1_048_576.0)));
        segments.extend((first..points.len() as u32 - 1).map(|v| [v, v + 1]));
    }
    assert_eq!(distinct(points.clone()).len(), points.len());
    (points, segments)
}

/// Long and crooked lines have long cavities.
#[test]
fn stars_spirals_combs_and_long_segments_become_constraints() {
    let turn = |i: u32, n: u32| f64::from(i) / f64::from(n) * std::f64::consts::TAU;
    let star: Vec<Vec<_>> = (0..300)
        .map(|i| turn(i, 300).sin_cos())
        .map(|(s, c)| vec![(0.5 + 0.01 * c, 0.5 + 0.01 * s), (0.5 + 0.49 * c, 0.5 + 0.49 * s)])
        .collect();
    let spiral = (0..400)
        .map(|i| (turn(i, 40), 0.01 + 0.0012 * f64::from(i)))
        .map(|(a, r)| (0.5 + r * a.cos(), 0.5 + r * a.sin()))
        .collect();
    let comb = (0..400)
        .map(|i| {
            (
                0.1 + 0.002 * f64::from(i),
                if i % 2 == 0 {
                    0.05
                } else {
                    0.95 - 0.0001 * f64::from(i % 7)
                },
            )
        })
        .collect();
    let long: Vec<Vec<_>> = (0..200)
        .map(|i| 0.005 * f64::from(i) + 0.001)
        .map(|y| vec![(0.001, y), (0.999, 0.999 * y + 0.0003)])
        .collect();
    for lines in [star, vec![spiral], vec![comb], long] {
        let (points, segments) = lines_among_points(3_000, &lines);
        let expected = segments.iter().map(|&segment| ordered(segment)).collect();
        prove(&points, &constrained(&points, &segments), &expected);
    }
}

/// Thousands of segments end in one vertex. They are inserted in random order.
#[test]
fn ten_thousand_segments_from_one_vertex_become_constraints() {
    let mut random = random();
    let rim = (0..10_000).map(|i| f64::from(i) / 10_000.0 * std::f64::consts::TAU);
    let mut points: Vec<Point> = rim.map(|a| Point::new(a.cos(), a.sin())).collect();
    points.push(Point::new(0.25, 0.125));
    let mut segments: Vec<_> = (0..10_000).map(|i| [i, 10_000]).collect();
    for i in 0..segments.len() {
        let other = random(segments.len() as u32) as usize;
        segments.swap(i, other);
    }
    let expected = segments.iter().map(|&segment| ordered(segment)).collect();
    prove(&points, &constrained(&points, &segments), &expected);
}

/// A cavity of a hundred thousand triangles with cocircular vertices. Choosing one apex after the
/// other would take hours.
#[test]
fn a_diameter_of_a_circle_of_many_points_becomes_a_constraint() {
    let n = 100_000;
    let rim = (0..n).map(|i| f64::from(i) / f64::from(n) * std::f64::consts::TAU);
    let mut points: Vec<Point> = rim.map(|a| Point::new(a.cos(), a.sin())).collect();
    points.extend((1..1_000).map(|i| Point::new(f64::from(i) / 500.0 - 1.0, 0.3 * f64::from(i % 2) - 0.15)));
    let segment = [7, n / 2 + 3];
    prove(
        &points,
        &constrained(&points, &[segment]),
        &subsegments(&points, segment).into_iter().collect(),
    );
}

#[test]
fn segments_between_collinear_points_become_constraints() {
    let points: Vec<Point> = [3, 0, 4, 1, 5, 2]
        .map(|i| Point::new(f64::from(i), f64::from(2 * i)))
        .into();
    let mesh = constrained(&points, &[[0, 3], [3, 3], [2, 0]]);
    assert_eq!(constraints(&mesh), BTreeSet::from([[3, 5], [0, 5], [0, 2]]));
    check(&points[..1], &[[0, 0]]);
}

#[cfg(feature = "spade")]
mod beside_spade {
    use ::spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation as _};

    use super::*;

    /// Returns the triangles of spade's constrained triangulation, with its ties made canonical by
    /// flips.
    fn by_spade(points: &[Point], segments: &[[u32; 2]]) -> Vec<[u32; 3]> {
        let vertices = points.iter().map(|p| Point2::new(p.x, p.y)).collect();
        let edges = segments
            .iter()
            .filter(|s| s[0] != s[1])
            .map(|s| s.map(|v| v as usize))
            .collect();
        let spade = ConstrainedDelaunayTriangulation::<Point2<f64>>::bulk_load_cdt(vertices, edges).unwrap();
        let index = |p: Point2<f64>| points.iter().position(|q| *q == Point::new(p.x, p.y)).unwrap() as u32;
        let faces = spade
            .inner_faces()
            .map(|face| face.vertices().map(|v| index(v.position())));
        let mut triangles: Vec<[u32; 3]> = faces.collect();
        let fixed: BTreeSet<[u32; 2]> = spade
            .undirected_edges()
            .filter(|edge| edge.is_constraint_edge())
            .map(|edge| ordered(edge.vertices().map(|v| index(v.position()))))
            .collect();
        let point = |v: u32| points[v as usize];
        // By brute force: examines any pair of triangles at an edge that is not a constraint.
        'again: loop {
            for t in 0..triangles.len() {
                for s in 0..3 {
                    let [a, b, c] = [0, 1, 2].map(|i| triangles[t][(s + i) % 3]);
                    let twin_in = |u: &[u32; 3]| (0..3).find(|&i| u[i] == b && u[(i + 1) % 3] == a);
                    let Some((u, i)) = triangles.iter().enumerate().find_map(|(n, u)| Some((n, twin_in(u)?))) else {
                        continue;
                    };
                    let d = triangles[u][(i + 2) % 3];
                    if !fixed.contains(&ordered([a, b])) && in_circle(point(a), point(b), point(c), point(d)) {
                        triangles[t] = [d, b, c];
                        triangles[u] = [a, d, c];
                        continue 'again;
                    }
                }
            }
            break;
        }
        triangles.iter_mut().for_each(|t| *t = crate::mesh::smallest_first(*t));
        triangles.sort_unstable();
        triangles
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

        #[test]
        fn spade_gives_the_same_triangles((points, segments) in with_segments(on_grid(12, 60), 40)) {
            let (kept, _) = without_crossings(&points, &segments);
            let mesh = constrained(&points, &kept);
            if !mesh.mesh().triangles.is_empty() {
                prop_assert_eq!(sorted_triangles(mesh.mesh()), by_spade(&points, &kept));
            }
        }
    }
}
