//! Compares stars and walks with brute force over all half-edges, on whole triangulations, on parts
//! of them, and on contradictory ones.

use proptest::prelude::*;

use super::*;
use crate::geometry::{Orientation, VertexIndex, orient2d};
use crate::mesh::tests::{distinct, on_grid};
use crate::mesh::{EndlessWalk, EngineKind, Mesh, Triangulation, Walk, WalkEnd};

/// A triangulation in which every `gone`-th triangle is elsewhere. If `gone` is 0, none is.
struct PartialMesh<'a> {
    whole: Mesh<'a>,
    gone: u32,
}

impl PartialMesh<'_> {
    fn has(&self, half_edge: HalfEdge) -> bool {
        self.gone == 0 || !(half_edge.triangle().0 + 1).is_multiple_of(self.gone)
    }
}

impl Topology for PartialMesh<'_> {
    fn triangle_count(&self) -> u32 {
        self.whole.triangle_count()
    }

    fn origin(&self, half_edge: HalfEdge) -> VertexIndex {
        self.whole.origin(half_edge)
    }

    fn twin(&self, half_edge: HalfEdge) -> Twin {
        match self.whole.twin(half_edge) {
            Twin::HalfEdge(twin) if !self.has(twin) => Twin::Elsewhere,
            twin => twin,
        }
    }
}

impl Embedded for PartialMesh<'_> {
    fn point(&self, vertex: VertexIndex) -> Point {
        self.whole.point(vertex)
    }
}

fn triangulated(points: &[Point]) -> Triangulation {
    let mut triangulation = Triangulation::default();
    EngineKind::Native.create().triangulate(points, &mut triangulation);
    triangulation
}

/// Returns the half-edge from one vertex to another, found by a search of all half-edges.
fn between(part: &PartialMesh<'_>, from: VertexIndex, to: VertexIndex) -> Option<HalfEdge> {
    let mut all = part.half_edges().filter(|&half_edge| part.has(half_edge));
    all.find(|&half_edge| part.origin(half_edge) == from && part.destination(half_edge) == to)
}

/// Returns the star of `first`, found by end points alone: the next half-edge leads to the apex of
/// the last triangle.
fn star_by_ends(part: &PartialMesh<'_>, first: HalfEdge) -> (Vec<HalfEdge>, StarEnd) {
    let (mut star, centre) = (vec![first], part.origin(first));
    loop {
        let left = part.apex(star[star.len() - 1]);
        let arriving = star[star.len() - 1].prev();
        match between(part, centre, left) {
            Some(next) if next == first => return (star, StarEnd::Closed),
            Some(next) => star.push(next),
            None if between(&PartialMesh { gone: 0, ..*part }, centre, left).is_some() => {
                return (star, StarEnd::Elsewhere(arriving));
            }
            None => return (star, StarEnd::Hull(arriving)),
        }
    }
}

fn check_stars(part: &PartialMesh<'_>) {
    for first in part.half_edges().filter(|&half_edge| part.has(half_edge)) {
        let (expected, end) = star_by_ends(part, first);
        let mut star = part.star(first);
        assert_eq!(star.by_ref().collect::<Vec<_>>(), expected);
        assert_eq!(star.end(), Some(end));

        let (begin, why) = part.rewind(first);
        let (whole, _) = star_by_ends(part, begin);
        assert!(whole.ends_with(&expected[..1]) || whole.contains(&first));
        match why {
            StarEnd::Closed => assert_eq!((begin, end), (first, StarEnd::Closed)),
            StarEnd::Hull(there) => assert_eq!((there, part.twin(there)), (begin, Twin::Hull)),
            StarEnd::Elsewhere(there) => assert_eq!((there, part.twin(there)), (begin, Twin::Elsewhere)),
            StarEnd::Endless => panic!("the star of a triangulation ends"),
        }

        let vertex = part.origin(first);
        let is_whole = !matches!(end, StarEnd::Elsewhere(_)) && !matches!(why, StarEnd::Elsewhere(_));
        for other in (0..part.whole.points.len() as u32).map(VertexIndex) {
            let arriving = between(part, other, vertex).filter(|arriving| whole.contains(&arriving.next()));
            match part.arriving_from(first, |corner| corner == other) {
                Ok(found) => assert!(found == arriving, "{other} to {vertex}"),
                Err(error) => assert!(!is_whole && arriving.is_none() && error == StarError::Incomplete { vertex }),
            }
        }
    }
}

/// Walks to a point from every half-edge, on through triangles that are elsewhere. Compares the end
/// of the walk with the orientations of the point in each triangle.
fn check_walks(part: &PartialMesh<'_>, target: Point) {
    let turn = |half_edge| {
        let [from, to] = [part.origin(half_edge), part.destination(half_edge)].map(|vertex| part.point(vertex));
        orient2d(from, to, target)
    };
    let turns = |triangle| HalfEdge::of_triangle(triangle).map(turn);
    let is_inside = part.triangle_ids().any(|t| !turns(t).contains(&Orientation::Clockwise));
    for mut start in part.half_edges() {
        let mut walk = Walk::new(target, part.triangle_count().into());
        let end = loop {
            match walk.run(part, start).unwrap() {
                WalkEnd::Elsewhere(exit) => {
                    assert!(part.twin(exit) == Twin::Elsewhere && turn(exit) == Orientation::Clockwise);
                    let Twin::HalfEdge(twin) = part.whole.twin(exit) else {
                        panic!("a triangle is there")
                    };
                    start = twin;
                }
                end => break end,
            }
        };
        let collinear = |triangle| {
            let turns = turns(triangle);
            assert!(!turns.contains(&Orientation::Clockwise));
            turns.into_iter().filter(|&turn| turn == Orientation::Collinear).count()
        };
        match end {
            WalkEnd::Triangle(triangle) => assert_eq!(collinear(triangle), 0),
            WalkEnd::Edge(edge) => {
                assert_eq!((turn(edge), collinear(edge.triangle())), (Orientation::Collinear, 1));
            }
            WalkEnd::Vertex(leaving) => assert_eq!(part.point(part.origin(leaving)), target),
            WalkEnd::Hull(exit) => {
                assert_eq!((turn(exit), part.twin(exit)), (Orientation::Clockwise, Twin::Hull));
                assert!(!is_inside);
            }
            WalkEnd::Elsewhere(_) => unreachable!("it went on"),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn stars_agree_with_the_ends_of_half_edges(points in on_grid(6, 24), gone in prop::sample::select(vec![0u32, 2, 3, 5])) {
        let triangulation = triangulated(&points);
        check_stars(&PartialMesh { whole: Mesh { triangulation: &triangulation, points: &points }, gone });
    }

    #[test]
    fn walks_end_where_the_point_lies(
        points in on_grid(6, 24),
        gone in prop::sample::select(vec![0u32, 2, 3]),
        targets in prop::collection::vec((-2i32..14, -2i32..14), 12),
    ) {
        let triangulation = triangulated(&points);
        let part = PartialMesh { whole: Mesh { triangulation: &triangulation, points: &points }, gone };
        for (x, y) in targets {
            check_walks(&part, Point::new(f64::from(x) / 2.0, f64::from(y) / 2.0));
        }
    }

    #[test]
    fn walks_end_in_general_position(
        points in prop::collection::vec((-1.0..1.0, -1.0..1.0).prop_map(|(x, y)| Point::new(x, y)), 0..30).prop_map(distinct),
        targets in prop::collection::vec((-1.2..1.2, -1.2..1.2), 6),
    ) {
        let triangulation = triangulated(&points);
        let part = PartialMesh { whole: Mesh { triangulation: &triangulation, points: &points }, gone: 0 };
        for (x, y) in targets {
            check_walks(&part, Point::new(x, y));
        }
    }
}

/// Two triangles with arbitrary twins.
struct Contradictory([Twin; 6]);

impl Topology for Contradictory {
    fn triangle_count(&self) -> u32 {
        2
    }

    fn origin(&self, half_edge: HalfEdge) -> VertexIndex {
        VertexIndex([0, 1, 2, 0, 1, 2][half_edge.index()])
    }

    fn twin(&self, half_edge: HalfEdge) -> Twin {
        self.0[half_edge.index()]
    }
}

impl Embedded for Contradictory {
    fn point(&self, vertex: VertexIndex) -> Point {
        [Point::new(0.0, 0.0), Point::new(1.0, 0.0), Point::new(0.0, 1.0)][vertex.index()]
    }
}

#[test]
fn stars_and_walks_of_a_contradictory_topology_end() {
    // A walk counter-clockwise from the first triangle stays in the second triangle for ever.
    let to_second = Twin::HalfEdge(HalfEdge(3));
    let contradictory = Contradictory([to_second; 6]);
    let mut star = contradictory.star(HalfEdge(0));
    assert_eq!(star.by_ref().count(), 2);
    assert_eq!(star.end(), Some(StarEnd::Endless));
    assert_eq!(contradictory.rewind(HalfEdge(0)).1, StarEnd::Endless);
    let arriving = contradictory.arriving_from(HalfEdge(0), |_| false);
    assert_eq!(arriving, Err(StarError::Endless { vertex: VertexIndex(0) }));
    let mut walk = Walk::new(Point::new(5.0, 5.0), 2);
    assert_eq!(walk.run(&contradictory, HalfEdge(0)), Err(EndlessWalk));

    // The star reaches the hull in one direction, and goes in circles in the other.
    let mut twins = [Twin::HalfEdge(HalfEdge(5)); 6];
    twins[2] = Twin::Hull;
    let arriving = Contradictory(twins).arriving_from(HalfEdge(0), |_| false);
    assert_eq!(arriving, Err(StarError::Endless { vertex: VertexIndex(0) }));
}
