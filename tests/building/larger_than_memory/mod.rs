//! The promise: points that exceed the memory give the same triangles.

mod input_tasks;
mod inputs;
mod parts;
mod resumed;
mod stored;
mod tasks;

use std::collections::HashMap;
use std::fs;
use std::sync::Arc;

use crate::support::cases::by_turns;
use crate::support::{Random, Scratch, batches, build_batches, points_of, reference, runtime};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::PointBatch;
use delaunay_tiles::mesh::EngineKind;
use delaunay_tiles::store::{Digest, PointOrigin};
use delaunay_tiles::{BuildError, BuildOptions, Builder, Duplicates, MemoryShortage, MemoryUse, MissingZ, Phase};
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
