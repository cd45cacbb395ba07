//! The promise: the method of the thesis, and the methods that it is compared with, give the
//! answers of the wavefront search.

use delaunay_tiles::BuildOptions;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::baselines::{Method, Stretch};
use delaunay_tiles::query::{PathOutcome, QueryError, QueryOptions, SiteFound};
use delaunay_tiles::store::{LineKind, TileReader};
use futures::TryStreamExt;
use proptest::prelude::*;

use crate::proximity::scene::{self, Scene, at, block, line, wall};
use crate::proximity::truth::{self, is_printed};
use crate::proximity::{is_near, length, same};
use crate::support::oracle::Walk;
use crate::support::{Random, runtime};

const THESIS: Method = Method::Visibility {
    stretch: Stretch::PROVED,
};
const METHODS: [Method; 4] = [THESIS, Method::EuclidZhang, Method::EuclidXia, Method::Wavefront];

async fn walk(reader: &TileReader, method: Method, from: Point, to: Point) -> Walk {
    let options = QueryOptions::default().certified();
    let measured = reader.shortest_path_by(method, from, to, options).await.unwrap();
    match measured.answer {
        PathOutcome::Found(path) => {
            let sum = length(&path.points);
            assert!(is_near(sum, path.distance.value) || sum == 0.0, "{path:?}");
            assert!(path.is_certified);
            assert_eq!((path.points.first(), path.points.last()), (Some(&from), Some(&to)));
            Walk::Length(path.distance.value)
        }
        PathOutcome::Unreachable => Walk::Unreachable,
        PathOutcome::InsideObstacle { .. } => Walk::Inside,
    }
}

/// Returns whether `found` are the first `count` of `all`; equally distant sites may be in any
/// order.
fn are_first(found: &[SiteFound], all: &[SiteFound], count: usize) -> bool {
    found.len() == count.min(all.len())
        && found.iter().zip(all).all(|(found, expected)| {
            let same = all.iter().find(|site| site.number == found.number);
            is_near(found.distance.value, expected.distance.value)
                && same.is_some_and(|same| is_near(found.distance.value, same.distance.value))
                && found.path.as_ref().is_some_and(|path| path.is_certified)
        })
}

async fn compare(scene: &Scene, count: usize, tile_vertices: usize) {
    let (_scratch, reader) = scene.build(tile_vertices).await;
    let mut random = Random(count as u64 + scene.lines.len() as u64);
    let targets = scene.targets(&mut random, count);
    let options = QueryOptions::default().certified();
    for &from in &targets[..count.div_ceil(2)] {
        let all = reader
            .nearest_sites(from, options.clone())
            .try_collect::<Vec<_>>()
            .await;
        for method in METHODS {
            let context = || format!("{method:?} from {from:?} in {scene:?}");
            for k in [1, 3, scene.sites.len() + 1] {
                let found = reader.nearest_sites_by(method, from, k, options.clone()).await;
                match (&all, found) {
                    (Ok(all), Ok(found)) => {
                        assert!(
                            are_first(&found.answer, all, k),
                            "{k} nearest, {}: {found:?}, not {all:?}",
                            context()
                        );
                    }
                    (Err(QueryError::InsideObstacle { .. }), Err(QueryError::InsideObstacle { .. })) => {}
                    (expected, found) => panic!("{}: {found:?}, not {expected:?}", context()),
                }
            }
            if let Ok(all) = &all
                && let Some(middle) = all.get(all.len() / 2)
            {
                // No site is so near to the limit that rounding decides.
                let radius = 1.000_001 * middle.distance.value;
                let within = all.iter().filter(|site| site.distance.value <= radius).count();
                let found = reader
                    .sites_within_by(method, from, radius, options.clone())
                    .await
                    .unwrap();
                assert!(
                    are_first(&found.answer, &all[..within], usize::MAX),
                    "within {radius}, {}: {found:?}",
                    context()
                );
            }
        }
        for &to in &targets {
            let expected = crate::proximity::walk(&reader, from, to).await;
            for method in METHODS {
                let found = walk(&reader, method, from, to).await;
                assert!(
                    same(found, expected),
                    "{method:?} from {from:?} to {to:?}: {found:?}, not {expected:?} in {scene:?}"
                );
            }
        }
    }
}

fn check(scene: &Scene, count: usize, tile_vertices: usize) {
    runtime().block_on(compare(scene, count, tile_vertices));
}

#[test]
fn methods_agree_in_scenes_by_hand() {
    for (name, mut scene) in scene::by_hand() {
        println!("{name}");
        scene.sites = [(0, 0), (4, 4), (2, 3), (4, 2), (4, 4), (6, 0), (0, 4)]
            .map(|(x, y)| at(x, y))
            .to_vec();
        check(&scene, 10, 20);
        scene.exterior_is_hole = true;
        check(&scene, 6, 1 << 16);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 30, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn methods_agree_among_blocks_and_walls_on_grids(mut scene in scene::blocks_and_walls(1..8, &scene::KINDS[1..])) {
        scene.sites = (0..20).map(|i| at(i * 7 % 11, i * 5 % 10)).collect();
        check(&scene, 6, [9, 40, 1 << 16][scene.lines.len() % 3]);
    }

    #[test]
    fn methods_agree_among_polygons_and_walls_anywhere(seed in any::<u64>()) {
        let mut random = Random(seed);
        let mut scene = Scene::polygons_anywhere(&mut random, &[LineKind::Wall]);
        scene.sites = scene.points.clone();
        check(&scene, 6, if seed % 2 == 0 { 9 } else { 1 << 16 });
    }
}

#[test]
fn methods_find_the_known_lengths_on_the_map_of_a_game() {
    runtime().block_on(async {
        let (_scratch, reader, lengths) = truth::game(30).await;
        for ([from, to], expected) in lengths {
            for method in METHODS {
                let found = walk(&reader, method, from, to).await;
                assert!(
                    matches!(found, Walk::Length(length) if is_printed(length, expected)),
                    "{method:?} from {from:?} to {to:?}: {found:?}, not {expected}"
                );
            }
        }
    });
}

#[test]
fn methods_find_the_known_distances_among_islands() {
    runtime().block_on(async {
        let Some((_scratch, reader, sights)) = truth::islands(BuildOptions::default().tile_vertices).await else {
            return;
        };
        for sight in sights.iter().step_by(331) {
            for method in METHODS {
                let found = walk(&reader, method, sight.from, sight.to).await;
                assert!(
                    same(found, Walk::Length(sight.distance)),
                    "{method:?}: {found:?}, {sight:?}"
                );
            }
        }
    });
}

/// With few tiles a search returns the first sites or none, and no other site is nearer than the
/// bound it reports.
#[test]
fn sites_and_bounds_stay_valid_when_a_budget_is_used_up() {
    let mut random = Random(11);
    let scene = Scene::town_with_sites(5, 60, &mut random);
    runtime().block_on(async {
        let (_scratch, reader) = scene.build(12).await;
        let at = scene.targets(&mut random, 1)[0];
        let (mut some, mut bounds) = (0, 0);
        for method in [&METHODS[..], &[Method::Wavefront]].concat() {
            let ask = |options| reader.nearest_sites_by(method, at, 25, options);
            let whole = ask(QueryOptions::default()).await.unwrap();
            assert_eq!((whole.answer.len(), whole.lower_bound), (25, None));
            for tiles in 1..=whole.statistics.tiles {
                let Ok(found) = ask(QueryOptions::default().max_tiles(tiles)).await else {
                    continue;
                };
                let count = found.answer.len();
                assert_eq!(found.answer, whole.answer[..count], "{method:?}, {tiles} tiles");
                let Some(lower_bound) = found.lower_bound else {
                    assert_eq!(count, 25);
                    continue;
                };
                let next = whole.answer[count].distance.upper;
                assert!(
                    lower_bound <= next,
                    "{method:?}, {tiles} tiles: {count} sites, then {lower_bound} > {next}"
                );
                some += usize::from(count > 0);
                bounds += usize::from(lower_bound > 0.0);
            }
        }
        assert!(some > 5 && bounds > 15, "{some} {bounds}");
    });
}

#[test]
fn methods_report_costs_and_refuse_break_lines_and_small_budgets() {
    runtime().block_on(async {
        let walls = vec![block([2, 2], [3, 2]), wall(&[(7, 1), (7, 8)])];
        let mut scene = Scene::on_grid(10, 10, walls);
        scene.sites = vec![at(1, 1), at(9, 9), at(8, 4)];
        let (_scratch, reader) = scene.build(30).await;
        let options = QueryOptions::default();
        for stretch in [1.5, 1.5931, f64::NAN, f64::INFINITY, -3.0] {
            assert!(Stretch::new(stretch).is_err(), "{stretch}");
        }
        for method in METHODS {
            let found = reader
                .nearest_sites_by(method, at(6, 4), 2, options.clone())
                .await
                .unwrap();
            let cost = found.statistics;
            assert_eq!(found.answer.len(), 2);
            assert!(
                cost.tiles >= 1 && cost.rounds >= 1 && cost.candidates >= 2 && cost.nodes_swept >= 1,
                "{cost:?}"
            );
            assert!(
                cost.edges_considered >= cost.edges_kept && cost.edges_considered >= 1,
                "{cost:?}"
            );
            assert!(!cost.times.is_empty() && cost.time() >= cost.times[0].time);
            let few = reader
                .nearest_sites_by(method, at(6, 4), 2, options.clone().max_tiles(0))
                .await;
            assert!(matches!(few, Err(QueryError::OutOfBudget { .. })), "{few:?}");
        }
        scene.lines.push(line(LineKind::BreakLine, &[(0, 8), (5, 8)]));
        let (_scratch, reader) = scene.build(30).await;
        for method in METHODS {
            let sites = reader.sites_within_by(method, at(6, 7), 20.0, options.clone()).await;
            let path = reader
                .shortest_path_by(method, at(6, 7), at(0, 9), options.clone())
                .await;
            if method == Method::Wavefront {
                assert_eq!(sites.unwrap().answer.len(), 3);
                assert!(matches!(path.unwrap().answer, PathOutcome::Found(_)));
            } else {
                assert!(
                    matches!(sites, Err(QueryError::BreakLines { .. })),
                    "{method:?}: {sites:?}"
                );
                assert!(
                    matches!(path, Err(QueryError::BreakLines { .. })),
                    "{method:?}: {path:?}"
                );
            }
        }
    });
}
