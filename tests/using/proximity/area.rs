//! The area within a walking distance: points in it are that near, and points outside of it are
//! not.

use std::f64::consts::PI;

use delaunay_tiles::geometry::{Orientation, Point, orient2d};
use delaunay_tiles::query::{AreaCover, AreaPiece, AreaPolygon, Explored, QueryError, QueryOptions};
use delaunay_tiles::store::TileReader;
use futures::TryStreamExt;
use proptest::prelude::*;

use crate::proximity::scene::{self, Scene, at, block, open};
use crate::proximity::{Walk, length};
use crate::support::oracle::Oracle;
use crate::support::{Random, runtime};

async fn pieces(reader: &TileReader, from: Point, radius: f64) -> Vec<AreaPiece> {
    let pieces = reader.area_within(from, radius, QueryOptions::default());
    pieces.try_collect().await.unwrap()
}

/// Returns the area of a piece, with its arcs approximated by lines.
fn area(piece: &AreaPiece) -> f64 {
    let outline = piece.outline(1e-7);
    let around = outline.iter().zip(outline.iter().cycle().skip(1));
    let off = |p: &Point| (p.x - piece.root.x, p.y - piece.root.y);
    around
        .map(|(a, b)| {
            let ((ax, ay), (bx, by)) = (off(a), off(b));
            0.5 * (ax * by - ay * bx)
        })
        .sum()
}

/// In a scene without obstacles a search passes each triangle a few times, however many triangles
/// there are: windows that a vertex divided are merged behind it.
#[test]
fn a_scene_without_obstacles_is_traversed_a_few_times() {
    let mut random = Random(6);
    let mut scene = Scene::in_room(10, vec![]);
    let any = |random: &mut Random| Point::new(10.0 * random.unit(), 10.0 * random.unit());
    scene.points.extend((0..6000).map(|_| any(&mut random)));
    runtime().block_on(async {
        for tile_vertices in [500, 1 << 16] {
            let (_scratch, reader) = scene.build(tile_vertices).await;
            let triangles = reader.metadata().triangles;
            let pieces = pieces(&reader, Point::new(2.0, 4.0), 50.0).await;
            let times = pieces.len() as f64 / triangles as f64;
            assert!((1.0..3.0).contains(&times), "{times}");
        }
    });
}

/// Without obstacles the pieces form a disc, inside and outside the hull, and no two of them
/// overlap.
#[test]
fn without_obstacles_the_area_is_a_disc() {
    let mut random = Random(5);
    let mut scene = Scene::in_room(10, vec![]);
    let any = |random: &mut Random| Point::new(10.0 * random.unit(), 10.0 * random.unit());
    scene.points.extend((0..60).map(|_| any(&mut random)));
    runtime().block_on(async {
        for tile_vertices in [5, 1 << 16] {
            let (_scratch, reader) = scene.build(tile_vertices).await;
            let vertex = scene.points[20];
            for from in [
                Point::new(5.0, 5.0),
                Point::new(0.1, 9.0),
                vertex,
                Point::new(3.0, 0.0),
                at(10, 10),
                Point::new(-3.0, 4.0),
                Point::new(40.0, 0.0),
            ] {
                for radius in [0.01, 0.5, 3.0, 25.0] {
                    let pieces = pieces(&reader, from, radius).await;
                    assert!(pieces.iter().all(|piece| piece.reach <= radius));
                    let own = pieces.iter().filter(|piece| piece.root == from);
                    let sum: f64 = own.map(area).sum();
                    let disc = PI * radius * radius;
                    // The hull's shadow is no obstacle, but it is seen from the hull's vertices.
                    let is_whole = (0.0..=10.0).contains(&from.x) && (0.0..=10.0).contains(&from.y);
                    assert!(sum <= disc * (1.0 + 1e-9), "{from:?} {radius}: {sum} of {disc}");
                    assert!(
                        !is_whole || sum >= disc * (1.0 - 1e-5),
                        "{from:?} {radius}: {sum} of {disc}"
                    );
                }
            }
        }
    });
}

/// Returns whether a ray to the right crosses an odd number of the polygons' edges.
fn is_within(polygons: &[AreaPolygon], p: Point) -> bool {
    let rings = polygons.iter().flat_map(AreaPolygon::rings);
    let edges = rings.flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)));
    let crossed = edges.filter(|(a, b)| {
        let (down, up) = if a.y <= b.y { (a, b) } else { (b, a) };
        down.y <= p.y && p.y < up.y && orient2d(**down, **up, p) == Orientation::CounterClockwise
    });
    crossed.count() % 2 == 1
}

/// Compares points all over with their distances, in pieces and in polygons.
async fn check(reader: &TileReader, oracle: &Oracle, from: Point, radius: f64, random: &mut Random) {
    let pieces = pieces(reader, from, radius).await;
    let mut cover = AreaCover::default();
    let covered = reader.cover_area(from, radius, QueryOptions::default(), &mut cover);
    covered.await.unwrap();
    let tolerance = 1e-7;
    let polygons = cover.polygons(tolerance);
    let points: Vec<Point> = (0..60)
        .map(|_| Point::new(16.0 * random.unit() - 3.0, 16.0 * random.unit() - 3.0))
        .collect();
    for (&point, walk) in points.iter().zip(oracle.walks(from, &points)) {
        let is_near = match walk {
            Walk::Length(length) if (length - radius).abs() < 1e-9 * radius => continue,
            Walk::Length(length) => length < radius,
            Walk::Unreachable | Walk::Inside => false,
        };
        let within = pieces.iter().find(|piece| piece.contains(point));
        assert_eq!(
            within.is_some(),
            is_near,
            "{from:?}, {radius}: {point:?} at {walk:?}, {within:?}"
        );
        // Chords are inside of their arcs.
        let is_at_the_rim = matches!(walk, Walk::Length(length) if (length - radius).abs() < tolerance * radius);
        assert!(
            is_at_the_rim || is_within(&polygons, point) == is_near,
            "{from:?}, {radius}: {point:?} at {walk:?}"
        );
    }
}

#[test]
fn areas_in_scenes_by_hand_agree_with_the_oracle() {
    for (name, scene) in scene::by_hand() {
        println!("{name}");
        runtime().block_on(async {
            let mut random = Random(8);
            let (scratch, reader) = scene.build(8).await;
            let oracle = Oracle::read(&reader).await;
            let poor = open(&scratch, 0).await;
            for from in [
                Point::new(4.6, 5.2),
                at(0, 0),
                at(2, 7),
                Point::new(-1.0, 5.5),
                Point::new(10.0, 4.5),
                Point::new(8.5, 11.5),
            ] {
                if oracle.is_free(from) {
                    check(&reader, &oracle, from, 2.5, &mut random).await;
                    check(&poor, &oracle, from, 9.0, &mut random).await;
                }
            }
        });
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn areas_among_random_blocks_and_walls_agree_with_the_oracle(seed in any::<u64>(), is_dense in any::<bool>(), exterior_is_hole in prop::bool::weighted(0.2)) {
        let mut random = Random(seed);
        let mut scene = Scene::few_blocks(&mut random, is_dense);
        scene.exterior_is_hole = exterior_is_hole;
        runtime().block_on(async {
            let (_scratch, reader) = scene.build(9).await;
            let oracle = Oracle::read(&reader).await;
            for radius in [0.5, 2.0, 5.0, 12.0] {
                let from = Point::new(12.0 * random.unit() - 1.0, 12.0 * random.unit() - 1.0);
                if oracle.is_free(from) {
                    check(&reader, &oracle, from, radius, &mut random).await;
                }
            }
        });
    }
}

#[test]
fn extreme_radii_obstacles_and_budgets_give_exact_areas_or_errors() {
    let scene = Scene::on_grid(11, 11, vec![block([2, 2], [3, 3])]);
    runtime().block_on(async {
        let (_scratch, reader) = scene.build(9).await;
        for radius in [0.0, -1.0, f64::NAN] {
            assert_eq!(pieces(&reader, at(1, 1), radius).await, []);
        }
        let whole = pieces(&reader, at(1, 1), f64::INFINITY).await;
        assert!(whole.iter().any(|piece| piece.contains(Point::new(-1e30, 1e25))));
        let error = reader.area_within(Point::new(3.5, 3.5), 1.0, QueryOptions::default());
        let error = error.try_collect::<Vec<_>>().await.unwrap_err();
        assert!(matches!(error, QueryError::InsideObstacle { .. }), "{error}");

        // The pieces that came before the limit are valid.
        let mut limited = reader.area_within(at(1, 1), 8.0, QueryOptions::default().max_tiles(2));
        let all = pieces(&reader, at(1, 1), 8.0).await;
        let mut count = 0;
        let error = loop {
            match limited.try_next().await {
                Ok(Some(piece)) => assert!(all.contains(&piece)),
                Ok(None) => panic!("the limit was not reached"),
                Err(error) => break error,
            }
            count += 1;
        };
        assert!(count > 0 && matches!(error, QueryError::OutOfBudget { .. }), "{error}");

        // So are the polygons.
        let [mut part, mut whole] = [AreaCover::default(), AreaCover::default()];
        let options = QueryOptions::default();
        reader
            .cover_area(at(1, 1), 8.0, options.clone(), &mut whole)
            .await
            .unwrap();
        let limited = reader.cover_area(at(1, 1), 8.0, options.max_tiles(2), &mut part).await;
        assert!(matches!(limited, Err(QueryError::OutOfBudget { .. })));
        let [part, whole] = [part, whole].map(|cover| cover.polygons(1e-6));
        let [small, large] = [&part, &whole].map(|polygons| polygons.iter().map(AreaPolygon::area).sum::<f64>());
        assert!(small > 1.0 && small < 0.9 * large, "{small} of {large}");
        let mut random = Random(4);
        for _ in 0..200 {
            let point = Point::new(9.0 * random.unit(), 9.0 * random.unit());
            assert!(is_within(&whole, point) || !is_within(&part, point), "{point:?}");
        }
    });
}

/// The triangles that a search passes are reported on request, and are those near it.
#[test]
fn explored_triangles_are_those_near_the_path() {
    let scene = Scene::on_grid(21, 21, vec![block([2, 2], [3, 3])]);
    runtime().block_on(async {
        for tile_vertices in [9, 1 << 16] {
            let (_scratch, reader) = scene.build(tile_vertices).await;
            let explored = Explored::default();
            let options = QueryOptions::default().explored(&explored);
            let (from, to) = (Point::new(6.3, 6.4), Point::new(8.2, 6.7));
            reader.shortest_path(from, to, options).await.unwrap();
            let found = explored.triangles();
            let reach = |&p: &Point| length(&[from, p]);
            assert!((3..40).contains(&found.len()), "{}", found.len());
            assert!(found.iter().flatten().all(|corner| reach(corner) < 5.0));
            let sum: f64 = found
                .iter()
                .map(|[a, b, c]| 0.5 * ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)))
                .sum();
            assert_eq!(sum, 0.5 * found.len() as f64);
        }
    });
}
