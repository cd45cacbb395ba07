//! Benchmarks reading all tiles of a file in order, each verified and decoded. The file is small
//! and was just written, so it is in the page cache.
//!
//! `tiletool bench read` measures the disk.

use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::PointBatch;
use delaunay_tiles::io::{Backend, MemoryFile};
use delaunay_tiles::store::{Cache, OpenOptions, TileReader};
use delaunay_tiles::{BuildOptions, Builder};
use distributions::Kind;
use futures::TryStreamExt;

const POINTS: u64 = 1 << 19;

async fn scan(reader: &TileReader) -> u64 {
    let (mut tiles, mut triangles) = (reader.tiles(), 0);
    while let Some(tile) = tiles.try_next().await.expect("tiles that can be read") {
        triangles += u64::from(tile.triangle_count());
    }
    triangles
}

fn sequential_read(c: &mut Criterion) {
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    let folder = tempfile::tempdir().expect("a scratch folder");
    let path = folder.path().join("bench.tiles");
    let batch = PointBatch {
        points: distributions::points(Kind::Uniform, POINTS, 1)
            .map(|[x, y]| Point::new(x, y))
            .collect(),
        z: Vec::new(),
        records: (0..POINTS).collect(),
    };
    runtime.block_on(async {
        let mut builder = Builder::new(&path, BuildOptions::default()).expect("a builder");
        builder.push(&batch).await.expect("points that fit");
        builder.finish().await.expect("a file");
    });
    let options = || OpenOptions::default().cache(&Cache::new(0));
    let bytes = std::fs::read(&path).expect("the file");
    let mut group = c.benchmark_group("sequential_read");
    group.throughput(Throughput::Bytes(bytes.len() as u64));
    group.sample_size(10).measurement_time(Duration::from_secs(2));
    let memory = runtime.block_on(TileReader::open_source(MemoryFile::new(bytes), "memory", options()));
    let mut readers = vec![("memory", memory)];
    for (name, backend) in [("threads", Backend::Threads), ("uring", Backend::Uring)] {
        readers.push((
            name,
            runtime.block_on(TileReader::open(&path, options().backend(backend))),
        ));
    }
    for (name, reader) in readers {
        match reader {
            Ok(reader) => {
                group.bench_function(BenchmarkId::from_parameter(name), |b| {
                    b.iter(|| runtime.block_on(scan(&reader)))
                });
            }
            // The system may refuse an io_uring.
            Err(error) => eprintln!("{name} is left out: {error}"),
        }
    }
    group.finish();
}

criterion_group!(benches, sequential_read);
criterion_main!(benches);
