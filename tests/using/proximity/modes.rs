//! In every mode the truth is between the bounds, and every path can be walked.

use std::time::Duration;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{Distance, Mode, Path, PathOutcome, Progress, QueryError, QueryOptions, SiteFound};
use delaunay_tiles::store::{LineKind, TileReader};
use delaunay_tiles::{BuildOptions, Builder};
use futures::{Stream, StreamExt, TryStreamExt};
use proptest::prelude::*;

use crate::proximity::scene::{self, Scene, at, line, open, wall};
use crate::proximity::truth;
use crate::proximity::{is_near, length};
use crate::support::oracle::{Oracle, Walk};
use crate::support::{Random, Scratch, batches, runtime};

const MODES: [Mode; 5] = [
    Mode::Fast,
    Mode::Within(0.0),
    Mode::Within(0.01),
    Mode::Within(0.2),
    Mode::Exact,
];

fn options(mode: Mode) -> QueryOptions {
    QueryOptions::default().mode(mode)
}

/// Checks that the truth, with rounding, is between the bounds, and that these are as close as the
/// mode promises.
fn check_distance(found: &Distance, truth: f64, mode: Mode) {
    let Distance { value, lower, upper } = *found;
    assert!(lower <= value && value <= upper, "{found:?}");
    assert!(
        lower <= truth * (1.0 + 1e-13) && truth * (1.0 - 1e-13) <= upper,
        "{mode:?}: {found:?}, but {truth}"
    );
    let promised = match mode {
        Mode::Fast => return,
        Mode::Within(tolerance) => 1.0 + tolerance,
        _ => 1.0,
    };
    assert!(upper <= lower * promised * (1.0 + 1e-12), "{mode:?}: {found:?}");
}

/// Checks that a path is certified and has the length that it reports, and that its bends are its
/// points.
fn check_path(path: &Path, from: Point, to: Point) {
    assert!(path.is_certified);
    assert_eq!((path.points.first(), path.points.last()), (Some(&from), Some(&to)));
    assert!(
        is_near(length(&path.points), path.distance.value) || path.distance.value == 0.0,
        "{path:?}"
    );
    assert_eq!(path.bends.len() + 2, path.points.len(), "{path:?}");
    let points = path.points[1..].iter().zip(&path.bends);
    assert!(points.clone().all(|(&point, bend)| bend.vertex.point == point));
}

async fn compare_paths(reader: &TileReader, from: Point, targets: &[Point], expected: &[Walk]) -> f64 {
    let mut worst: f64 = 1.0;
    for mode in MODES {
        for (&to, &expected) in targets.iter().zip(expected) {
            let outcome = reader.shortest_path(from, to, options(mode).certified()).await.unwrap();
            match (&outcome, expected) {
                (PathOutcome::Found(path), Walk::Length(truth)) => {
                    check_distance(&path.distance, truth, mode);
                    check_path(path, from, to);
                    // The path is a shortest path within its sleeve: an edge is in the way at each
                    // bend.
                    let is_shortest_in_sleeve = path.bends.iter().all(|bend| bend.edge_to.is_some());
                    assert!(is_shortest_in_sleeve, "{mode:?}: {path:?}");
                    if truth > 0.0 {
                        worst = worst.max(path.distance.value / truth);
                    }
                }
                (PathOutcome::Unreachable, Walk::Unreachable) => {}
                (PathOutcome::InsideObstacle { .. }, Walk::Inside) => {}
                _ => panic!("{mode:?}: {from:?} to {to:?}: {outcome:?}, not {expected:?}"),
            }
        }
    }
    worst
}

async fn all<T>(stream: impl Stream<Item = Result<T, QueryError>>) -> Vec<T> {
    stream.try_collect().await.unwrap()
}

async fn compare_streams(reader: &TileReader, oracle: &Oracle, from: Point, scene: &Scene, targets: &[Point]) {
    let truths = oracle.walks(from, &scene.sites);
    let reached = truths.iter().filter(|walk| matches!(walk, Walk::Length(_))).count();
    let truth = |site: &SiteFound| match truths[site.number as usize] {
        Walk::Length(truth) => truth,
        other => panic!("{site:?}, but {other:?}"),
    };
    let walks = oracle.walks(from, targets);
    for mode in MODES {
        let sites = all(reader.nearest_sites(from, options(mode).certified())).await;
        assert_eq!(sites.len(), reached);
        for site in &sites {
            check_distance(&site.distance, truth(site), mode);
            let path = site.path.as_ref().unwrap();
            assert_eq!(path.distance.value, site.distance.value);
            check_path(path, from, site.vertex.point);
        }
        if let Some(middle) = sites.get(sites.len() / 2) {
            // Sites within a radius are exact in every mode.
            let radius = middle.distance.value;
            let within = all(reader.sites_within(from, radius, options(mode).certified())).await;
            let exact = all(reader.sites_within(from, radius, options(Mode::Exact).certified())).await;
            assert_eq!(within, exact, "{mode:?}");
        }
        let paths = all(reader.shortest_paths(from, targets.to_vec(), options(mode).certified())).await;
        assert!(paths.is_sorted_by(|a, b| a.1.distance.value <= b.1.distance.value));
        let mut numbers: Vec<usize> = paths.iter().map(|path| path.0).collect();
        numbers.sort_unstable();
        let expected = (0..targets.len()).filter(|&to| matches!(walks[to], Walk::Length(_)));
        assert!(numbers.into_iter().eq(expected), "{mode:?}");
        for (to, path) in &paths {
            let Walk::Length(truth) = walks[*to] else {
                unreachable!()
            };
            check_distance(&path.distance, truth, mode);
            check_path(path, from, targets[*to]);
        }
    }
}

/// Compares all modes with the oracle, and tiles of several sizes with each other. Returns the
/// worst ratio of a path's length to the truth.
fn check(scene: &Scene, count: usize, tile_sizes: &[usize], seed: u64) -> f64 {
    let mut worst: f64 = 1.0;
    runtime().block_on(async {
        let targets = scene.targets(&mut Random(seed), count);
        let sources = &targets[..count.div_ceil(2)];
        let mut first: Option<Vec<f64>> = None;
        for (&size, round) in tile_sizes.iter().zip(0..) {
            let (scratch, reader) = scene.build(size).await;
            let reader = if round % 2 == 1 {
                open(&scratch, 0).await
            } else {
                reader
            };
            let oracle = Oracle::read(&reader).await;
            let mut lengths = Vec::new();
            for &from in sources {
                let walks = oracle.walks(from, &targets);
                worst = worst.max(compare_paths(&reader, from, &targets, &walks).await);
                if oracle.is_free(from) {
                    compare_streams(&reader, &oracle, from, scene, &targets).await;
                    let sites = all(reader.nearest_sites(from, options(Mode::Fast))).await;
                    lengths.extend(sites.iter().map(|site| site.distance.value));
                }
            }
            let expected = first.get_or_insert_with(|| lengths.clone());
            let same = |(a, b): (&f64, &f64)| is_near(*a, *b) || a == b;
            assert!(
                lengths.len() == expected.len() && lengths.iter().zip(expected.iter()).all(same),
                "{lengths:?}, not {expected:?}, from {sources:?} in {scene:?}"
            );
        }
    });
    worst
}

#[test]
fn modes_keep_their_bounds_in_scenes_by_hand() {
    let across = vec![wall(&[(4, 1), (4, 7)]), line(LineKind::BreakLine, &[(0, 2), (8, 6)])];
    let more = [
        ("nothing in the way on a grid", Scene::on_grid(9, 9, vec![])),
        ("break lines", Scene::on_grid(9, 9, across)),
    ];
    for (name, mut scene) in scene::by_hand().into_iter().chain(more) {
        println!("{name}");
        scene.sites = vec![at(0, 0), at(4, 4), at(2, 3), at(4, 2), at(4, 4), at(6, 3)];
        let found = check(&scene, 8, &[4, 1 << 16], 3);
        println!("{found} times the truth at worst");
        let worst = if name.starts_with("nothing") { 1.0 } else { 1.5 };
        assert!(found <= worst, "{name}: {found} times the truth");
        scene.exterior_is_hole = true;
        check(&scene, 6, &[9], 4);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(5), ..ProptestConfig::default() })]

    #[test]
    fn modes_keep_their_bounds_among_blocks_and_walls_on_grids(mut scene in scene::blocks_and_walls(0..7, &scene::KINDS), seed in any::<u64>()) {
        scene.sites = vec![at(0, 0), at(3, 3), at(7, 2), at(10, 10), at(5, 5), at(5, 5), at(2, 8)];
        check(&scene, 5, &[[4, 9, 40][scene.lines.len() % 3], 1 << 16], seed);
    }

    #[test]
    fn modes_keep_their_bounds_among_walls_anywhere(seed in any::<u64>()) {
        let mut random = Random(seed);
        let mut scene = Scene::triangles_anywhere(&mut random);
        scene.sites = scene.points[..6].to_vec();
        check(&scene, 6, &[4, 1 << 16], seed);
    }
}

/// From outside the hull, equally long paths lead along edges; vertex numbers once decided between
/// them.
#[test]
fn fast_answers_from_outside_the_hull_do_not_depend_on_the_tiles() {
    let ring = |[x, y]: [i32; 2]| {
        let corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1), (x, y)];
        line(LineKind::BreakLine, &corners)
    };
    let lines = vec![
        ring([0, 0]),
        ring([4, 0]),
        wall(&[(3, 3), (2, 3)]),
        wall(&[(0, 0), (0, 1)]),
    ];
    let mut scene = Scene::in_room(10, lines);
    scene.sites = vec![at(0, 0), at(3, 3), at(7, 2), at(10, 10), at(5, 5), at(5, 5), at(2, 8)];
    runtime().block_on(async {
        let from = Point::new(-0.5, 1.5);
        let mut first: Option<Vec<f64>> = None;
        for size in [1 << 16, 4, 9, 40] {
            let (_scratch, reader) = scene.build(size).await;
            let sites = all(reader.nearest_sites(from, options(Mode::Fast))).await;
            let lengths: Vec<f64> = sites.iter().map(|site| site.distance.value).collect();
            assert_eq!(*first.get_or_insert_with(|| lengths.clone()), lengths, "{size}");
        }
    });
}

/// Lengths that others computed to six digits.
#[test]
fn bounds_contain_the_known_lengths_on_the_map_of_a_game() {
    runtime().block_on(async {
        let (_scratch, reader, lengths) = truth::game(16).await;
        for ([from, to], truth) in lengths {
            let along_edges = reader.cdt_distance(from, to, QueryOptions::default()).await.unwrap();
            let along_edges = along_edges.unwrap().distance.upper;
            for mode in [Mode::Fast, Mode::Within(0.05)] {
                let context = format!("{mode:?}, {from:?} to {to:?}");
                let outcome = reader.shortest_path(from, to, options(mode).certified()).await.unwrap();
                let PathOutcome::Found(path) = outcome else {
                    panic!("{context}: {outcome:?}")
                };
                let Distance { lower, upper, .. } = path.distance;
                assert!(
                    lower <= truth * (1.0 + 1e-5) && truth * (1.0 - 1e-5) <= upper,
                    "{context}: {path:?}, not {truth}"
                );
                assert!(
                    mode == Mode::Fast || upper <= lower * 1.05 * (1.0 + 1e-12),
                    "{context}: {path:?}"
                );
                assert!(
                    path.distance.value <= 1.125 * along_edges * (1.0 + 1e-12),
                    "{context}: {path:?}, {along_edges} along edges"
                );
            }
        }
    });
}

/// A file that does not say which lines it has is not treated as a file without break lines.
#[test]
fn files_without_a_description_are_treated_as_having_break_lines() {
    runtime().block_on(async {
        let scratch = Scratch::new();
        let mut builder = Builder::new(&scratch.path, BuildOptions::default()).unwrap();
        let points: Vec<Point> = (0..81).map(|i| at(i % 9, i / 9)).collect();
        builder.push_segments(&[[at(0, 1), at(8, 7)]]).unwrap();
        for batch in batches(&points, &[]) {
            builder.push(&batch).await.unwrap();
        }
        builder.finish().await.unwrap();
        let reader = scratch.open().await;
        let error = reader
            .cdt_distance(at(0, 0), at(8, 8), QueryOptions::default())
            .await
            .unwrap_err();
        assert!(matches!(error, QueryError::BreakLines { .. }), "{error}");
        let path = reader
            .shortest_path(at(0, 8), at(8, 1), options(Mode::Fast))
            .await
            .unwrap();
        let PathOutcome::Found(path) = path else {
            panic!("{path:?}")
        };
        assert!(is_near(path.distance.lower, 113f64.sqrt()));
    });
}

#[test]
fn a_progressive_search_returns_the_fast_answer_and_then_the_exact_one() {
    let scene = Scene::town_with_sites(6, 40, &mut Random(9));
    runtime().block_on(async {
        let (_scratch, reader) = scene.build(30).await;
        let tiles = reader.directory().await.unwrap().tree.tiles();
        let (from, to) = (Point::new(0.5, 0.25), Point::new(31.5, 20.5));
        let progress = all(reader.shortest_path_progressive(from, to, QueryOptions::default())).await;
        let exact = reader.shortest_path(from, to, QueryOptions::default()).await.unwrap();
        let PathOutcome::Found(path) = &exact else {
            panic!("{exact:?}")
        };
        let [
            Progress::Fast {
                answer: PathOutcome::Found(fast),
                exact: cost,
            },
            Progress::Exact(last),
        ] = &progress[..]
        else {
            panic!("{progress:?}")
        };
        assert_eq!(last, &exact);
        check_distance(&fast.distance, path.distance.value, Mode::Fast);
        assert!(cost.tiles >= 1 && cost.tiles <= u64::from(tiles));
        // The exact search needs no more tiles than the estimate and two.
        reader
            .shortest_path(from, to, QueryOptions::default().max_tiles(cost.tiles + 2))
            .await
            .unwrap();

        let progress = all(reader.nearest_sites_progressive(from, 5, QueryOptions::default())).await;
        let nearest: Vec<_> = reader
            .nearest_sites(from, QueryOptions::default())
            .take(5)
            .try_collect()
            .await
            .unwrap();
        let [Progress::Fast { answer, exact: cost }, Progress::Exact(last)] = &progress[..] else {
            panic!("{progress:?}")
        };
        assert_eq!(last, &nearest);
        assert!(answer.len() == 5 && cost.tiles >= 1 && cost.tiles <= u64::from(tiles));

        // The stream ends when a limit is reached.
        let mut stream = reader.shortest_path_progressive(from, to, QueryOptions::default().max_tiles(1));
        let error = stream.next().await.unwrap().unwrap_err();
        assert!(
            matches!(error, QueryError::OutOfBudget { lower_bound } if lower_bound <= path.distance.value),
            "{error}"
        );
        assert!(stream.next().await.is_none());
    });
}

#[test]
fn every_mode_keeps_its_bounds_within_a_budget() {
    let scene = Scene::town(6);
    let (from, to) = (Point::new(0.5, 16.25), Point::new(31.5, 20.5));
    runtime().block_on(async {
        let (_scratch, reader) = scene.build(30).await;
        let exact = reader.shortest_path(from, to, QueryOptions::default()).await.unwrap();
        let PathOutcome::Found(exact) = exact else {
            panic!("{exact:?}")
        };
        for mode in MODES {
            let limits = (1..12).map(|tiles| options(mode).max_tiles(tiles));
            for limited in limits.chain([options(mode).max_time(Duration::ZERO)]) {
                match reader.shortest_path(from, to, limited).await {
                    Ok(PathOutcome::Found(path)) => check_distance(&path.distance, exact.distance.value, mode),
                    Err(QueryError::OutOfBudget { lower_bound }) => assert!(lower_bound <= exact.distance.upper),
                    other => panic!("{mode:?}: {other:?}"),
                }
            }
        }
        for tolerance in [-0.5, f64::NAN, f64::INFINITY] {
            let error = reader
                .shortest_path(from, to, options(Mode::Within(tolerance)))
                .await
                .unwrap_err();
            assert!(matches!(error, QueryError::NoTolerance { .. }), "{error}");
            let error = all_or_error(reader.nearest_sites(from, options(Mode::Within(tolerance)))).await;
            assert!(matches!(error, Some(QueryError::NoTolerance { .. })), "{error:?}");
        }
    });
}

async fn all_or_error<T>(stream: impl Stream<Item = Result<T, QueryError>>) -> Option<QueryError> {
    stream.try_collect::<Vec<T>>().await.err()
}

#[test]
fn modes_parse_from_their_names() {
    assert_eq!("exact".parse(), Ok(Mode::Exact));
    assert_eq!("fast".parse(), Ok(Mode::Fast));
    assert_eq!("within:0.05".parse(), Ok(Mode::Within(0.05)));
    for text in [
        "",
        "within",
        "within:",
        "within:-1",
        "within:nan",
        "within:inf",
        "within:x",
        "Exact",
    ] {
        assert!(text.parse::<Mode>().is_err(), "{text}");
    }
}
