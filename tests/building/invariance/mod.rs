//! The promise: the triangles are those of an in-core triangulation. They do not depend on the tile
//! size, the fan-out, the threads, the engine or the order of the points. `verify` proves them.

use crate::support::{built, points_of, reference, runtime};
use delaunay_tiles::BuildOptions;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::mesh::EngineKind;
use distributions::Kind;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

fn options(tile_vertices: usize, merge_vertices: usize, threads: usize, engine: EngineKind) -> BuildOptions {
    BuildOptions::default()
        .tile_vertices(tile_vertices)
        .merge_vertices(merge_vertices)
        .threads(threads)
        .engine(engine)
}

/// Builds in all `ways`, and compares the digests with the in-core reference.
fn check(points: &[Point], ways: &[(usize, usize, usize, EngineKind)]) {
    let expected = reference(EngineKind::Native, points);
    runtime().block_on(async {
        for &(tile_vertices, merge_vertices, threads, engine) in ways {
            let (_scratch, reader) = built(points, options(tile_vertices, merge_vertices, threads, engine)).await;
            let way = format!("tiles of {tile_vertices}, merges of {merge_vertices}, {threads} threads, {engine}");
            if let Err(error) = reader.verify(true).await {
                panic!("{way}: {error}");
            }
            assert_eq!(reader.recompute_digest().await.unwrap(), expected, "{way}");
        }
    });
}

#[test]
fn every_distribution_gives_one_triangulation_in_any_tiles_threads_and_engine() {
    let spade = EngineKind::Spade;
    let native = EngineKind::Native;
    for kind in Kind::ALL {
        let points = points_of(kind, 3000, 7);
        assert_eq!(reference(native, &points), reference(spade, &points), "{kind}");
        println!("{kind}");
        check(
            &points,
            &[
                (8, 16, 1, native),
                (8, 1 << 16, 2, native),
                (64, 256, 7, native),
                (64, 1 << 16, 1, spade),
                (1000, 1 << 16, 2, native),
                (65536, 1 << 16, 1, native),
            ],
        );
    }
}

#[test]
fn reordered_input_gives_the_same_digest() {
    let mut points = points_of(Kind::Grid, 2500, 1);
    let expected = reference(EngineKind::Native, &points);
    points.reverse();
    points.rotate_left(777);
    runtime().block_on(async {
        let (_scratch, reader) = built(&points, options(64, 64, 2, EngineKind::Native)).await;
        assert_eq!(reader.recompute_digest().await.unwrap(), expected);
    });
}

#[test]
fn small_degenerate_sets_in_small_tiles_equal_the_in_core_triangulation() {
    let config = ProptestConfig {
        cases: 60,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(1),
        ..ProptestConfig::default()
    };
    let sets = prop::collection::vec((0i32..9, 0i32..9), 0..60);
    TestRunner::new(config)
        .run(&sets, |set| {
            let points: Vec<_> = set.iter().map(|&(x, y)| Point::new(x.into(), y.into())).collect();
            check(&points, &[(4, 4, 1, EngineKind::Native), (5, 20, 2, EngineKind::Spade)]);
            Ok(())
        })
        .unwrap();
}
