//! Distance matrices: each pair has the distance of a search between its two points alone.

use std::time::Duration;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{DistanceOutcome, PairDistance, PathOutcome, QueryError, QueryOptions};
use delaunay_tiles::store::TileReader;
use futures::{StreamExt, TryStreamExt};

use crate::proximity::scene::{Scene, at, block, wall};
use crate::proximity::{Walk, same};
use crate::support::oracle::Oracle;
use crate::support::{Random, runtime};

/// Blocks, a closed wall with room in it, and a wall.
fn scene() -> Scene {
    let lines = vec![
        block([1, 1], [3, 2]),
        block([4, 3], [2, 2]),
        wall(&[(6, 6), (9, 6), (9, 9), (6, 9), (6, 6)]),
        wall(&[(2, 5), (2, 9), (5, 9)]),
    ];
    Scene::on_grid(11, 11, lines)
}

/// Returns some points, two of them equal, in the scene, and others on vertices, in obstacles and
/// outside.
fn points(scene: &Scene, random: &mut Random, count: usize) -> Vec<Point> {
    let mut points = scene.targets(random, count);
    points.extend([
        at(0, 0),
        at(0, 0),
        Point::new(2.5, 2.0),
        at(7, 7),
        Point::new(-3.0, 4.0),
    ]);
    points
}

async fn matrix(reader: &TileReader, from: &[Point], to: &[Point]) -> Vec<PairDistance> {
    let pairs = reader.distance_matrix(from.to_vec(), to.to_vec(), QueryOptions::default());
    pairs.try_collect().await.unwrap()
}

fn as_walk(outcome: DistanceOutcome) -> Walk {
    match outcome {
        DistanceOutcome::Found(distance) => {
            assert!(distance.lower <= distance.value && distance.value <= distance.upper);
            Walk::Length(distance.value)
        }
        DistanceOutcome::Unreachable => Walk::Unreachable,
        DistanceOutcome::InsideObstacle { .. } => Walk::Inside,
        DistanceOutcome::OutOfBudget { lower_bound } => panic!("there is no budget to leave: {lower_bound}"),
    }
}

#[test]
fn every_pair_agrees_with_the_oracle_in_the_promised_order() {
    let scene = scene();
    let points = points(&scene, &mut Random(3), 24);
    runtime().block_on(async {
        for tile_vertices in [5, 1 << 16] {
            let (_scratch, reader) = scene.build(tile_vertices).await;
            let oracle = Oracle::read(&reader).await;
            for split in [4, points.len() - 4] {
                let (from, to) = points.split_at(split);
                let pairs = matrix(&reader, from, to).await;
                let order: Vec<_> = pairs.iter().map(|pair| (pair.from_index, pair.to_index)).collect();
                let (rows, columns) = (0..from.len(), 0..to.len());
                let expected: Vec<_> = if from.len() <= to.len() {
                    rows.flat_map(|i| columns.clone().map(move |j| (i, j))).collect()
                } else {
                    columns.flat_map(|j| rows.clone().map(move |i| (i, j))).collect()
                };
                assert_eq!(order, expected);
                let truth: Vec<_> = from.iter().map(|&from| oracle.walks(from, to)).collect();
                for pair in pairs {
                    let (found, expected) = (as_walk(pair.outcome), truth[pair.from_index][pair.to_index]);
                    assert!(same(found, expected), "{pair:?}, not {expected:?}");
                }
            }
        }
    });
}

/// The matrix of a list with itself is mirrored, whatever its points are.
#[test]
fn a_matrix_of_a_list_with_itself_is_symmetric_and_agrees_with_the_oracle() {
    let scene = scene();
    let points = points(&scene, &mut Random(8), 30);
    runtime().block_on(async {
        for tile_vertices in [5, 1 << 16] {
            let (_scratch, reader) = scene.build(tile_vertices).await;
            let oracle = Oracle::read(&reader).await;
            let pairs = matrix(&reader, &points, &points).await;
            assert_eq!(pairs.len(), points.len() * points.len());
            for (index, pair) in pairs.iter().enumerate() {
                let [from, to] = [index / points.len(), index % points.len()];
                assert_eq!([pair.from_index, pair.to_index], [from, to]);
                let mirrored = pairs[to * points.len() + from].outcome;
                let is_inside = matches!(mirrored, DistanceOutcome::InsideObstacle { .. });
                assert!(pair.outcome == mirrored || is_inside, "{pair:?} {mirrored:?}");
            }
            for (from, row) in pairs.chunks(points.len()).enumerate() {
                let expected = oracle.walks(points[from], &points);
                for (pair, expected) in row.iter().zip(expected) {
                    assert!(same(as_walk(pair.outcome), expected), "{pair:?}, not {expected:?}");
                }
            }
        }
    });
}

/// With paths, rows come from the first list, however long it is. Each path is that of a search for
/// it alone.
#[test]
fn paths_of_pairs_equal_those_of_separate_searches() {
    let scene = scene();
    let points = scene.targets(&mut Random(4), 9);
    runtime().block_on(async {
        let (_scratch, reader) = scene.build(7).await;
        let (from, to) = points.split_at(6);
        let options = QueryOptions::default().certified();
        let pairs = reader.distance_matrix(from.to_vec(), to.to_vec(), options.clone());
        let pairs: Vec<_> = pairs.try_collect().await.unwrap();
        let mut found = 0;
        for (pair, index) in pairs.into_iter().zip(0..) {
            assert_eq!([pair.from_index, pair.to_index], [index / 3, index % 3]);
            let alone = reader.shortest_path(from[pair.from_index], to[pair.to_index], options.clone());
            let (DistanceOutcome::Found(distance), PathOutcome::Found(alone)) = (pair.outcome, alone.await.unwrap())
            else {
                assert_eq!(pair.path, None);
                continue;
            };
            let path = pair.path.unwrap();
            assert!(path.is_certified && path.distance.value == distance.value);
            let ends = [path.points[0], path.points[path.points.len() - 1]];
            assert_eq!(ends, [from[pair.from_index], to[pair.to_index]]);
            assert!((distance.value - alone.distance.value).abs() <= 1e-12 * distance.value);
            found += 1;
        }
        assert!(found > 6);
    });
}

/// If both ends are in obstacles, the first is named, whichever of them the search started from.
#[test]
fn the_first_end_in_an_obstacle_is_named() {
    let inside = [Point::new(2.0, 2.25), Point::new(5.0, 4.5)];
    runtime().block_on(async {
        let (_scratch, reader) = scene().build(9).await;
        let free = [at(0, 0), at(0, 9), at(10, 10)];
        let named = |pairs: Vec<PairDistance>| -> Vec<(Point, Option<Point>)> {
            let point = |pair: PairDistance| match pair.outcome {
                DistanceOutcome::InsideObstacle { point, nearest_free } => (point, nearest_free),
                other => panic!("{other:?}"),
            };
            pairs.into_iter().map(point).collect()
        };
        let nearest = [(inside[0], Some(Point::new(2.0, 3.0))), (inside[1], Some(at(5, 5)))];
        assert_eq!(named(matrix(&reader, &inside[..1], &free).await), [nearest[0]; 3]);
        assert_eq!(named(matrix(&reader, &free, &inside[..1]).await), [nearest[0]; 3]);
        assert_eq!(named(matrix(&reader, &inside[..1], &inside[1..]).await), [nearest[0]]);
        assert_eq!(
            named(matrix(&reader, &inside, &inside[1..]).await),
            [nearest[0], nearest[1]]
        );
    });
}

#[test]
fn empty_lists_invalid_points_and_budgets_give_partial_matrices_or_errors() {
    runtime().block_on(async {
        let (_scratch, reader) = scene().build(9).await;
        assert_eq!(matrix(&reader, &[], &[at(1, 1)]).await, []);
        assert_eq!(matrix(&reader, &[at(1, 1)], &[]).await, []);
        let bad = vec![at(0, 0), Point::new(0.0, f64::NAN)];
        let mut pairs = reader.distance_matrix(vec![at(0, 0)], bad, QueryOptions::default());
        assert!(matches!(pairs.next().await, Some(Err(QueryError::NotAPoint { .. }))));
        assert!(pairs.next().await.is_none());

        let (from, to) = (vec![at(0, 0), at(10, 0)], vec![at(0, 1), at(10, 1), at(3, 8)]);
        let whole = matrix(&reader, &from, &to).await;
        for options in [
            QueryOptions::default().max_tiles(0),
            QueryOptions::default().max_tiles(2),
            QueryOptions::default().max_time(Duration::ZERO),
        ] {
            let pairs = reader.distance_matrix(from.clone(), to.clone(), options);
            let pairs: Vec<_> = pairs.try_collect().await.unwrap();
            let mut stopped = 0;
            for (pair, whole) in pairs.iter().zip(&whole) {
                let DistanceOutcome::Found(truth) = whole.outcome else {
                    panic!("{whole:?}")
                };
                match pair.outcome {
                    DistanceOutcome::OutOfBudget { lower_bound } => {
                        stopped += 1;
                        assert!(lower_bound <= truth.value);
                    }
                    found => assert_eq!(found, whole.outcome),
                }
            }
            assert!(stopped > 0 && pairs.len() == 6);
        }
    });
}
