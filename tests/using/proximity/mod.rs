//! The promise: walking distances to points, sites and vertices are those of a brute-force
//! visibility graph, for any tiles and any cache.

mod ahead;
mod along;
mod area;
mod edges;
mod matrix;
mod methods;
mod modes;
mod outcomes;
mod scene;
mod truth;

use self::scene::{Scene, at, block, line, open, wall};
use crate::support::cases::cases;
use crate::support::oracle::{Oracle, Walk};
use crate::support::{Random, runtime};
use delaunay_tiles::geometry::{Orientation, Point, orient2d};
use delaunay_tiles::query::{PathOutcome, QueryOptions, Search};
use delaunay_tiles::store::{LineKind, TileReader};
use futures::TryStreamExt;
use proptest::prelude::*;

/// The vertices of a tile.
const TILES: [usize; 3] = [4, 20, 1 << 16];

fn is_near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * b.abs()
}

/// Returns the length of a polyline.
fn length(points: &[Point]) -> f64 {
    let legs = points.windows(2);
    legs.map(|leg| (leg[1].x - leg[0].x).hypot(leg[1].y - leg[0].y)).sum()
}

/// Returns the lengths of the walks that reach their end, the shortest first.
fn sorted_lengths(walks: &[Walk]) -> Vec<f64> {
    let length = |walk: &Walk| match *walk {
        Walk::Length(length) => Some(length),
        Walk::Unreachable | Walk::Inside => None,
    };
    let mut lengths: Vec<f64> = walks.iter().filter_map(length).collect();
    lengths.sort_by(f64::total_cmp);
    lengths
}

/// Returns the walk of the shortest path between two points, after checking the path.
async fn walk(reader: &TileReader, from: Point, to: Point) -> Walk {
    let options = QueryOptions::default().certified();
    match reader.shortest_path(from, to, options).await.unwrap() {
        PathOutcome::Found(path) => {
            let value = path.distance.value;
            assert!(is_near(length(&path.points), value) || value == 0.0, "{path:?}");
            assert_eq!((path.points.first(), path.points.last()), (Some(&from), Some(&to)));
            assert!(path.distance.lower <= value && value <= path.distance.upper);
            assert!(path.is_certified && path.bends.len() == path.points.len() - 2);
            for (bend, around) in path.bends.iter().zip(path.points.windows(3)) {
                let turn = |to| orient2d(around[0], around[1], to);
                let left = if bend.turns_left {
                    Orientation::CounterClockwise
                } else {
                    Orientation::Clockwise
                };
                assert!(bend.vertex.point == around[1] && turn(around[2]) == left, "{path:?}");
                let is_in_the_way = orient2d(around[1], around[2], bend.edge_to.unwrap().point);
                assert!(
                    is_in_the_way == left || is_in_the_way == Orientation::Collinear,
                    "{path:?}"
                );
                assert!(bend.sources.iter().any(|source| source.is_wall()), "{path:?}");
            }
            Walk::Length(value)
        }
        PathOutcome::Unreachable => Walk::Unreachable,
        PathOutcome::InsideObstacle { .. } => Walk::Inside,
    }
}

fn same(found: Walk, expected: Walk) -> bool {
    match (found, expected) {
        (Walk::Length(a), Walk::Length(b)) => is_near(a, b),
        (a, b) => a == b,
    }
}

/// Compares paths between `count` points, and distances to all vertices and to sites, with the
/// oracle, for each size of tiles.
async fn compare(scene: &Scene, count: usize, tile_sizes: &[usize]) {
    let mut random = Random(count as u64 + scene.lines.len() as u64);
    let targets = scene.targets(&mut random, count);
    let sources = &targets[..count.div_ceil(2)];
    let mut oracle = None;
    for &size in tile_sizes {
        let (scratch, reader) = scene.build(size).await;
        if oracle.is_none() {
            let oracle_of = Oracle::read(&reader).await;
            let walks: Vec<_> = sources.iter().map(|&from| oracle_of.walks(from, &targets)).collect();
            oracle = Some((oracle_of, walks));
        }
        let Some((oracle, walks)) = &oracle else { unreachable!() };
        // A cache that holds nothing.
        let poor = open(&scratch, 0).await;
        for (round, (&from, expected)) in sources.iter().zip(walks).enumerate() {
            let reader = if round % 3 == 0 { &poor } else { &reader };
            for (&to, &expected) in targets.iter().zip(expected) {
                let found = walk(reader, from, to).await;
                assert!(
                    same(found, expected),
                    "tiles of {size}: {from:?} to {to:?}: {found:?}, not {expected:?} in {scene:?}"
                );
            }
            if !oracle.is_free(from) {
                continue;
            }
            compare_vertices(reader, oracle, from).await;
            compare_sites(reader, oracle, from, scene).await;
            let several = reader.shortest_paths(from, targets.clone(), QueryOptions::default());
            let several: Vec<_> = several.try_collect().await.unwrap();
            assert!(several.is_sorted_by(|a, b| a.1.distance.value <= b.1.distance.value));
            let mut found = vec![Walk::Unreachable; targets.len()];
            for (target, path) in several {
                found[target] = Walk::Length(path.distance.value);
            }
            for (found, &expected) in found.into_iter().zip(expected) {
                let expected = if expected == Walk::Inside {
                    Walk::Unreachable
                } else {
                    expected
                };
                assert!(same(found, expected), "{found:?}, not {expected:?}");
            }
        }
    }
}

async fn compare_vertices(reader: &TileReader, oracle: &Oracle, from: Point) {
    let expected = oracle.walks(from, &oracle.points);
    let reached = expected.iter().filter(|walk| matches!(walk, Walk::Length(_))).count();
    let found: Vec<_> = reader
        .vertices_by_distance(from, QueryOptions::default())
        .try_collect()
        .await
        .unwrap();
    assert!(found.is_sorted_by(|a, b| a.distance.value <= b.distance.value));
    assert_eq!(found.len(), reached, "from {from:?}");
    for vertex in found {
        let index = oracle.points.iter().position(|&p| p == vertex.vertex.point).unwrap();
        let length = vertex.distance.value;
        assert!(
            same(Walk::Length(length), expected[index]),
            "from {from:?} to {vertex:?}, not {:?}",
            expected[index]
        );
    }
}

async fn compare_sites(reader: &TileReader, oracle: &Oracle, from: Point, scene: &Scene) {
    let expected = oracle.walks(from, &scene.sites);
    let lengths = sorted_lengths(&expected);
    let found: Vec<_> = reader
        .nearest_sites(from, QueryOptions::default().certified())
        .try_collect()
        .await
        .unwrap();
    assert_eq!(found.len(), lengths.len());
    assert!(found.is_sorted_by(|a, b| (a.distance.value, a.number) < (b.distance.value, b.number)));
    for (site, length) in found.iter().zip(&lengths) {
        assert!(
            is_near(site.distance.value, *length),
            "from {from:?}: {site:?}, not {length}"
        );
        assert!(same(Walk::Length(site.distance.value), expected[site.number as usize]));
        assert_eq!(site.vertex.point, scene.sites[site.number as usize]);
    }
    for count in [1, found.len() / 2, found.len() + 3] {
        for search in [Search::Aimed, Search::Auto] {
            let options = QueryOptions::default().first(count).search(search);
            let first: Vec<_> = reader.nearest_sites(from, options).try_collect().await.unwrap();
            assert_eq!(first.len(), count.min(found.len()), "{search:?}");
            for (site, length) in first.iter().zip(&lengths) {
                assert!(
                    is_near(site.distance.value, *length),
                    "{search:?} from {from:?}: {site:?}"
                );
                assert!(same(Walk::Length(site.distance.value), expected[site.number as usize]));
            }
            let mut numbers: Vec<u64> = first.iter().map(|site| site.number).collect();
            numbers.sort_unstable();
            numbers.dedup();
            assert_eq!(numbers.len(), first.len());
        }
    }
    let Some(middle) = found.get(found.len() / 2) else {
        return;
    };
    let radius = middle.distance.value;
    let within: Vec<_> = reader
        .sites_within(from, radius, QueryOptions::default())
        .try_collect()
        .await
        .unwrap();
    assert!(within.iter().all(|site| site.distance.value <= radius));
    let expected = found.iter().filter(|site| site.distance.value <= radius);
    assert!(
        within
            .iter()
            .map(|site| site.number)
            .eq(expected.map(|site| site.number))
    );
}

fn check(scene: &Scene, count: usize, tile_sizes: &[usize]) {
    runtime().block_on(compare(scene, count, tile_sizes));
}

#[test]
fn distances_in_scenes_by_hand_agree_with_the_oracle() {
    for (name, mut scene) in scene::by_hand() {
        println!("{name}");
        scene.sites = vec![at(0, 0), at(4, 4), at(2, 3), at(4, 2), at(4, 4)];
        check(&scene, 8, &TILES);
        scene.exterior_is_hole = true;
        check(&scene, 8, &[9]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(80) as u32, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn distances_among_blocks_and_walls_on_grids_agree_with_the_oracle(mut scene in scene::blocks_and_walls(1..8, &scene::KINDS)) {
        scene.sites = vec![at(0, 0), at(3, 3), at(7, 2), at(10, 10), at(5, 5), at(5, 5), at(2, 8)];
        check(&scene, 6, &[[4, 9, 40][scene.lines.len() % 3], 1 << 16]);
    }

    #[test]
    fn distances_among_polygons_and_walls_anywhere_agree_with_the_oracle(seed in any::<u64>()) {
        let mut random = Random(seed);
        let mut scene = Scene::polygons_anywhere(&mut random, &scene::KINDS[..2]);
        scene.sites = scene.points[..8].to_vec();
        check(&scene, 6, &[4, 1 << 16]);
    }
}

/// Searches ignore break lines.
#[test]
fn break_lines_do_not_change_distances() {
    let mut random = Random(5);
    let walls = vec![
        block([2, 2], [3, 2]),
        wall(&[(7, 1), (7, 8)]),
        wall(&[(1, 7), (6, 7), (6, 5)]),
    ];
    let mut broken = walls.clone();
    broken.extend((0..10).map(|i| line(LineKind::BreakLine, &[(0, i), (9, 9 - i)])));
    broken.push(line(LineKind::BreakLine, &[(0, 0), (9, 0), (9, 9), (0, 9), (0, 0)]));
    let [plain, broken] = [walls, broken].map(|lines| Scene::on_grid(10, 10, lines));
    runtime().block_on(async {
        let (_one, plain_reader) = plain.build(1 << 16).await;
        let (_other, broken) = broken.build(20).await;
        let targets = plain.targets(&mut random, 40);
        for pair in targets.windows(2) {
            let expected = walk(&plain_reader, pair[0], pair[1]).await;
            let found = walk(&broken, pair[0], pair[1]).await;
            assert!(same(found, expected), "{pair:?}: {found:?}, not {expected:?}");
        }
    });
}
