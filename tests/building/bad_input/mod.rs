//! The promise: for any points, any options and any state of the folder, a build gives a right
//! file, or an error that says what is wrong and leaves nothing behind.

mod data;
use std::fs;
use std::future::Future;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use crate::support::{Random, Scratch, batches, build_batches, built, distinct, points_of, reference, runtime};
use delaunay_tiles::geometry::{Point, Rect};
use delaunay_tiles::input::{PointBatch, SegmentBatch, SiteBatch};
use delaunay_tiles::mesh::EngineKind;
use delaunay_tiles::query::Location;
use delaunay_tiles::store::{LineKind, TileReader};
use delaunay_tiles::{BuildError, BuildOptions, Builder, Duplicates, MemoryShortage, MemoryUse, Phase, Progress};
use distributions::Kind;
use futures::stream::TryStreamExt;

fn options(tile_vertices: usize) -> BuildOptions {
    BuildOptions::default().tile_vertices(tile_vertices).threads(2)
}

/// Runs `work`, and panics if it takes longer than a minute.
fn in_time<T>(work: impl Future<Output = T>) -> T {
    let limit = Duration::from_secs(60);
    runtime().block_on(async { tokio::time::timeout(limit, work).await.expect("it hangs") })
}

/// Builds in several ways, and runs all queries and checks that the tool's commands run.
fn check(points: &[Point]) {
    let expected = reference(EngineKind::Native, points);
    let vertices = distinct(points);
    for (tile_vertices, engine) in [4, 8, 65536].into_iter().zip(EngineKind::ALL.iter().cycle()) {
        let options = options(tile_vertices).engine(*engine);
        in_time(async {
            let (_scratch, reader) = built(points, options).await;
            check_file(&reader, &vertices).await;
            assert_eq!(
                reader.recompute_digest().await.unwrap(),
                expected,
                "tiles of {tile_vertices}"
            );
            let metadata = reader.metadata();
            assert_eq!(
                (metadata.points, metadata.vertices),
                (points.len() as u64, vertices.len() as u64)
            );
        });
    }
}

async fn check_file(reader: &TileReader, vertices: &[Point]) {
    reader.verify(false).await.unwrap();
    let report = reader.verify(true).await.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(report.vertices, vertices.len() as u64);
    let tiles: Vec<_> = reader.tiles().try_collect().await.unwrap();
    let mut found: Vec<Point> = tiles.iter().flat_map(|t| t.points().collect::<Vec<_>>()).collect();
    found.sort_unstable_by(|a, b| a.lex_cmp(*b));
    assert_eq!(found, vertices);
    for &p in vertices.iter().step_by(1 + vertices.len() / 40) {
        let found = reader.locate(p.x, p.y).await.unwrap();
        assert!(matches!(found, Location::OnVertex(v) if v.point == p), "{found:?}");
    }
    let bounds = Rect::around(vertices.iter().copied());
    for p in [
        Point::new(bounds.max_x + 1.0, 0.0),
        Point::new(f64::NAN, 0.0),
        Point::new(0.0, f64::INFINITY),
    ] {
        if !bounds.contains(p) {
            assert_eq!(reader.locate(p.x, p.y).await.unwrap(), Location::Outside);
        }
    }
    let all: Vec<_> = reader.triangles_in(Rect::PLANE).try_collect().await.unwrap();
    assert_eq!(all.len() as u64, report.triangles);
}

fn points(coordinates: &[(f64, f64)]) -> Vec<Point> {
    coordinates.iter().map(|&(x, y)| Point::new(x, y)).collect()
}

#[test]
fn few_points_and_collinear_points_are_built_and_queried() {
    check(&[]);
    check(&points(&[(3.5, -1.0)]));
    check(&points(&[(-0.0, 0.0)]));
    check(&points(&[(0.0, -0.0), (-0.0, 0.0), (0.0, 0.0)]));
    check(&points(&[(3.5, -1.0), (0.0, 1e9)]));
    check(&points(&[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]));
    for (dx, dy) in [(1.0, 0.0), (0.0, 1.0), (3.0, -7.0), (0.125, 1e6)] {
        let line: Vec<_> = (0..100)
            .map(|i| Point::new(dx * f64::from(i), dy * f64::from(i)))
            .collect();
        check(&line);
        // With one point that is not on the line.
        check(&[line.clone(), points(&[(50.5, 1e-9)])].concat());
    }
}

#[test]
fn equal_points_become_one_vertex() {
    for count in [2, 9, 500] {
        check(&vec![Point::new(7.25, -3.0); count]);
        let mut two = vec![Point::new(7.25, -3.0); count];
        two.extend(vec![Point::new(7.25, 4.0); count]);
        check(&two);
        two.extend(vec![Point::new(-1.0, 4.0); count]);
        check(&two);
    }
    let mut random = Random(1);
    let few: Vec<_> = (0..800)
        .map(|_| Point::new(random.below(3) as f64, random.below(3) as f64))
        .collect();
    check(&few);
}

#[test]
fn coordinates_of_extreme_and_of_mixed_magnitudes_are_built_and_queried() {
    let mut random = Random(2);
    let mut magnitude = || {
        let sign = if random.bits().is_multiple_of(2) { 1.0 } else { -1.0 };
        sign * 10f64.powf(60.0 * random.unit() - 30.0)
    };
    let wild: Vec<_> = (0..300).map(|_| Point::new(magnitude(), magnitude())).collect();
    check(&wild);
    let steps: Vec<_> = (0..400)
        .map(|i| Point::new(1e6 + f64::from(i % 20) * 1e-3, 5e6 + f64::from(i / 20) * 1e-3))
        .collect();
    check(&steps);
    let (least, most) = (Point::MIN_MAGNITUDE, Point::MAX_MAGNITUDE);
    let ends = [least, most, -least, -most, 0.0, 1.0];
    let extremes: Vec<_> = ends
        .iter()
        .flat_map(|&x| ends.iter().map(move |&y| Point::new(x, y)))
        .collect();
    check(&extremes);
}

#[test]
fn coordinates_out_of_range_are_refused_and_nothing_is_left() {
    let scratch = Scratch::new();
    for bad in [
        1e-60,
        -1e-60,
        1e70,
        -1e70,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        5e-324,
        f64::MAX,
    ] {
        for point in [Point::new(bad, 1.0), Point::new(1.0, bad)] {
            let mut input = points_of(Kind::Uniform, 20, 1);
            input.insert(13, point);
            let result = in_time(build_batches(&scratch.path, &batches(&input, &[]), options(8)));
            assert!(
                matches!(result, Err(BuildError::InvalidPoint { record: 13, .. })),
                "{result:?}"
            );
            assert_empty(scratch.folder.path());
        }
    }
}

/// Callers fill `PointBatch`. When its arrays differed in length, a point without a record escaped
/// the check of its coordinates, and z went to other points.
#[test]
fn batches_with_arrays_of_different_lengths_or_invalid_z_are_refused() {
    let scratch = Scratch::new();
    let p = Point::new(1.0, 1.0);
    let good = PointBatch {
        points: vec![p, Point::new(2.0, 1.0)],
        z: vec![1.0, 2.0],
        records: vec![0, 1],
    };
    let with = |change: fn(&mut PointBatch)| {
        let mut batch = good.clone();
        change(&mut batch);
        batch
    };
    for bad in [
        with(|b| b.records.clear()),
        with(|b| b.records.push(2)),
        with(|b| b.z.truncate(1)),
        with(|b| b.z.push(0.0)),
        with(|b| b.z[1] = f64::NAN),
        with(|b| b.z[0] = f64::INFINITY),
        with(|b| {
            b.records.clear();
            b.points[0].x = f64::NAN;
        }),
    ] {
        let result = in_time(build_batches(&scratch.path, std::slice::from_ref(&bad), options(8)));
        assert!(
            matches!(result, Err(BuildError::Batch { .. } | BuildError::InvalidZ { .. })),
            "{bad:?}: {result:?}"
        );
        assert_empty(scratch.folder.path());
    }
}

/// Asserts that nothing is left in `folder`. A dropped build may leave files until its threads have
/// ended.
fn assert_empty(folder: &Path) {
    let mut left = Vec::new();
    for _ in 0..500 {
        left = fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name()).collect();
        if left.is_empty() {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    panic!("left behind: {left:?}");
}

/// Returns the records of a set with duplicates, in a random order.
fn permuted(random: &mut Random, set: &[(Point, f64)]) -> Vec<PointBatch> {
    let mut order: Vec<usize> = (0..set.len()).collect();
    random.shuffle(&mut order);
    let batch = |records: &[usize]| PointBatch {
        points: records.iter().map(|&i| set[i].0).collect(),
        z: records.iter().map(|&i| set[i].1).collect(),
        records: records.iter().map(|&i| i as u64).collect(),
    };
    order.chunks(37).map(batch).collect()
}

#[test]
fn the_kept_duplicate_does_not_depend_on_the_order_of_arrival() {
    let mut random = Random(3);
    let set: Vec<_> = (0..600)
        .map(|_| {
            (
                Point::new(random.below(12) as f64, random.below(12) as f64),
                random.below(4) as f64,
            )
        })
        .collect();
    for (rule, better) in [
        (Duplicates::First, (|_, _| false) as fn(f64, f64) -> bool),
        (Duplicates::Lowest, |a, b| a < b),
        (Duplicates::Highest, |a, b| a > b),
    ] {
        for tile_vertices in [4, 16, 65536] {
            for _ in 0..6 {
                let batches = permuted(&mut random, &set);
                in_time(async {
                    let scratch = Scratch::new();
                    let options = options(tile_vertices).duplicates(rule);
                    let summary = build_batches(&scratch.path, &batches, options).await.unwrap();
                    assert_eq!(summary.duplicates + summary.vertices, 600);
                    let reader = scratch.open().await;
                    reader.verify(true).await.unwrap();
                    let tiles: Vec<_> = reader.tiles().try_collect().await.unwrap();
                    for tile in tiles {
                        for v in tile.vertex_indices() {
                            let mut here = set.iter().enumerate().filter(|(_, (p, _))| *p == tile.point(v));
                            let first = here.next().unwrap();
                            let kept =
                                here.fold(first, |best, next| if better(next.1.1, best.1.1) { next } else { best });
                            assert_eq!((tile.record(v), tile.z(v)), (kept.0 as u64, Some(kept.1.1)), "{rule}");
                        }
                    }
                });
            }
        }
    }
}

/// The error used to name two records of whichever tile was built first, so it varied between runs.
#[test]
fn an_error_for_duplicates_always_names_the_same_two_records() {
    let mut random = Random(4);
    let set: Vec<_> = (0..500)
        .map(|_| (Point::new(random.below(40) as f64, random.below(40) as f64), 0.0))
        .collect();
    // The first record at the point of an earlier record, and that earlier record.
    let on_earlier = |i: usize| set[..i].iter().position(|s| s.0 == set[i].0);
    let later = (0..set.len()).find(|&i| on_earlier(i).is_some()).unwrap();
    let expected = [on_earlier(later).unwrap() as u64, later as u64];
    for round in 0..40 {
        let batches = permuted(&mut random, &set);
        let scratch = Scratch::new();
        let options = options([4, 16, 65536][round % 3])
            .duplicates(Duplicates::Error)
            .threads(1 + round % 4);
        match in_time(build_batches(&scratch.path, &batches, options)) {
            Err(BuildError::Duplicate { records, point }) => {
                assert_eq!((records, point), (expected, set[later].0), "round {round}");
            }
            other => panic!("{other:?}"),
        }
        assert_empty(scratch.folder.path());
    }
}

#[test]
fn outputs_that_cannot_be_written_are_refused_and_left_unchanged() {
    let scratch = Scratch::new();
    let start = |path: &Path, force| {
        let options = options(8).force(force);
        Builder::new(path, options).map(|_| ())
    };
    fs::write(&scratch.path, "mine").unwrap();
    assert!(matches!(start(&scratch.path, false), Err(BuildError::OutputExists(_))));
    assert_eq!(fs::read(&scratch.path).unwrap(), b"mine");
    start(&scratch.path, true).unwrap();
    assert_eq!(fs::read(&scratch.path).unwrap(), b"mine");
    let folder = scratch.folder.path();
    assert!(matches!(start(folder, true), Err(BuildError::Io { .. })));
    assert!(matches!(
        start(&folder.join("missing/a.tiles"), false),
        Err(BuildError::Io { .. })
    ));
    assert!(matches!(start(Path::new("/"), true), Err(BuildError::Io { .. })));
    assert!(matches!(start(Path::new(""), true), Err(BuildError::Io { .. })));
    assert_eq!(fs::read_dir(folder).unwrap().count(), 1);
    // With `force` the file is replaced, but only once the build has succeeded.
    let options = options(8).force(true);
    let input = points_of(Kind::Uniform, 50, 1);
    in_time(build_batches(&scratch.path, &batches(&input, &[]), options)).unwrap();
    in_time(async { scratch.open().await.verify(true).await.unwrap() });
    assert_eq!(fs::read_dir(folder).unwrap().count(), 1);
}

#[test]
fn an_output_that_appears_during_the_build_is_not_overwritten() {
    let scratch = Scratch::new();
    let result = in_time(async {
        let builder = Builder::new(&scratch.path, options(8)).unwrap();
        fs::write(&scratch.path, "theirs").unwrap();
        builder.finish().await
    });
    assert!(matches!(result, Err(BuildError::OutputExists(_))), "{result:?}");
    assert_eq!(fs::read(&scratch.path).unwrap(), b"theirs");
}

#[test]
fn foreign_work_folders_are_not_touched_and_dead_ones_are_taken_over() {
    let scratch = Scratch::new();
    let partial = scratch.folder.path().join("test.tiles.partial");
    let start = || Builder::new(&scratch.path, options(8));

    let first = start().unwrap();
    assert!(matches!(start(), Err(BuildError::Locked(_))));
    drop(first);
    assert_empty(scratch.folder.path());

    // A folder of another program, a file, and a folder that resembles a work folder: all stay
    // unchanged.
    fs::create_dir(&partial).unwrap();
    fs::write(partial.join("thesis.tex"), "all of it").unwrap();
    assert!(matches!(start(), Err(BuildError::NotOurs(_))));
    assert_eq!(fs::read(partial.join("thesis.tex")).unwrap(), b"all of it");
    fs::write(partial.join("lock"), "").unwrap();
    assert!(matches!(start(), Err(BuildError::NotOurs(_))));
    assert_eq!(fs::read(partial.join("thesis.tex")).unwrap(), b"all of it");
    fs::remove_file(partial.join("thesis.tex")).unwrap();
    fs::create_dir(partial.join("drafts")).unwrap();
    fs::write(partial.join("drafts/one"), "1").unwrap();
    assert!(matches!(start(), Err(BuildError::NotOurs(_))));
    assert_eq!(fs::read(partial.join("drafts/one")).unwrap(), b"1");
    fs::remove_dir_all(&partial).unwrap();
    fs::write(&partial, "a file").unwrap();
    assert!(matches!(start(), Err(BuildError::NotOurs(_))));
    assert_eq!(fs::read(&partial).unwrap(), b"a file");
    fs::remove_file(&partial).unwrap();

    // A build takes over the work folder of a dead build, also if that died before it could lock.
    fs::create_dir(&partial).unwrap();
    drop(start().unwrap());
    assert_empty(scratch.folder.path());
    fs::create_dir(&partial).unwrap();
    fs::write(partial.join("lock"), "").unwrap();
    fs::write(partial.join("tiles"), "half a file").unwrap();
    in_time(build_batches(
        &scratch.path,
        &batches(&points_of(Kind::Grid, 40, 1), &[]),
        options(8),
    ))
    .unwrap();
    assert_eq!(fs::read_dir(scratch.folder.path()).unwrap().count(), 1);
}

#[test]
fn dropped_builds_leave_no_files() {
    let input = points_of(Kind::Uniform, 3000, 1);
    let scratch = Scratch::new();
    let mut builder = Builder::new(&scratch.path, options(8)).unwrap();
    in_time(async {
        for batch in batches(&input, &[]) {
            builder.push(&batch).await.unwrap();
        }
    });
    drop(builder);
    assert_empty(scratch.folder.path());
    // Futures that are dropped at various moments.
    let mut finished = 0;
    for micros in (0..40).map(|i| i * i * 60) {
        let runtime = runtime();
        runtime.block_on(async {
            let batches = batches(&input, &[]);
            let building = build_batches(&scratch.path, &batches, options(8));
            finished += usize::from(
                tokio::time::timeout(Duration::from_micros(micros), building)
                    .await
                    .is_ok(),
            );
        });
        let _ = fs::remove_file(&scratch.path);
        assert_empty(scratch.folder.path());
    }
    println!("{finished} of 40 were faster");
}

#[test]
fn cancelled_builds_leave_no_files() {
    let input = points_of(Kind::Uniform, 3000, 1);
    let scratch = Scratch::new();
    let mut cancelled_in = [0; 5];
    for round in 0..60u64 {
        let progress = Arc::<Progress>::default();
        let options = options(8)
            .progress(Arc::clone(&progress))
            .threads(1 + round as usize % 4);
        let others = Arc::clone(&progress);
        let result = in_time(async {
            let wanted = Phase::ALL[round as usize % 5];
            let canceller = std::thread::spawn(move || {
                let began = std::time::Instant::now();
                while others.state().0 as u8 != wanted as u8 && began.elapsed() < Duration::from_millis(300) {
                    std::thread::yield_now();
                }
                std::thread::sleep(Duration::from_micros(Random(round).bits() % 400));
                others.cancel();
            });
            let result = build_batches(&scratch.path, &batches(&input, &[]), options).await;
            let phase = progress.state().0;
            canceller.join().unwrap();
            result.map_err(|error| (error, phase))
        });
        match result {
            Err((BuildError::Cancelled, phase)) => cancelled_in[phase as usize] += 1,
            Err(other) => panic!("{other:?}"),
            Ok(_) => {
                in_time(async { scratch.open().await.verify(false).await.unwrap() });
                fs::remove_file(&scratch.path).unwrap();
            }
        }
        assert_empty(scratch.folder.path());
    }
    println!("cancelled in each phase: {cancelled_in:?}");
    assert!(cancelled_in.iter().sum::<i32>() > 10, "{cancelled_in:?}");
}

#[test]
fn budgets_and_options_out_of_range_are_refused() {
    let scratch = Scratch::new();
    let input = batches(&points_of(Kind::Uniform, 5000, 1), &[]);
    for memory in [0, 1, 20_000] {
        let options = options(64).memory(memory);
        let result = in_time(build_batches(&scratch.path, &input, options));
        assert!(
            matches!(result, Err(BuildError::Memory(MemoryShortage { of: MemoryUse::Tile, budget, .. })) if budget == memory),
            "{result:?}"
        );
        assert_empty(scratch.folder.path());
    }
    for tile_vertices in [0, 1, 3, BuildOptions::MAX_TILE_VERTICES + 1, usize::MAX] {
        let result = Builder::new(&scratch.path, options(tile_vertices)).map(|_| ());
        assert!(matches!(result, Err(BuildError::Option { .. })), "{result:?}");
    }
    for threads in [0, usize::MAX] {
        let options = options(8).threads(threads);
        assert!(matches!(
            Builder::new(&scratch.path, options),
            Err(BuildError::Option { .. })
        ));
    }
    assert_empty(scratch.folder.path());
}

#[test]
fn more_threads_than_tiles_give_the_same_digest() {
    for n in [0, 1, 4, 12, 20, 100] {
        let input = points_of(Kind::Uniform, n, n);
        let expected = reference(EngineKind::Native, &input);
        for threads in 1..=8 {
            for merge_vertices in [0, 16, 1 << 16] {
                let options = options(4).threads(threads).merge_vertices(merge_vertices);
                let digest = in_time(async { built(&input, options).await.1.recompute_digest().await.unwrap() });
                assert_eq!(digest, expected, "{n} points, {threads} threads");
            }
        }
    }
}

/// A full disk; skipped if this process may not mount one.
#[test]
fn a_build_on_a_full_disk_returns_a_disk_error_and_leaves_no_files() {
    let folder = tempfile::tempdir().unwrap();
    let mount = |args: &[&str]| {
        let status = std::process::Command::new(args[0])
            .args(&args[1..])
            .arg(folder.path())
            .output();
        status.is_ok_and(|output| output.status.success())
    };
    if !mount(&["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs"]) {
        println!("skipped: no tmpfs can be mounted here");
        return;
    }
    let input = batches(&points_of(Kind::Uniform, 3000, 1), &[]);
    let result = in_time(build_batches(&folder.path().join("a.tiles"), &input, options(64)));
    let left = fs::read_dir(folder.path()).unwrap().count();
    assert!(mount(&["umount"]));
    assert!(matches!(result, Err(BuildError::Disk { .. })), "{result:?}");
    assert_eq!(left, 0);
}

#[test]
fn calls_that_must_precede_points_are_refused_after_them() {
    let scratch = Scratch::new();
    runtime().block_on(async {
        let mut builder = Builder::new(&scratch.path, options(8)).unwrap();
        for batch in batches(&points_of(Kind::Uniform, 100, 1), &[]) {
            builder.push(&batch).await.unwrap();
        }
        let (a, b) = (Point::new(0.25, 0.5), Point::new(0.75, 0.5));
        let refused = [
            ("expect", builder.expect(100, Vec::new())),
            ("push_segments", builder.push_segments(&[[a, b]])),
            (
                "push_lines",
                builder.push_lines(LineKind::Wall, 0, &SegmentBatch::default()),
            ),
            ("push_seeds", builder.push_seeds(&[a])),
            ("push_sites", builder.push_sites(&SiteBatch::default())),
        ];
        for (name, refused) in refused {
            assert!(
                matches!(refused, Err(BuildError::Order { call }) if call == name),
                "{name}: {refused:?}"
            );
        }
        // The refused calls change nothing.
        assert_eq!(builder.finish().await.unwrap().vertices, 100);
    });
}
