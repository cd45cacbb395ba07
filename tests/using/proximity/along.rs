//! The nearest sites along a line: at every point they are those of a search from there, and there
//! are no more intervals than necessary.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{AlongInterval, QueryError, QueryOptions};
use delaunay_tiles::store::TileReader;
use futures::{StreamExt, TryStreamExt};
use proptest::prelude::*;

use crate::proximity::scene::{Scene, at, block, open, wall};
use crate::proximity::{Walk, is_near, length, same, sorted_lengths};
use crate::support::oracle::Oracle;
use crate::support::{Random, runtime};

fn on(line: [Point; 2], t: f64) -> Point {
    let [a, b] = line;
    Point::new(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y))
}

/// Returns the walk to each site, and the sorted lengths of the walks to those that can be reached;
/// `None` if `from` is not free.
fn truth(oracle: &Oracle, sites: &[Point], from: Point) -> Option<(Vec<Walk>, Vec<f64>)> {
    if !oracle.is_free(from) {
        return None;
    }
    let walks = oracle.walks(from, sites);
    let lengths = sorted_lengths(&walks);
    Some((walks, lengths))
}

/// Compares an interval with the truth at one of its points.
fn compare_at(interval: &AlongInterval, k: usize, sites: &[Point], oracle: &Oracle, from: Point, position: &str) {
    let context = || format!("{from:?}, {position} of {interval:?}");
    let Some((walks, lengths)) = truth(oracle, sites, from) else {
        assert!(interval.sites.is_none(), "not free: {}", context());
        return;
    };
    let found = interval.sites.as_ref().unwrap_or_else(|| panic!("free: {}", context()));
    assert_eq!(found.len(), k.min(lengths.len()), "{}", context());
    for (site, length) in found.iter().zip(lengths) {
        let walk = walks[site.number as usize];
        assert!(
            same(walk, Walk::Length(length)) || walk == Walk::Length(length),
            "{walk:?}, not {length}: {}",
            context()
        );
        assert_eq!(site.vertex.point, sites[site.number as usize]);
    }
}

async fn check(reader: &TileReader, oracle: &Oracle, sites: &[Point], line: [Point; 2], k: usize, random: &mut Random) {
    let intervals = reader.nearest_along(line[0], line[1], k, QueryOptions::default());
    let intervals: Vec<_> = intervals.try_collect().await.unwrap();
    let (first, last) = (&intervals[0], &intervals[intervals.len() - 1]);
    assert_eq!(
        (first.from, first.from_t, last.to, last.to_t),
        (line[0], 0.0, line[1], 1.0)
    );
    let numbers = |interval: &AlongInterval| -> Option<Vec<u64>> {
        let sites = interval.sites.as_ref()?;
        Some(sites.iter().map(|site| site.number).collect())
    };
    for pair in intervals.windows(2) {
        assert_eq!((pair[0].to_t, pair[0].to), (pair[1].from_t, pair[1].from));
        assert_ne!(numbers(&pair[0]), numbers(&pair[1]), "{pair:?}");
    }
    let whole = length(&line);
    for interval in &intervals {
        let width = interval.to_t - interval.from_t;
        assert!(width > 0.0);
        let middle = interval.from_t + 0.5 * width;
        if width < 1e-9 {
            continue;
        }
        compare_at(interval, k, sites, oracle, on(line, middle), "middle");
        let any = interval.from_t + random.unit() * width;
        compare_at(interval, k, sites, oracle, on(line, any), "somewhere");
        // Near enough to the ends that a wrong end shows.
        let inset = (1e-8f64).min(width / 4.0);
        let ends = [interval.from_t + inset, interval.to_t - inset];
        for (position, t) in ["start", "end"].into_iter().zip(ends) {
            compare_at(interval, k, sites, oracle, on(line, t), position);
        }
        for (end, t) in ends.into_iter().enumerate() {
            for site in interval.sites.iter().flatten() {
                let Walk::Length(expected) = oracle.walks(on(line, t), sites)[site.number as usize] else {
                    panic!("{site:?} cannot be reached")
                };
                let apart = (site.distances[end] - expected).abs();
                assert!(
                    apart <= 1.001 * inset * whole + 1e-9 * expected,
                    "{site:?}, not {expected}"
                );
            }
        }
    }
}

/// Lines through, along and beside obstacles, and out of the hull.
fn lines() -> Vec<[Point; 2]> {
    let half = |x: i32, y: i32| Point::new(f64::from(x) / 2.0, f64::from(y) / 2.0);
    vec![
        [half(1, 1), half(19, 18)],
        [half(0, 9), half(20, 9)],
        [at(0, 4), at(10, 4)],
        [at(3, 0), at(3, 10)],
        [at(0, 0), at(10, 10)],
        [at(0, 10), at(10, 0)],
        [half(-5, 3), half(27, 16)],
        [half(-4, 0), half(24, 0)],
        [half(-4, -4), half(-4, 20)],
        [at(2, 3), at(2, 3)],
        [half(7, 7), half(8, 7)],
    ]
}

#[test]
fn intervals_in_scenes_by_hand_agree_with_the_oracle() {
    for (name, mut scene) in [
        ("nothing in the way", Scene::in_room(10, vec![])),
        ("one wall", Scene::in_room(10, vec![wall(&[(5, 2), (5, 8)])])),
        (
            "a wall from hull to hull",
            Scene::in_room(10, vec![wall(&[(0, 4), (10, 4)])]),
        ),
        (
            "blocks",
            Scene::on_grid(
                11,
                11,
                vec![block([1, 1], [2, 3]), block([4, 4], [3, 3]), block([3, 8], [5, 1])],
            ),
        ),
        (
            "a slanted wall",
            Scene::in_room(
                10,
                vec![
                    wall(&[(0, 0), (8, 4)]),
                    wall(&[(2, 6), (9, 7)]),
                    wall(&[(2, 6), (3, 9)]),
                ],
            ),
        ),
        (
            "an island that is the hull",
            Scene::on_grid(11, 11, vec![block([0, 0], [10, 10])]),
        ),
        (
            "a closed wall",
            Scene::on_grid(11, 11, vec![wall(&[(2, 2), (7, 2), (7, 7), (2, 7), (2, 2)])]),
        ),
    ] {
        println!("{name}");
        scene.sites = vec![
            at(0, 0),
            at(4, 4),
            at(2, 3),
            at(4, 2),
            at(4, 4),
            at(9, 9),
            at(7, 1),
            at(1, 8),
            at(10, 5),
        ];
        runtime().block_on(async {
            let mut random = Random(1);
            for tile_vertices in [7, 1 << 16] {
                let (_scratch, reader) = scene.build(tile_vertices).await;
                let oracle = Oracle::read(&reader).await;
                let mut all = lines();
                all.push([at(0, 0), at(8, 4)]);
                for (round, line) in all.into_iter().enumerate().filter(|(_, line)| line[0] != line[1]) {
                    let k = [1, 3, 20][round % 3];
                    check(&reader, &oracle, &scene.sites, line, k, &mut random).await;
                }
            }
        });
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn intervals_among_random_blocks_and_walls_agree_with_the_oracle(seed in any::<u64>(), is_dense in any::<bool>(), exterior_is_hole in prop::bool::weighted(0.2)) {
        let mut random = Random(seed);
        let mut scene = Scene::few_blocks(&mut random, is_dense);
        scene.exterior_is_hole = exterior_is_hole;
        scene.sites = (0..12).map(|_| at(random.below(11) as i32, random.below(11) as i32)).collect();
        let mut any = || Point::new(12.0 * random.unit() - 1.0, 12.0 * random.unit() - 1.0);
        let lines: Vec<[Point; 2]> = (0..4).map(|_| [any(), any()]).collect();
        runtime().block_on(async {
            let (scratch, reader) = scene.build(9).await;
            let oracle = Oracle::read(&reader).await;
            let poor = open(&scratch, 0).await;
            for (line, k) in lines.into_iter().zip([1, 2, 4, 30]) {
                check(if k == 2 { &poor } else { &reader }, &oracle, &scene.sites, line, k, &mut random).await;
            }
        });
    }
}

/// Among many sites the lists are those of searches from points of the line, and the search stays
/// near the line.
#[test]
fn intervals_of_a_long_line_agree_with_searches_and_stay_valid_under_budgets() {
    let mut random = Random(4);
    let scene = Scene::town_with_sites(7, 250, &mut random);
    runtime().block_on(async {
        let (_scratch, reader) = scene.build(60).await;
        let line = [Point::new(0.5, 0.25), Point::new(36.75, 36.0)];
        let k = 3;
        let intervals = reader.nearest_along(line[0], line[1], k, QueryOptions::default());
        let intervals: Vec<_> = intervals.try_collect().await.unwrap();
        assert!(intervals.len() > 30, "{}", intervals.len());
        for interval in &intervals {
            let from = on(
                line,
                interval.from_t + (interval.to_t - interval.from_t) * (0.1 + 0.8 * random.unit()),
            );
            let sites = reader
                .nearest_sites(from, QueryOptions::default())
                .take(k)
                .try_collect::<Vec<_>>()
                .await;
            match (&interval.sites, sites) {
                (None, Err(QueryError::InsideObstacle { .. })) => {}
                (Some(along), Ok(found)) => {
                    let lengths: Vec<f64> = found.iter().map(|site| site.distance.value).collect();
                    let is_clear = lengths.windows(2).all(|pair| pair[1] - pair[0] > 1e-9);
                    let numbers = |site: u64| found.iter().any(|found| found.number == site);
                    assert!(
                        !is_clear || along.iter().take(k - 1).all(|site| numbers(site.number)),
                        "{from:?} {along:?} {found:?}"
                    );
                }
                (along, found) => panic!("{from:?}: {along:?} {found:?}"),
            }
        }
        let read = reader.cache().statistics().misses;
        assert!(read <= reader.directory().await.unwrap().tiles.len() as u64);
        let mut partial = 0;
        for tiles in 2..read {
            let budget = QueryOptions::default().max_tiles(tiles);
            let found: Vec<_> = reader.nearest_along(line[0], line[1], k, budget).collect().await;
            let Some((Err(QueryError::OutOfBudget { lower_bound: 0.0 }), before)) = found.split_last() else {
                assert!(found.iter().map(|found| found.as_ref().unwrap()).eq(&intervals));
                continue;
            };
            partial += usize::from(!before.is_empty());
            for (found, whole) in before.iter().map(|found| found.as_ref().unwrap()).zip(&intervals) {
                let numbers = |interval: &AlongInterval| {
                    let sites = interval.sites.iter().flatten();
                    sites.map(|site| site.number).collect::<Vec<_>>()
                };
                assert_eq!((found.from, numbers(found)), (whole.from, numbers(whole)));
                assert!(found.to_t <= whole.to_t);
            }
        }
        assert!(partial > 3, "{partial} of {read}");
    });
}

#[test]
fn a_line_of_length_zero_and_zero_sites_give_exact_intervals() {
    runtime().block_on(async {
        let mut scene = Scene::on_grid(6, 6, vec![block([2, 2], [2, 2])]);
        scene.sites = vec![at(0, 0), at(0, 0), at(5, 5)];
        let (_scratch, reader) = scene.build(9).await;
        let along = |from, to, k| {
            let reader = &reader;
            async move {
                let intervals = reader.nearest_along(from, to, k, QueryOptions::default());
                intervals.try_collect::<Vec<_>>().await
            }
        };
        let one = along(at(0, 3), at(0, 3), 3).await.unwrap();
        let sites = one[0].sites.as_ref().unwrap();
        let found: Vec<(u64, f64)> = sites.iter().map(|site| (site.number, site.distances[1])).collect();
        assert_eq!((one.len(), &found[..2]), (1, &[(0, 3.0), (1, 3.0)][..]));
        assert!(is_near(found[2].1, 5f64.sqrt() + 10f64.sqrt()) && found[2].0 == 2);
        let inside = along(at(3, 3), at(3, 3), 3).await.unwrap();
        assert_eq!((inside.len(), &inside[0].sites), (1, &None));
        let none = along(at(0, 3), at(5, 3), 0).await.unwrap();
        let shape: Vec<(f64, Option<usize>)> = none.iter().map(|i| (i.to_t, i.sites.as_ref().map(Vec::len))).collect();
        assert_eq!(shape, [(0.4, Some(0)), (0.8, None), (1.0, Some(0))]);
        let error = along(at(0, 0), Point::new(f64::NAN, 1.0), 1).await.unwrap_err();
        assert!(matches!(error, QueryError::NotAPoint { .. }));
    });
}
