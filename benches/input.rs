//! Benchmarks of the point readers, in rows per second, on files that were just written.

use std::fmt::Write;
use std::path::Path;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use delaunay_tiles::input::{InputOptions, PointBatch, PointSource};

const POINTS: u32 = 1 << 18;

fn read(path: &Path) -> f64 {
    let mut source = PointSource::open(&[path.to_owned()], &InputOptions::default()).expect("a file of points");
    let (mut batch, mut sum) = (PointBatch::default(), 0.0);
    while source.next_batch(&mut batch).expect("points") {
        sum += batch.points[0].x;
    }
    sum
}

/// Returns the same points in four formats, each with its file name.
fn files() -> [(&'static str, Vec<u8>); 4] {
    let (mut blanks, mut csv, mut raw) = (String::new(), String::from("id,lon,lat,name\n"), Vec::new());
    let mut json = String::from(r#"{"type":"FeatureCollection","features":["#);
    for n in 0..POINTS {
        let (a, b) = (n.wrapping_mul(0x9e37_79b9), n.wrapping_mul(0x85eb_ca6b));
        let (x, y) = (f64::from(a) / 4294.0 + 500_000.0, f64::from(b) / 4294.0 + 5_000_000.0);
        let z = f64::from(n % 50_000) / 100.0;
        let written = writeln!(blanks, "{x:.2} {y:.2} {z:.2}")
            .and_then(|()| writeln!(csv, "{n},{:.7},{:.7},\"a, b\"", x / 10_000.0, y / 100_000.0))
            .and_then(|()| {
                let comma = if n == 0 { "" } else { "," };
                write!(json, r#"{comma}{{"type":"Feature","properties":{{"n":{n}}},"geometry":{{"type":"Point","coordinates":[{x:.2},{y:.2}]}}}}"#)
            });
        written.expect("text");
        raw.extend([x, y].into_iter().flat_map(f64::to_le_bytes));
    }
    json.push_str("]}");
    [
        ("points.xyz", blanks.into_bytes()),
        ("points.csv", csv.into_bytes()),
        ("points.f64", raw),
        ("points.geojson", json.into_bytes()),
    ]
}

fn input(c: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let mut group = c.benchmark_group("input");
    group.throughput(Throughput::Elements(u64::from(POINTS)));
    group.sample_size(10).measurement_time(Duration::from_secs(2));
    for (name, bytes) in files() {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("a file");
        group.bench_function(BenchmarkId::from_parameter(name), |b| b.iter(|| read(&path)));
    }
    group.finish();
}

criterion_group!(benches, input);
criterion_main!(benches);
