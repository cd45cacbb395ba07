//! The promise: a compressed file has the tiles of a file that is not, byte for byte once they are
//! decoded, in builds and after edits; it is smaller; and its bytes depend on nothing else.

use std::collections::HashSet;

use crate::format::codec::decoded;
use crate::support::{Random, Scratch, batches, build_batches, open_bytes, points_of, runtime};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::store::{Codec, Digest, Extent, LineKind, LineSource, TileReader};
use delaunay_tiles::{BuildOptions, Builder, EditOptions, Editor};
use distributions::Kind;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};

/// Returns the bytes of all cores and borders, decoded, and the codecs of tiles.
async fn decoded_parts(reader: &TileReader, file: &[u8]) -> (Vec<Vec<u8>>, HashSet<&'static str>) {
    let directory = reader.directory().await.unwrap();
    let extents = directory.tiles.iter().flat_map(|tile| [tile.core, tile.border]);
    let number = |extent: &Extent| match extent.codec {
        Codec::Raw => 0,
        _ => 1,
    };
    let bytes = |extent: Extent| {
        let stored = &file[extent.offset as usize..][..extent.length as usize];
        decoded(stored, number(&extent), extent.decoded as usize)
    };
    let codecs = extents.clone().map(|extent| extent.codec.name()).collect();
    (extents.map(bytes).collect(), codecs)
}

/// Builds points, with z if there is any, and some segments.
async fn built(points: &[Point], z: &[f64], segments: &[[Point; 2]], options: BuildOptions) -> Scratch {
    let scratch = Scratch::new();
    let mut builder = Builder::new(&scratch.path, options).unwrap();
    builder.push_segments(segments).unwrap();
    for batch in batches(points, z) {
        builder.push(&batch).await.unwrap();
    }
    builder.finish().await.unwrap();
    scratch
}

/// Checks that two files have the same tiles, the second compressed. Returns the digest of both.
async fn check_equal(raw: &Scratch, compressed: &Scratch) -> Digest {
    let [raw, compressed] = [raw, compressed].map(|scratch| std::fs::read(&scratch.path).unwrap());
    let [a, b] = [
        open_bytes(raw.clone()).await.unwrap(),
        open_bytes(compressed.clone()).await.unwrap(),
    ];
    let (raw, compressed) = (decoded_parts(&a, &raw).await, decoded_parts(&b, &compressed).await);
    assert!(raw.0 == compressed.0, "decoded bytes differ");
    assert_eq!(
        (raw.1, compressed.1),
        ([Codec::Raw.name()].into(), [Codec::Zstandard.name()].into())
    );
    // Files whose lines have no names are not whole.
    if (a.metadata().line_kinds == 0) == (a.metadata().constraint_edges == 0) {
        for reader in [&a, &b] {
            reader.verify(true).await.unwrap();
        }
    }
    let digest = a.recompute_digest().await.unwrap();
    assert_eq!(digest, b.recompute_digest().await.unwrap());
    assert_eq!(a.metadata(), b.metadata());
    digest
}

#[test]
fn builds_of_random_sets_decode_to_the_bytes_of_builds_without_compression() {
    let config = ProptestConfig {
        cases: 40,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(3),
        ..ProptestConfig::default()
    };
    let kinds = prop::sample::select(Kind::ALL.to_vec());
    let ways = (kinds, 1u64..2000, any::<u64>(), 4usize..400, any::<bool>());
    TestRunner::new(config)
        .run(&ways, |(kind, count, seed, tile_vertices, has_z)| {
            let points = points_of(kind, count, seed);
            let mut random = Random(seed);
            let z: Vec<f64> = points.iter().map(|_| random.below(5000) as f64 * 0.01 + 0.3).collect();
            let z = if has_z { &z[..] } else { &[] };
            let options = BuildOptions::default().tile_vertices(tile_vertices).threads(2);
            runtime().block_on(async {
                let raw = built(&points, z, &[], options.clone()).await;
                let compressed = built(&points, z, &[], options.compress(true)).await;
                check_equal(&raw, &compressed).await;
            });
            Ok(())
        })
        .unwrap();
}

/// A grid of 40 by 40 points, and segments that share points of it.
fn grid() -> (Vec<Point>, Vec<[Point; 2]>) {
    let at = |x: i32, y: i32| Point::new(f64::from(x) / 100.0 + 700_000.0, f64::from(y) / 100.0);
    let points = (0..1600).map(|i| at(i % 40, i / 40)).collect();
    let segments = (0..12).map(|i| [at(1 + 3 * i, 2), at(2 + 3 * i, 37)]);
    (points, segments.collect())
}

#[test]
fn compressed_bytes_do_not_depend_on_threads_or_memory() {
    let (points, segments) = grid();
    let options = BuildOptions::default().tile_vertices(100).compress(true);
    runtime().block_on(async {
        let mut files = HashSet::new();
        for (threads, memory) in [(1, 64 << 20), (2, 64 << 20), (7, 1 << 30), (1, 4 << 20)] {
            let options = options.clone().threads(threads).memory(memory);
            let scratch = built(&points, &[], &segments, options).await;
            files.insert(std::fs::read(&scratch.path).unwrap());
        }
        assert_eq!(files.len(), 1);
    });
}

#[test]
fn edits_and_compaction_of_a_compressed_file_keep_it_compressed() {
    let (points, segments) = grid();
    let options = BuildOptions::default().tile_vertices(100);
    runtime().block_on(async {
        let raw = built(&points, &[], &segments, options.clone()).await;
        let compressed = built(&points, &[], &segments, options.clone().compress(true)).await;
        check_equal(&raw, &compressed).await;
        let raw = built(&points, &[], &[], options.clone()).await;
        let compressed = built(&points, &[], &[], options.compress(true)).await;
        let before = check_equal(&raw, &compressed).await;
        for scratch in [&raw, &compressed] {
            let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(64 << 20))
                .await
                .unwrap()
                .begin()
                .await
                .unwrap();
            let wall = SegmentBatch {
                ends: vec![[Point::new(700_000.001, 0.005), Point::new(700_000.38, 0.011)]],
                lines: vec![0],
                ..SegmentBatch::default()
            };
            transaction.constrain(LineKind::Wall, 0, &wall).unwrap();
            transaction.add_sources(vec![LineSource {
                name: "walls".to_owned(),
                kind: LineKind::Wall,
                first: 0,
                lines: 1,
                edit: 0,
            }]);
            transaction.commit().await.unwrap();
        }
        let edited = check_equal(&raw, &compressed).await;
        assert_ne!(before, edited);
        for scratch in [&raw, &compressed] {
            let length = std::fs::metadata(&scratch.path).unwrap().len();
            scratch.open().await.compact(&scratch.path).await.unwrap();
            assert!(std::fs::metadata(&scratch.path).unwrap().len() < length);
        }
        assert_eq!(check_equal(&raw, &compressed).await, edited);
    });
}

/// Terrain with coordinates in hundredths, as of airborne lidar.
#[test]
fn compressed_lidar_takes_at_most_20_bytes_a_vertex() {
    let mut random = Random(9);
    let mut hundredths = |limit: usize| random.below(limit) as f64 * 0.01;
    let points: Vec<Point> = (0..30_000)
        .map(|_| Point::new(hundredths(60_000) + 637_177.98, hundredths(60_000)))
        .collect();
    let z: Vec<f64> = points
        .iter()
        .map(|p| ((p.x / 50.0).sin() * 900.0).round() * 0.01 + 400.0)
        .collect();
    runtime().block_on(async {
        let scratch = Scratch::new();
        let options = BuildOptions::default().tile_vertices(16_384).compress(true);
        build_batches(&scratch.path, &batches(&points, &z), options)
            .await
            .unwrap();
        let reader = scratch.open().await;
        reader.verify(true).await.unwrap();
        let bytes = reader.file_length() as f64 / reader.metadata().vertices as f64;
        assert!(bytes <= 20.0, "{bytes} bytes a vertex");
    });
}
