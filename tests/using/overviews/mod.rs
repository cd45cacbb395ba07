//! The promise: overviews are coarser Delaunay triangulations of the same surface, the same whatever the
//! tiles, the memory, the threads and the order; they belong to one generation of a file; and making them
//! leaves the file as it was, or with all of them.

mod files;
mod proofs;

use std::path::Path;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{PointBatch, SegmentBatch};
use delaunay_tiles::overviews::{OverviewError, OverviewOptions, OverviewSummary, make};
use delaunay_tiles::store::{Digest, LineKind};
use delaunay_tiles::{BuildOptions, EditOptions, Editor, TileReader, overviews};
use distributions::Kind;
use futures::TryStreamExt;

use crate::support::{Random, Scratch, batches, build_batches, points_of, runtime};

/// The z of a hilly surface with a plain.
fn height(p: Point) -> f64 {
    let hills = (p.x * 9.0).sin() * (p.y * 7.0).cos() + (p.x * 31.0).sin() / 7.0;
    if p.x > 0.7 { 0.5 } else { hills }
}

/// Points of a distribution in the unit square, with z.
fn hills(kind: Kind, count: u64) -> (Vec<Point>, Vec<f64>) {
    let points = points_of(kind, count, 5);
    let z = points.iter().map(|&p| height(p)).collect();
    (points, z)
}

async fn file(points: &[Point], z: &[f64], tile_vertices: usize) -> Scratch {
    file_of(&batches(points, z), tile_vertices).await
}

async fn file_of(batches: &[PointBatch], tile_vertices: usize) -> Scratch {
    let scratch = Scratch::new();
    let options = BuildOptions::default().tile_vertices(tile_vertices);
    build_batches(&scratch.path, batches, options).await.unwrap();
    scratch
}

async fn with_overviews(points: &[Point], z: &[f64], tile_vertices: usize) -> Scratch {
    let scratch = file(points, z, tile_vertices).await;
    make_small(&scratch.path).await.unwrap();
    scratch
}

/// Makes overviews in little memory.
async fn make_small(path: &Path) -> Result<OverviewSummary, OverviewError> {
    make(path, OverviewOptions::default().memory(64 << 20).threads(2)).await
}

/// Opens all levels, the file first.
async fn levels(scratch: &Scratch) -> Vec<TileReader> {
    let reader = scratch.open().await;
    let mut levels = vec![reader.clone()];
    for level in 0..reader.overviews().len() {
        levels.push(reader.overview(level).await.unwrap());
    }
    levels
}

async fn digests(scratch: &Scratch) -> Vec<Digest> {
    let mut digests = Vec::new();
    for level in levels(scratch).await {
        digests.push(level.recompute_digest().await.unwrap());
    }
    digests
}

/// Returns all vertices, sorted: position, z and record number.
async fn vertices(reader: &TileReader) -> Vec<(Point, Option<f64>, u64)> {
    let tiles: Vec<_> = reader.tiles().try_collect().await.unwrap();
    let of_tile = |tile: &std::sync::Arc<delaunay_tiles::store::Tile>| {
        let all = tile.vertex_indices();
        all.map(|v| (tile.point(v), tile.z(v), tile.record(v)))
            .collect::<Vec<_>>()
    };
    let mut all: Vec<_> = tiles.iter().flat_map(of_tile).collect();
    all.sort_by(|a, b| a.0.lex_cmp(b.0));
    all
}

async fn add_wall(scratch: &Scratch) {
    let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(64 << 20))
        .await
        .unwrap()
        .begin()
        .await
        .unwrap();
    let wall = SegmentBatch {
        ends: vec![[Point::new(0.4, 0.4), Point::new(0.6, 0.5)]],
        lines: vec![0],
        ..SegmentBatch::default()
    };
    transaction.constrain(LineKind::Wall, 0, &wall).unwrap();
    transaction.commit().await.unwrap();
}

#[test]
fn overviews_do_not_depend_on_tiles_memory_threads_or_order() {
    runtime().block_on(async {
        let (mut points, mut z) = hills(Kind::Uniform, 6000);
        for has_z in [true, false] {
            let z_of = |z: &[f64]| if has_z { z.to_vec() } else { Vec::new() };
            let scratch = with_overviews(&points, &z_of(&z), 100).await;
            let expected = digests(&scratch).await;
            assert!(expected.len() >= 3, "{}", expected.len());
            let said = scratch.open().await.overviews().to_vec();
            for (tile_vertices, memory, threads) in [(60, 1 << 30, 1), (150, 8 << 20, 3), (61, 256 << 20, 2)] {
                // Another order of arrival.
                let mut order: Vec<usize> = (0..points.len()).collect();
                Random(memory).shuffle(&mut order);
                (points, z) = order.iter().map(|&i| (points[i], z[i])).unzip();
                let other = file(&points, &z_of(&z), tile_vertices).await;
                let options = OverviewOptions::default().memory(memory).threads(threads);
                make(&other.path, options).await.unwrap();
                let common = digests(&other).await;
                for (level, (a, b)) in expected.iter().zip(&common).enumerate() {
                    assert_eq!(a, b, "level {level}, tiles of {tile_vertices}");
                }
                let errors = |overview: &delaunay_tiles::store::Overview| (overview.largest_error, overview.rms_error);
                for (a, b) in said.iter().zip(other.open().await.overviews()) {
                    assert_eq!(errors(a), errors(b));
                }
            }
        }
    });
}

#[test]
fn levels_are_nested_down_to_one_tile_with_z_and_record_numbers() {
    runtime().block_on(async {
        for kind in [Kind::Uniform, Kind::Clusters, Kind::Grid] {
            let (points, z) = hills(kind, 8000);
            let scratch = with_overviews(&points, &z, 100).await;
            let levels = levels(&scratch).await;
            assert!(levels.len() >= 4, "{kind:?}: {} levels", levels.len());
            assert_eq!(levels.last().unwrap().metadata().tiles, 1);
            let mut finer = vertices(&levels[0]).await;
            for level in &levels[1..] {
                let coarser = vertices(level).await;
                let is_in = |v: &(Point, Option<f64>, u64)| {
                    let place = finer.binary_search_by(|other| other.0.lex_cmp(v.0));
                    place.is_ok_and(|place| finer[place] == *v)
                };
                assert!(coarser.iter().all(is_in));
                let share = coarser.len() as f64 / finer.len() as f64;
                assert!((0.15..0.27).contains(&share), "{kind:?}: {share}");
                assert_eq!(level.metadata().bounds, levels[0].metadata().bounds);
                finer = coarser;
            }
        }
    });
}

#[test]
fn errors_are_those_of_the_surface_at_all_vertices() {
    runtime().block_on(async {
        let (points, z) = hills(Kind::Uniform, 4000);
        let scratch = with_overviews(&points, &z, 100).await;
        let reader = scratch.open().await;
        let mut before = 0.0;
        for (level, overview) in reader.overviews().iter().enumerate() {
            let surface = reader.overview(level).await.unwrap();
            let found = surface
                .surface_z_many(points.clone(), Default::default(), Default::default())
                .await
                .unwrap();
            let errors: Vec<f64> = found.iter().zip(&z).map(|(a, b)| (a - b).abs()).collect();
            let largest = errors.iter().copied().fold(0.0, f64::max);
            let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
            assert_eq!(overview.largest_error, largest);
            assert!(
                (overview.rms_error / rms - 1.0).abs() < 1e-12,
                "{} {rms}",
                overview.rms_error
            );
            assert!(overview.rms_error > before);
            before = overview.rms_error;
        }
    });
}

#[test]
fn flat_ground_has_fewer_vertices_than_hills() {
    runtime().block_on(async {
        let (points, z) = hills(Kind::Uniform, 20_000);
        let scratch = with_overviews(&points, &z, 500).await;
        let level = &levels(&scratch).await[1];
        let all = vertices(level).await;
        let flat = all.iter().filter(|(p, ..)| p.x > 0.72).count();
        // 28 % of the area.
        let (flat, hilly) = (flat as f64 / 0.28, (all.len() - flat) as f64 / 0.72);
        assert!(flat < hilly * 2.0 / 3.0, "{flat} {hilly}");
    });
}

#[test]
fn an_edit_makes_overviews_stale_until_they_are_renewed() {
    runtime().block_on(async {
        let (points, z) = hills(Kind::Uniform, 3000);
        let scratch = with_overviews(&points, &z, 100).await;
        let before = scratch.open().await;
        let count = before.overviews().len();
        assert!(count > 1 && before.stale_overviews().is_empty());
        add_wall(&scratch).await;
        let edited = scratch.open().await;
        assert_eq!((edited.overviews().len(), edited.stale_overviews().len()), (0, count));
        assert_eq!(edited.stale_overviews(), before.overviews());
        add_wall_again(&scratch).await;
        assert_eq!(scratch.open().await.stale_overviews().len(), count);
        // A reader of the generation before still has them.
        let level = before.overview(0).await.unwrap();
        level.verify(true).await.unwrap();
        let summary = make_small(&scratch.path).await.unwrap();
        assert!(summary.is_new);
        let renewed = scratch.open().await;
        assert_eq!((renewed.overviews().len(), renewed.stale_overviews().len()), (count, 0));
        renewed.verify(true).await.unwrap();
        assert_eq!(overviews::verify(&renewed, true).await.unwrap(), count);
        assert!(renewed.metadata().constraint_edges > 0);
        // Nothing is to do now.
        let again = make_small(&scratch.path).await.unwrap();
        assert!(!again.is_new && again.overviews == renewed.overviews());
        assert_eq!(scratch.open().await.generation(), renewed.generation());
    });
}

async fn add_wall_again(scratch: &Scratch) {
    let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(64 << 20))
        .await
        .unwrap()
        .begin()
        .await
        .unwrap();
    let wall = SegmentBatch {
        ends: vec![[Point::new(0.2, 0.7), Point::new(0.3, 0.8)]],
        lines: vec![0],
        ..SegmentBatch::default()
    };
    transaction.constrain(LineKind::Wall, 0, &wall).unwrap();
    transaction.commit().await.unwrap();
}

#[test]
fn compacting_keeps_fresh_overviews_and_drops_stale_ones() {
    runtime().block_on(async {
        let (points, z) = hills(Kind::Uniform, 3000);
        let scratch = with_overviews(&points, &z, 100).await;
        let (expected, said) = (digests(&scratch).await, scratch.open().await.overviews().to_vec());
        // Twice, so that the file has bytes that nobody uses.
        make(&scratch.path, OverviewOptions::default().again(true))
            .await
            .unwrap();
        let reader = scratch.open().await;
        let length = reader.compact(&scratch.path).await.unwrap();
        assert!(length < reader.file_length());
        let compacted = scratch.open().await;
        assert_eq!(digests(&scratch).await, expected);
        assert_eq!(compacted.overviews(), said);
        assert_eq!(overviews::verify(&compacted, true).await.unwrap(), said.len());
        add_wall(&scratch).await;
        scratch.open().await.compact(&scratch.path).await.unwrap();
        let compacted = scratch.open().await;
        assert!(compacted.overviews().is_empty() && compacted.stale_overviews().is_empty());
        compacted.verify(true).await.unwrap();
    });
}

#[test]
fn removed_overviews_are_gone() {
    runtime().block_on(async {
        let (points, z) = hills(Kind::Uniform, 3000);
        let scratch = with_overviews(&points, &z, 100).await;
        let count = scratch.open().await.overviews().len();
        assert_eq!(overviews::remove(&scratch.path).await.unwrap(), count);
        let reader = scratch.open().await;
        assert!(reader.overviews().is_empty() && reader.stale_overviews().is_empty());
        assert_eq!(overviews::remove(&scratch.path).await.unwrap(), 0);
        assert_eq!(scratch.open().await.generation(), reader.generation());
    });
}

#[test]
fn files_that_need_no_overviews_get_none_and_are_not_changed() {
    runtime().block_on(async {
        let line: Vec<Point> = (0..500).map(|i| Point::new(f64::from(i), f64::from(2 * i))).collect();
        let (few, _) = hills(Kind::Uniform, 90);
        for points in [Vec::new(), few, line] {
            let scratch = file(&points, &[], 100).await;
            let before = std::fs::read(&scratch.path).unwrap();
            let summary = make_small(&scratch.path).await.unwrap();
            assert!(!summary.is_new && summary.overviews.is_empty());
            assert!(std::fs::read(&scratch.path).unwrap() == before);
        }
    });
}

#[test]
fn duplicates_flat_ground_and_points_on_a_circle_have_sound_overviews() {
    runtime().block_on(async {
        let (mut points, _) = hills(Kind::Uniform, 2000);
        points.extend_from_within(..500);
        let flat = vec![7.5; points.len()];
        let circle: Vec<Point> = (0..900)
            .map(|i| f64::from(i) / 900.0 * std::f64::consts::TAU)
            .map(|angle| Point::new(angle.cos(), angle.sin()))
            .collect();
        let mut rough = vec![0.0; points.len()];
        rough.iter_mut().step_by(7).for_each(|z| *z = 1e300);
        rough.iter_mut().step_by(11).for_each(|z| *z = -1.7e308);
        for (points, z) in [(&points, flat), (&circle, vec![0.0; 900]), (&points, rough)] {
            let scratch = with_overviews(points, &z, 64).await;
            let reader = scratch.open().await;
            overviews::verify(&reader, true).await.unwrap();
            for overview in reader.overviews() {
                assert!(overview.largest_error.is_finite() && overview.rms_error.is_finite());
            }
            // No level can leave out a corner of the hull.
            assert_eq!(reader.overviews().is_empty(), points.len() == 900);
        }
    });
}

#[test]
fn overviews_of_a_compressed_file_are_compressed() {
    use delaunay_tiles::store::Codec;

    runtime().block_on(async {
        let (points, z) = hills(Kind::Uniform, 3000);
        let scratch = Scratch::new();
        let options = BuildOptions::default().tile_vertices(100).compress(true);
        build_batches(&scratch.path, &batches(&points, &z), options)
            .await
            .unwrap();
        make_small(&scratch.path).await.unwrap();
        let raw = with_overviews(&points, &z, 100).await;
        assert_eq!(digests(&scratch).await, digests(&raw).await);
        for (scratch, codec) in [(&scratch, Codec::Zstandard), (&raw, Codec::Raw)] {
            let level = scratch.open().await.overview(0).await.unwrap();
            let directory = level.directory().await.unwrap();
            assert!(directory.tiles.iter().all(|tile| tile.core.codec == codec));
        }
    });
}
