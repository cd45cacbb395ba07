//! Benchmarks of the in-core engines, and of a whole build, on a block that fits the processor's
//! cache.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::PointBatch;
use delaunay_tiles::mesh::{EngineKind, Triangulation};
use delaunay_tiles::{BuildOptions, Builder};
use distributions::Kind;

const POINTS: u64 = 1 << 16;

fn points(kind: Kind) -> Vec<Point> {
    distributions::points(kind, POINTS, 1)
        .map(|[x, y]| Point::new(x, y))
        .collect()
}

fn engines(c: &mut Criterion) {
    let mut group = c.benchmark_group("triangulate");
    group.throughput(Throughput::Elements(POINTS));
    group.sample_size(10).measurement_time(Duration::from_secs(2));
    for kind in [Kind::Uniform, Kind::Grid, Kind::Lidar] {
        let points = points(kind);
        for &engine in EngineKind::ALL {
            let (mut triangulator, mut mesh) = (engine.create(), Triangulation::default());
            group.bench_function(BenchmarkId::new(engine.name(), kind), |b| {
                b.iter(|| triangulator.triangulate(black_box(&points), &mut mesh));
            });
        }
    }
    group.finish();
}

fn whole_build(c: &mut Criterion) {
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    let folder = tempfile::tempdir().expect("a scratch folder");
    let output = folder.path().join("bench.tiles");
    let batch = PointBatch {
        points: points(Kind::Uniform),
        z: Vec::new(),
        records: (0..POINTS).collect(),
    };
    let mut group = c.benchmark_group("build");
    group.throughput(Throughput::Elements(POINTS));
    group.sample_size(10).measurement_time(Duration::from_secs(2));
    for tile_vertices in [1 << 10, 1 << 16] {
        group.bench_function(BenchmarkId::from_parameter(tile_vertices), |b| {
            b.iter_batched(
                || BuildOptions::default().tile_vertices(tile_vertices).force(true),
                |options| {
                    runtime.block_on(async {
                        let mut builder = Builder::new(&output, options).expect("a builder");
                        builder.push(&batch).await.expect("points that fit");
                        builder.finish().await.expect("a file")
                    })
                },
                BatchSize::PerIteration,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, engines, whole_build);
criterion_main!(benches);
