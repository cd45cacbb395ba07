//! The outcomes of queries without a path, and of queries with budgets.

use std::time::Duration;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{Footing, PathOutcome, QueryError, QueryOptions, Search, SiteFound};
use delaunay_tiles::store::{LineKind, TileReader};
use futures::{FutureExt, StreamExt, TryStreamExt};

use crate::proximity::scene::{Scene, at, block, line, wall};
use crate::proximity::{Walk, is_near, length, walk};
use crate::support::{Random, runtime};

/// Returns the distance of a point from the boundary of a rectangle that contains it.
fn depth(p: Point, [x, y]: [i32; 2], [width, height]: [i32; 2]) -> f64 {
    let gaps = [
        p.x - f64::from(x),
        f64::from(x + width) - p.x,
        p.y - f64::from(y),
        f64::from(y + height) - p.y,
    ];
    gaps.into_iter().fold(f64::INFINITY, f64::min)
}

async fn footing(reader: &TileReader, point: Point) -> Footing {
    reader.footing(point, QueryOptions::default()).await.unwrap()
}

#[test]
fn a_point_in_an_obstacle_gets_the_nearest_free_point() {
    let (corner, size) = ([3, 3], [9, 6]);
    let lines = vec![
        block(corner, size),
        wall(&[(4, 4), (11, 4), (11, 8)]),
        block([5, 5], [2, 2]),
    ];
    let scene = Scene::on_grid(16, 12, lines);
    let mut random = Random(1);
    runtime().block_on(async {
        for tile_vertices in [5, 1 << 16] {
            let (_scratch, reader) = scene.build(tile_vertices).await;
            for i in 0..200 {
                let round = |v: f64| if i % 2 == 0 { v.round() } else { v };
                let p = Point::new(round(3.1 + 8.8 * random.unit()), round(3.1 + 5.8 * random.unit()));
                let deep = depth(p, corner, size);
                let found = footing(&reader, p).await;
                if deep == 0.0 {
                    assert_eq!(found, Footing::Free);
                    continue;
                }
                let Footing::InsideObstacle {
                    nearest_free: Some(free),
                } = found
                else {
                    panic!("{p:?}: {found:?}")
                };
                assert!(is_near(length(&[p, free]), deep), "{p:?}: {free:?}, not {deep} away");
                for (from, to) in [(p, at(0, 0)), (at(0, 0), p), (p, p)] {
                    let outcome = reader.shortest_path(from, to, QueryOptions::default()).await.unwrap();
                    assert_eq!(
                        outcome,
                        PathOutcome::InsideObstacle {
                            point: p,
                            nearest_free: Some(free)
                        }
                    );
                }
                let first = reader.nearest_sites(p, QueryOptions::default()).next().await;
                assert!(
                    matches!(first, Some(Err(QueryError::InsideObstacle { point, .. })) if point == p),
                    "{first:?}"
                );
            }
        }
    });
}

/// On slanted edges, points are rounded.
#[test]
fn the_nearest_free_point_is_free() {
    let diamond = line(LineKind::Obstacle, &[(3, 1), (11, 4), (8, 11), (1, 8), (3, 1)]);
    let room = [(0, 0), (13, 1), (12, 12), (1, 11), (0, 0)];
    let mut scene = Scene::in_room(13, vec![wall(&room), diamond]);
    scene.exterior_is_hole = true;
    let mut random = Random(2);
    runtime().block_on(async {
        let (_scratch, reader) = scene.build(1 << 16).await;
        let mut inside = 0;
        for _ in 0..1000 {
            let p = Point::new(15.0 * random.unit() - 1.0, 15.0 * random.unit() - 1.0);
            let Footing::InsideObstacle { nearest_free } = footing(&reader, p).await else {
                continue;
            };
            let free = nearest_free.unwrap();
            assert_eq!(footing(&reader, free).await, Footing::Free, "{free:?}, beside {p:?}");
            inside += 1;
        }
        assert!(inside > 300, "only {inside} points are in obstacles");
    });
}

/// If the outside is not free, the nearest free point for a point outside is on the hull, or on the
/// far edge of holes at the hull.
#[test]
fn a_point_outside_that_is_not_free_gets_the_nearest_free_point() {
    let mut scene = Scene::in_room(
        10,
        vec![
            wall(&[(0, 0), (10, 0), (10, 10), (0, 10), (0, 0)]),
            block([0, 4], [3, 2]),
        ],
    );
    scene
        .points
        .extend((0..40).map(|i| Point::new(0.21 * f64::from(i) + 0.5, f64::from(i * 7 % 10) + 0.5)));
    scene.exterior_is_hole = true;
    runtime().block_on(async {
        for tile_vertices in [4, 1 << 16] {
            let (_scratch, reader) = scene.build(tile_vertices).await;
            for (p, expected) in [
                (Point::new(-2.0, 1.0), Point::new(0.0, 1.0)),
                (Point::new(-1.0, -1.0), Point::new(0.0, 0.0)),
                (Point::new(4.0, 12.5), Point::new(4.0, 10.0)),
                (Point::new(-0.25, 4.5), Point::new(0.0, 4.0)),
                (Point::new(-9.0, 5.25), Point::new(0.0, 6.0)),
                (Point::new(-0.25, 5.0), Point::new(0.0, 4.0)),
            ] {
                let Footing::InsideObstacle {
                    nearest_free: Some(free),
                } = footing(&reader, p).await
                else {
                    panic!("{p:?} is free")
                };
                assert!(
                    is_near(length(&[p, free]), length(&[p, expected])),
                    "{p:?}: {free:?}, not {expected:?}"
                );
            }
        }
    });
}

#[test]
fn unreachable_equal_invalid_and_collinear_points_give_their_outcomes() {
    let ring = wall(&[(2, 2), (6, 2), (6, 6), (2, 6), (2, 2)]);
    let mut scene = Scene::on_grid(9, 9, vec![ring]);
    scene.sites = vec![at(4, 4), at(0, 0), at(2, 4), at(0, 0), at(8, 8)];
    runtime().block_on(async {
        let (_scratch, reader) = scene.build(9).await;
        assert_eq!(walk(&reader, at(4, 4), at(0, 0)).await, Walk::Unreachable);
        assert_eq!(walk(&reader, at(0, 0), Point::new(4.5, 4.5)).await, Walk::Unreachable);
        for same in [
            at(4, 4),
            Point::new(3.0, 2.0),
            Point::new(0.3, 0.4),
            Point::new(-5.0, 3.0),
            at(8, 8),
        ] {
            assert_eq!(walk(&reader, same, same).await, Walk::Length(0.0));
        }
        let numbers = |radius| {
            let sites = reader.sites_within(at(0, 0), radius, QueryOptions::default());
            sites.map_ok(|site| site.number).try_collect::<Vec<u64>>()
        };
        assert_eq!(numbers(0.0).await.unwrap(), [1, 3]);
        assert_eq!(numbers(20f64.sqrt() + 1e-9).await.unwrap(), [1, 3, 2]);
        // More sites than can be reached are requested: the site within the ring is not returned.
        let all = reader.nearest_sites(at(0, 0), QueryOptions::default()).take(10);
        let all: Vec<u64> = all.map_ok(|site| site.number).try_collect().await.unwrap();
        assert_eq!(all, [1, 3, 2, 4]);

        for point in [
            Point::new(f64::NAN, 0.0),
            Point::new(0.0, f64::INFINITY),
            Point::new(1e300, 0.0),
        ] {
            let error = reader
                .shortest_path(at(0, 0), point, QueryOptions::default())
                .await
                .unwrap_err();
            assert!(matches!(error, QueryError::NotAPoint { .. }), "{error}");
        }
        let line = Scene {
            points: (0..20).map(|i| at(i, i)).collect(),
            ..Scene::default()
        };
        let (_scratch, reader) = line.build(9).await;
        for from in [at(3, 3), at(0, 5), Point::new(3.5, 3.5)] {
            let error = reader
                .shortest_path(from, at(1, 1), QueryOptions::default())
                .await
                .unwrap_err();
            assert!(matches!(error, QueryError::NoTriangles { .. }), "{error}");
        }
    });
}

fn town() -> Scene {
    Scene::town_with_sites(6, 60, &mut Random(9))
}

/// Returns the nearest sites, and the error after them.
async fn until_error(reader: &TileReader, from: Point, options: QueryOptions) -> (Vec<SiteFound>, Option<QueryError>) {
    let mut sites = reader.nearest_sites(from, options);
    let mut found = Vec::new();
    loop {
        match sites.next().await {
            Some(Ok(site)) => found.push(site),
            end => return (found, end.and_then(Result::err)),
        }
    }
}

/// The sites found before the budget's end are valid, and the others are as far away as the error
/// says.
#[test]
fn sites_found_before_a_budget_ended_are_valid() {
    runtime().block_on(async {
        let (_scratch, reader) = town().build(30).await;
        let from = Point::new(0.5, 16.25);
        let whole: Vec<_> = reader
            .nearest_sites(from, QueryOptions::default())
            .try_collect()
            .await
            .unwrap();
        assert_eq!(whole.len(), 60);
        let mut counts = Vec::new();
        for tiles in [0, 1, 2, 4, 8, 16, 1000] {
            let (found, end) = until_error(&reader, from, QueryOptions::default().max_tiles(tiles)).await;
            assert_eq!(found, whole[..found.len()]);
            if tiles < 1000 {
                let Some(QueryError::OutOfBudget { lower_bound }) = end else {
                    panic!("{tiles}: {end:?}")
                };
                assert!(
                    whole[found.len()..]
                        .iter()
                        .all(|site| site.distance.value >= lower_bound)
                );
                assert!(
                    found
                        .last()
                        .is_none_or(|last| last.distance.value <= lower_bound || lower_bound == 0.0)
                );
            } else {
                assert!(end.is_none());
            }
            counts.push(found.len());
        }
        assert!(counts.is_sorted() && counts[0] == 0 && counts[5] > 3, "{counts:?}");

        let mut most = 0;
        for tiles in [0, 1, 2, 4, 8, 16, 1000] {
            let options = QueryOptions::default().first(20).search(Search::Aimed).max_tiles(tiles);
            let (found, end) = until_error(&reader, from, options).await;
            assert_eq!(found, whole[..found.len()]);
            match end {
                None => assert_eq!(found.len(), 20),
                Some(QueryError::OutOfBudget { lower_bound }) => {
                    let rest = &whole[found.len()..];
                    assert!(tiles < 1000 && rest.iter().all(|site| site.distance.value >= lower_bound));
                }
                end => panic!("{tiles}: {end:?}"),
            }
            most = most.max(found.len());
        }
        assert_eq!(most, 20);

        let to = Point::new(31.5, 20.5);
        let path = reader.shortest_path(from, to, QueryOptions::default()).await.unwrap();
        let PathOutcome::Found(path) = path else {
            panic!("{path:?}")
        };
        for options in [
            QueryOptions::default().max_tiles(3),
            QueryOptions::default().max_time(Duration::ZERO),
        ] {
            let error = reader.shortest_path(from, to, options).await.unwrap_err();
            let QueryError::OutOfBudget { lower_bound } = error else {
                panic!("{error}")
            };
            assert!(lower_bound <= path.distance.value);
        }
    });
}

/// Searches that aim and the wavefront find the same sites, at the same distances to the last bit.
#[test]
fn searches_that_aim_find_what_the_wavefront_finds() {
    runtime().block_on(async {
        for (seed, sites) in [(3, 12), (4, 90), (5, 600)] {
            let mut random = Random(seed);
            let scene = Scene::town_with_sites(12, sites, &mut random);
            let (_scratch, reader) = scene.build(400).await;
            for at in scene.targets(&mut random, 40) {
                if reader.footing(at, QueryOptions::default()).await.unwrap() != Footing::Free {
                    continue;
                }
                for count in [1, 3, 10, 40] {
                    let mut answers = Vec::new();
                    for search in [Search::Wavefront, Search::Aimed, Search::Auto] {
                        let options = QueryOptions::default().first(count).search(search);
                        let found: Vec<_> = reader.nearest_sites(at, options).try_collect().await.unwrap();
                        answers.push(found);
                    }
                    assert_eq!(answers[0].len(), count.min(sites));
                    for (one, other) in answers[0].iter().zip(&answers[1]) {
                        let tolerance = 1e-14 * one.distance.value;
                        assert!((one.distance.value - other.distance.value).abs() <= tolerance);
                    }
                    let numbers = |found: &[SiteFound]| found.iter().map(|site| site.number).collect::<Vec<_>>();
                    assert_eq!(numbers(&answers[0]), numbers(&answers[1]), "{at:?} {count}");
                    assert_eq!(numbers(&answers[0]), numbers(&answers[2]), "{at:?} {count}");
                }
            }
        }
    });
}

#[test]
fn concurrent_searches_give_the_same_answers_when_some_are_dropped() {
    runtime().block_on(async {
        let (_scratch, reader) = town().build(30).await;
        let mut random = Random(2);
        let points: Vec<Point> = (0..40)
            .map(|_| Point::new(33.0 * random.unit(), 5.0 * random.below(7) as f64))
            .collect();
        let ask = |reader: TileReader, from: Point| async move {
            let sites = reader.nearest_sites(from, QueryOptions::default()).take(5);
            sites
                .map_ok(|site| (site.number, site.distance.value))
                .try_collect::<Vec<_>>()
                .await
                .unwrap()
        };
        let mut alone = Vec::new();
        for &from in &points {
            alone.push(ask(reader.clone(), from).await);
        }
        // Some are dropped before they have begun, some in the middle.
        for &from in &points {
            let mut dropped = reader.nearest_sites(from, QueryOptions::default());
            assert!(dropped.next().now_or_never().is_none_or(|first| first.unwrap().is_ok()));
        }
        let tasks: Vec<_> = points
            .iter()
            .map(|&from| tokio::spawn(ask(reader.clone(), from)))
            .collect();
        for (task, alone) in tasks.into_iter().zip(alone) {
            assert_eq!(task.await.unwrap(), alone);
        }
    });
}

#[test]
fn euclidean_distances_of_sites_and_vertices_are_sorted_and_complete() {
    runtime().block_on(async {
        let scene = town();
        let (_scratch, reader) = scene.build(30).await;
        for from in [Point::new(3.5, 3.5), at(7, 7), Point::new(-4.0, 40.0)] {
            let sites: Vec<_> = reader
                .sites_by_euclidean_distance(from, QueryOptions::default())
                .try_collect()
                .await
                .unwrap();
            let mut expected: Vec<f64> = scene.sites.iter().map(|&site| length(&[from, site])).collect();
            expected.sort_by(f64::total_cmp);
            assert_eq!(sites.len(), expected.len());
            assert!(sites.is_sorted_by(|a, b| (a.distance, a.site) < (b.distance, b.site)));
            for (site, expected) in sites.iter().zip(expected) {
                assert!(is_near(site.distance, expected) || site.distance == expected);
                assert_eq!(site.vertex.point, scene.sites[site.site.unwrap() as usize]);
            }
            let vertices: Vec<_> = reader
                .vertices_by_euclidean_distance(from, QueryOptions::default())
                .try_collect()
                .await
                .unwrap();
            assert_eq!(vertices.len(), 33 * 33);
            assert!(vertices.is_sorted_by(|a, b| a.distance <= b.distance));
            let few = reader
                .vertices_by_euclidean_distance(from, QueryOptions::default().max_tiles(6))
                .take(3);
            assert_eq!(few.try_collect::<Vec<_>>().await.unwrap(), vertices[..3]);
        }
    });
}
