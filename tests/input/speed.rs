//! Rows per second. Not a test: `cargo test --release --all-features --test input -- --ignored --nocapture speed`.

use delaunay_tiles::input::{InputOptions, PointBatch, PointSource};
use std::fmt::Write;
use std::path::PathBuf;
use std::time::Instant;

fn measure(what: &str, path: PathBuf, options: &InputOptions) {
    for _ in 0..3 {
        let begin = Instant::now();
        let mut source = PointSource::open(std::slice::from_ref(&path), options).unwrap();
        let mut batch = PointBatch::default();
        let mut sum = 0.0;
        while source.next_batch(&mut batch).unwrap() {
            sum += batch.points[0].x;
        }
        let seconds = begin.elapsed().as_secs_f64();
        let counts = source.counts();
        let (rows, bytes) = (
            counts.points as f64 / seconds / 1e6,
            counts.bytes_read as f64 / seconds / 1e6,
        );
        println!(
            "{what}: {rows:.2} M points/s, {bytes:.0} MB/s ({} points, {sum})",
            counts.points
        );
    }
}

#[test]
#[ignore = "a measurement"]
fn speed() {
    const N: u32 = 2_000_000;
    let dir = tempfile::tempdir().unwrap();
    let default = InputOptions::default();
    let point = |n: u32| {
        let (a, b) = (n.wrapping_mul(0x9e37_79b9), n.wrapping_mul(0x85eb_ca6b));
        (
            f64::from(a) / 4294.0 + 500_000.0,
            f64::from(b) / 4294.0 + 5_000_000.0,
            f64::from(n % 50_000) / 100.0,
        )
    };
    let (mut blanks, mut csv, mut raw) = (String::new(), String::from("id,lon,lat,name\n"), Vec::new());
    let mut json = String::from(r#"{"type":"FeatureCollection","features":[{}"#).replace("{}", "");
    for n in 0..N {
        let (x, y, z) = point(n);
        writeln!(blanks, "{x:.2} {y:.2} {z:.2}").unwrap();
        writeln!(csv, "{n},{:.7},{:.7},\"a, b\"", x / 10_000.0, y / 100_000.0).unwrap();
        let comma = if n == 0 { "" } else { "," };
        write!(json, r#"{comma}{{"type":"Feature","properties":{{"n":{n}}},"geometry":{{"type":"Point","coordinates":[{x:.2},{y:.2}]}}}}"#).unwrap();
        raw.extend([x, y].into_iter().flat_map(f64::to_le_bytes));
    }
    json.push_str("]}");
    for (name, bytes) in [
        ("points.xyz", blanks.as_bytes()),
        ("points.csv", csv.as_bytes()),
        ("points.f64", &raw),
        ("points.geojson", json.as_bytes()),
    ] {
        let path = dir.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        measure(name, path, &default);
    }
    #[cfg(feature = "las")]
    if let Some(lidar) = crate::shared("lidar/autzen_trim.laz") {
        measure("autzen_trim.laz", lidar, &default);
    }
}
