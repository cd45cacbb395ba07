//! The promise: points that exceed the memory give the same triangles, and a stopped build can be
//! resumed.

mod resumed;

use std::collections::HashMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use crate::support::cases::by_turns;
use crate::support::{Random, Scratch, batches, build_batches, points_of, reference, runtime};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::PointBatch;
use delaunay_tiles::mesh::EngineKind;
use delaunay_tiles::store::{Digest, PointOrigin};
use delaunay_tiles::{
    BuildError, BuildOptions, BuildSummary, Builder, Description, Duplicates, MemoryShortage, MemoryUse, MissingZ,
    Phase,
};
use distributions::Kind;

/// Too little memory for 100,000 points, which take 2 MB, but enough for two threads with tiles of
/// 1000 vertices.
const LITTLE: u64 = 1_500_000;

fn options(memory: u64, threads: usize) -> BuildOptions {
    BuildOptions::default()
        .tile_vertices(1000)
        .memory(memory)
        .threads(threads)
}

/// Returns options of a build that can be resumed; with `resume`, of one that resumes.
fn resumable(resume: bool) -> BuildOptions {
    options(2_500_000, 2)
        .resumable(Some("points: 1\nothers: 2".to_owned()))
        .resume(resume)
}

async fn digest_of(scratch: &Scratch) -> Digest {
    let reader = scratch.open().await;
    if let Err(error) = reader.verify(true).await {
        panic!("{error}");
    }
    reader.recompute_digest().await.unwrap()
}

/// Returns the names in the file's folder, sorted.
fn left(scratch: &Scratch) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(scratch.folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort_unstable();
    names
}

#[test]
fn every_distribution_gives_one_triangulation_in_any_memory() {
    runtime().block_on(async {
        for (round, kind) in Kind::ALL.into_iter().enumerate() {
            let points = points_of(kind, 100_000, 3);
            let expected = reference(EngineKind::Native, &points);
            let ways = [(LITTLE, 1), (LITTLE, 3), (2_000_000, 2), (64 << 20, 2)];
            for (memory, threads) in by_turns(&ways, round) {
                let scratch = Scratch::new();
                let built = build_batches(&scratch.path, &batches(&points, &[]), options(memory, threads)).await;
                let summary = match built {
                    // Every point of this distribution is in every seam. Another test checks the
                    // memory that it needs.
                    Err(BuildError::Memory(MemoryShortage {
                        of: MemoryUse::Seams, ..
                    })) if memory < 64 << 20 => continue,
                    built => built.unwrap(),
                };
                assert_eq!(summary.points, 100_000);
                if memory == LITTLE {
                    assert!(summary.blocks > 1, "{kind}: {} blocks", summary.blocks);
                }
                assert_eq!(digest_of(&scratch).await, expected, "{kind} in {memory} bytes");
                assert_eq!(left(&scratch), ["test.tiles"]);
            }
        }
    });
}

/// The beginning of the stream says nothing of the rest, so the runs of its last cells must be
/// split again.
#[test]
fn sorted_points_and_false_expectations_give_the_same_triangulation() {
    let mut points = points_of(Kind::Uniform, 150_000, 1);
    points.sort_unstable_by(|a, b| a.lex_cmp(*b));
    let expected = reference(EngineKind::Native, &points);
    let far = Point::new(1e9, -1e9);
    runtime().block_on(async {
        let scratch = Scratch::new();
        let summary = build_batches(&scratch.path, &batches(&points, &[]), options(LITTLE, 2))
            .await
            .unwrap();
        let divide = &summary.phases[1];
        assert!(
            divide.bytes_read > 0 && divide.bytes_written > 0,
            "no run was split again"
        );
        assert_eq!(digest_of(&scratch).await, expected);

        // A sample that is unrelated to the points, and a wrong number of points.
        for (count, sample) in [(1 << 40, vec![far; 5]), (125_000, vec![far, Point::new(0.5, 0.5)])] {
            let scratch = Scratch::new();
            let mut builder = Builder::new(&scratch.path, options(LITTLE, 2)).unwrap();
            match builder.expect(count, sample) {
                Err(BuildError::Disk { needed, free, .. }) if count > 1 << 30 => assert!(needed > free),
                expected => expected.unwrap(),
            }
            for batch in batches(&points, &[]) {
                builder.push(&batch).await.unwrap();
            }
            builder.finish().await.unwrap();
            assert_eq!(digest_of(&scratch).await, expected);
        }
    });
}

/// More records at one point than a block may have.
#[test]
fn equal_points_in_runs_on_disk_become_one_vertex() {
    let mut random = Random(5);
    let repeated = [Point::new(0.25, 0.75), Point::new(0.5, 0.5)];
    let mut points = points_of(Kind::Uniform, 3000, 1);
    points.extend((0..120_000).map(|i| repeated[i % 2]));
    random.shuffle(&mut points);
    let z: Vec<f64> = points.iter().map(|_| (random.unit() * 1000.0).floor()).collect();
    let expected = reference(EngineKind::Native, &points);
    runtime().block_on(async {
        for rule in [Duplicates::First, Duplicates::Lowest, Duplicates::Highest] {
            let scratch = Scratch::new();
            let options = options(LITTLE, 2).duplicates(rule);
            let summary = build_batches(&scratch.path, &batches(&points, &z), options)
                .await
                .unwrap();
            assert_eq!(summary.duplicates, 123_000 - summary.vertices, "{rule}");
            let mut expected = expected;
            let mut kept: HashMap<[u64; 2], (Point, f64)> = HashMap::new();
            for (&p, &z) in points.iter().zip(&z) {
                let (_, kept) = kept.entry([p.x, p.y].map(f64::to_bits)).or_insert((p, z));
                *kept = match rule {
                    Duplicates::Lowest => kept.min(z),
                    Duplicates::Highest => kept.max(z),
                    _ => *kept,
                };
            }
            kept.into_values().for_each(|(p, z)| expected.add_z(p, z));
            assert_eq!(digest_of(&scratch).await, expected, "{rule}");
            let mut next = batches(&points, &z).into_iter();
            if rule == Duplicates::First {
                let reader = scratch.open().await;
                let report = reader
                    .verify_points(|batch: &mut PointBatch| {
                        let more = next.next();
                        *batch = more.clone().unwrap_or_default();
                        Ok::<_, BuildError>(more.map(|_| PointOrigin::Input))
                    })
                    .await;
                report.unwrap();
            }
        }
        let error = options(LITTLE, 2).duplicates(Duplicates::Error);
        let second = |point: Point| {
            points
                .iter()
                .enumerate()
                .filter(move |(_, p)| **p == point)
                .nth(1)
                .unwrap()
                .0
        };
        let first = repeated.into_iter().map(second).min().unwrap() as u64;
        let scratch = Scratch::new();
        let built = build_batches(&scratch.path, &batches(&points, &z), error).await;
        assert!(
            matches!(built, Err(BuildError::Duplicate { records, .. }) if records[1] == first),
            "{built:?}, not {first}"
        );
        assert_eq!(left(&scratch), [""; 0]);
    });
}

#[test]
fn runs_on_disk_keep_z_and_records_beyond_32_bits() {
    let points = points_of(Kind::Uniform, 100_000, 4);
    let z: Vec<f64> = (0..100_000).map(f64::from).collect();
    for with_z in [false, true] {
        let mut input = batches(&points, if with_z { &z } else { &[] });
        let shift = u64::from(u32::MAX) - 50_000;
        input
            .iter_mut()
            .flat_map(|batch| &mut batch.records)
            .for_each(|record| *record += shift);
        if with_z {
            // z may come late; earlier points get 0.
            input[..10].iter_mut().for_each(|batch| batch.z.clear());
        }
        runtime().block_on(async {
            let scratch = Scratch::new();
            let options = options(LITTLE, 2).missing_z(MissingZ::Zero);
            let summary = build_batches(&scratch.path, &input, options).await.unwrap();
            assert!(summary.blocks > 1);
            let reader = scratch.open().await;
            let expected = |batch: &PointBatch, i: usize| {
                let z = batch.z.get(i).copied().unwrap_or(0.0);
                (batch.points[i], batch.records[i], z)
            };
            let mut all = input
                .iter()
                .flat_map(|batch| (0..batch.points.len()).map(move |i| expected(batch, i)));
            let mut next = input.iter().cloned().map(|mut batch| {
                batch.z.resize(if with_z { batch.points.len() } else { 0 }, 0.0);
                batch
            });
            reader
                .verify_points(|batch: &mut PointBatch| {
                    let more = next.next();
                    *batch = more.clone().unwrap_or_default();
                    Ok::<_, BuildError>(more.map(|_| PointOrigin::Input))
                })
                .await
                .unwrap();
            assert!(all.all(|(_, record, _)| record >= shift));
        });
    }
}

/// On a curve every point is in every seam; the build detects this early.
#[test]
fn a_seam_larger_than_the_memory_is_refused_early_with_the_memory_needed() {
    let points = points_of(Kind::Parabola, 200_000, 1);
    runtime().block_on(async {
        let scratch = Scratch::new();
        // With several threads, some continue to conquer while another one runs the merge that
        // detects it.
        let options = options(2_500_000, 1);
        let progress = Arc::clone(&options.progress);
        let built = build_batches(&scratch.path, &batches(&points, &[]), options.clone()).await;
        let Err(BuildError::Memory(MemoryShortage {
            of: MemoryUse::Seams,
            needed,
            budget,
        })) = built
        else {
            panic!("{built:?}");
        };
        assert_eq!(budget, 2_500_000);
        let (phase, done, _) = progress.state();
        assert_eq!(phase, Phase::Conquer);
        assert!(done <= 200_000 / 10, "{done} points were conquered first");
        assert_eq!(left(&scratch), [""; 0]);
        // With the memory that the error asked for, the build succeeds.
        let more = options.memory(needed + (2 << 20)).progress(Arc::default());
        build_batches(&scratch.path, &batches(&points, &[]), more)
            .await
            .unwrap();
        assert_eq!(digest_of(&scratch).await, reference(EngineKind::Native, &points));
    });
}

/// Builds, and cancels the build once `until` points were conquered. Points are pushed only if they
/// are needed.
async fn build_until(
    scratch: &Scratch,
    points: &[Point],
    options: BuildOptions,
    until: u64,
) -> Result<BuildSummary, BuildError> {
    let progress = Arc::clone(&options.progress);
    let watch = tokio::spawn(async move {
        loop {
            let (phase, done, _) = progress.state();
            if phase == Phase::Conquer && done >= until {
                return progress.cancel();
            }
            tokio::time::sleep(Duration::from_micros(200)).await;
        }
    });
    let mut builder = Builder::new(&scratch.path, options)?;
    if builder.needs_points() {
        for batch in batches(points, &[]) {
            builder.push(&batch).await?;
        }
        builder.describe(Description {
            memo: "note".to_owned(),
            ..Description::default()
        });
    }
    assert_eq!(builder.description().memo, "note");
    let built = builder.finish().await;
    watch.abort();
    built
}

#[test]
fn a_cancelled_build_resumes_and_gives_the_same_bytes() {
    let points = points_of(Kind::Kuzmin, 200_000, 2);
    let expected = reference(EngineKind::Native, &points);
    runtime().block_on(async {
        let whole = Scratch::new();
        build_batches(&whole.path, &batches(&points, &[]), resumable(false))
            .await
            .unwrap();
        let mut resumed_blocks = 0;
        for until in [0, 50_000, 100_000, 150_000, 195_000] {
            let scratch = Scratch::new();
            let cancelled = build_until(&scratch, &points, resumable(false), until).await;
            if cancelled.is_ok() {
                continue;
            }
            assert!(matches!(cancelled, Err(BuildError::Cancelled)), "{cancelled:?}");
            assert_eq!(left(&scratch), ["test.tiles.partial"]);
            // Interrupted for the second time.
            let again = resumable(true).threads(1);
            let _ = build_until(&scratch, &points, again, until + 20_000).await;
            if !scratch.path.exists() {
                let summary = build_until(&scratch, &points, resumable(true), u64::MAX).await.unwrap();
                resumed_blocks += summary.resumed_blocks;
            }
            assert_eq!(digest_of(&scratch).await, expected);
            assert!(
                fs::read(&scratch.path).unwrap() == fs::read(&whole.path).unwrap(),
                "the file differs"
            );
            assert_eq!(left(&scratch), ["test.tiles"]);
        }
        assert!(resumed_blocks > 0, "no build went on from a finished block");
    });
}

/// A caller that drops its future, as a service does at shutdown, loses no work.
#[test]
fn a_dropped_build_resumes() {
    let points = points_of(Kind::Uniform, 200_000, 5);
    let expected = reference(EngineKind::Native, &points);
    runtime().block_on(async {
        let scratch = Scratch::new();
        let options = resumable(false);
        let progress = Arc::clone(&options.progress);
        let mut builder = Builder::new(&scratch.path, options).unwrap();
        for batch in batches(&points, &[]) {
            builder.push(&batch).await.unwrap();
        }
        let far = async {
            while !matches!(progress.state(), (Phase::Conquer, done, _) if done >= 100_000) {
                tokio::time::sleep(Duration::from_micros(200)).await;
            }
        };
        tokio::select! {
            built = builder.finish() => panic!("it was not stopped: {built:?}"),
            () = far => {}
        }
        assert_eq!(left(&scratch), ["test.tiles.partial"]);
        // The threads of the build hold the lock until they have ended.
        let mut again = Builder::new(&scratch.path, resumable(true));
        for _ in 0..500 {
            if !matches!(again, Err(BuildError::Locked(_))) {
                break;
            }
            tokio::time::sleep(Duration::from_millis(10)).await;
            again = Builder::new(&scratch.path, resumable(true));
        }
        let again = again.unwrap();
        assert!(!again.needs_points(), "the work is gone");
        again.finish().await.unwrap();
        assert_eq!(digest_of(&scratch).await, expected);
        assert_eq!(left(&scratch), ["test.tiles"]);
    });
}

/// As if the build was killed after it gave the file its name: there is nothing to resume.
#[test]
fn a_resume_clears_what_a_published_build_left() {
    let points = points_of(Kind::Uniform, 200_000, 6);
    runtime().block_on(async {
        let scratch = Scratch::new();
        let cancelled = build_until(&scratch, &points, resumable(false), 100_000).await;
        assert!(matches!(cancelled, Err(BuildError::Cancelled)), "{cancelled:?}");
        let mut partial = scratch.path.clone().into_os_string();
        partial.push(".partial");
        fs::remove_file(Path::new(&partial).join("tiles")).unwrap();
        let mut builder = Builder::new(&scratch.path, resumable(true)).unwrap();
        assert!(builder.needs_points());
        for batch in batches(&points, &[]) {
            builder.push(&batch).await.unwrap();
        }
        builder.finish().await.unwrap();
        assert_eq!(digest_of(&scratch).await, reference(EngineKind::Native, &points));
        assert_eq!(left(&scratch), ["test.tiles"]);
    });
}

#[test]
fn other_options_other_inputs_or_too_little_memory_cannot_resume_a_build() {
    let points = points_of(Kind::Uniform, 200_000, 2);
    runtime().block_on(async {
        let scratch = Scratch::new();
        let cancelled = build_until(&scratch, &points, resumable(false), 100_000).await;
        assert!(matches!(cancelled, Err(BuildError::Cancelled)), "{cancelled:?}");
        let others = [
            resumable(true).tile_vertices(1001),
            resumable(true).duplicates(Duplicates::Lowest),
            resumable(true).resumable(Some("points: 1\nothers: 3".to_owned())),
        ];
        for other in others {
            let result = Builder::new(&scratch.path, other).map(|_| ());
            assert!(matches!(result, Err(BuildError::OtherBuild { .. })), "{result:?}");
            assert_eq!(left(&scratch), ["test.tiles.partial"]);
        }
        let nothing = resumable(true).resumable(None);
        let result = Builder::new(&scratch.path, nothing).map(|_| ());
        assert!(matches!(result, Err(BuildError::NotResumable)), "{result:?}");
        let little = resumable(true).memory(500_000);
        let result = build_until(&scratch, &points, little, u64::MAX).await;
        assert!(
            matches!(
                result,
                Err(BuildError::Memory(MemoryShortage {
                    of: MemoryUse::Tile,
                    ..
                }))
            ),
            "{result:?}"
        );

        // A resumed build does not accept points again.
        let scratch = Scratch::new();
        let cancelled = build_until(&scratch, &points, resumable(false), 100_000).await;
        assert!(matches!(cancelled, Err(BuildError::Cancelled)), "{cancelled:?}");
        let mut builder = Builder::new(&scratch.path, resumable(true)).unwrap();
        let pushed = builder.push(&batches(&points, &[])[0]).await;
        assert!(matches!(pushed, Err(BuildError::PointsComplete)), "{pushed:?}");
        drop(builder);
        // A build without `resume` removes the old work only by force.
        let refused = Builder::new(&scratch.path, resumable(false)).map(|_| ());
        assert!(
            matches!(refused, Err(BuildError::WorkKept { bytes, .. }) if bytes > 0),
            "{refused:?}"
        );
        assert_eq!(left(&scratch), ["test.tiles.partial"]);
        build_batches(&scratch.path, &batches(&points, &[]), resumable(false).force(true))
            .await
            .unwrap();
        assert_eq!(left(&scratch), ["test.tiles"]);
    });
}

/// Changed bits in runs, log and journal give an error or the same file.
#[test]
fn damaged_work_gives_an_error_or_the_same_file() {
    let points = points_of(Kind::Uniform, 200_000, 2);
    let expected = reference(EngineKind::Native, &points);
    let mut random = Random(1);
    let mut errors = 0;
    runtime().block_on(async {
        let scratch = Scratch::new();
        let cancelled = build_until(&scratch, &points, resumable(false), 100_000).await;
        assert!(matches!(cancelled, Err(BuildError::Cancelled)), "{cancelled:?}");
        let folder = scratch.folder.path().join("test.tiles.partial");
        let names: Vec<_> = fs::read_dir(&folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name())
            .collect();
        for round in 0..40 {
            let name = &names[round % names.len()];
            let copy = Scratch::new();
            let work = copy.folder.path().join("test.tiles.partial");
            fs::create_dir(&work).unwrap();
            for name in &names {
                fs::copy(folder.join(name), work.join(name)).unwrap();
            }
            // Readers check the finished file as a whole; its extents have checksums of their own.
            let mut bytes = fs::read(folder.join(name)).unwrap();
            if name == "tiles" || bytes.is_empty() {
                continue;
            }
            let bit = random.below(bytes.len() * 8);
            bytes[bit / 8] ^= 1 << (bit % 8);
            fs::write(work.join(name), bytes).unwrap();
            let built = tokio::time::timeout(Duration::from_secs(60), resume(&copy.path, &points)).await;
            match built.expect("it hangs") {
                Ok(()) => assert_eq!(digest_of(&copy).await, expected, "{name:?}"),
                Err(error) => {
                    errors += 1;
                    println!("{name:?}: {error}");
                }
            }
        }
    });
    assert!(errors > 0);
}

async fn resume(path: &Path, points: &[Point]) -> Result<(), BuildError> {
    let mut builder = Builder::new(path, resumable(true))?;
    if builder.needs_points() {
        for batch in batches(points, &[]) {
            builder.push(&batch).await?;
        }
    }
    builder.finish().await.map(|_| ())
}
