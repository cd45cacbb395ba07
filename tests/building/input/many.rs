//! Files with more records than a batch, in every format that a program may write.

use crate::input::file;
use delaunay_tiles::input::InputOptions;
use std::fmt::Write;

/// Four batches and a remainder.
const N: u32 = 4 * 8192 + 77;

/// Returns points whose coordinates have two decimals.
fn points() -> Vec<(f64, f64, f64)> {
    let point = |n: u32| {
        let (a, b) = (n.wrapping_mul(0x9e37_79b9), n.wrapping_mul(0x85eb_ca6b));
        let hundredths = |n: u32, from: f64| (f64::from(n >> 5) + from) / 100.0;
        (
            hundredths(a, 5e7),
            hundredths(b, 5e8),
            hundredths((n % 50_000) << 5, 0.0),
        )
    };
    (0..N).map(point).collect()
}

#[test]
fn every_format_gives_the_same_points_over_several_batches() {
    let (mut blanks, mut csv, mut raw) = (String::new(), String::from("id,lon,lat,name\n"), Vec::new());
    let (mut node, mut features) = (format!("{N} 2 0 0\n"), Vec::new());
    let points = points();
    for (n, (x, y, z)) in points.iter().enumerate() {
        writeln!(blanks, "{x:.2} {y:.2} {z:.2}").unwrap();
        writeln!(csv, "{n},{x:.2},{y:.2},\"a, b\"").unwrap();
        writeln!(node, "{n} {x:.2} {y:.2}").unwrap();
        raw.extend([*x, *y].into_iter().flat_map(f64::to_le_bytes));
        features.push(format!(
            r#"{{"type":"Feature","properties":{{"n":{n}}},"geometry":{{"type":"Point","coordinates":[{x:.2},{y:.2}]}}}}"#
        ));
    }
    let json = format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, features.join(","));
    let expected: Vec<(f64, f64)> = points.iter().map(|(x, y, _)| (*x, *y)).collect();
    let heights: Vec<f64> = points.iter().map(|(_, _, z)| *z).collect();
    for (name, bytes) in [
        ("points.xyz", blanks.as_bytes()),
        ("points.csv", csv.as_bytes()),
        ("points.node", node.as_bytes()),
        ("points.f64", &raw),
        ("points.geojson", json.as_bytes()),
    ] {
        let read = file(name, bytes, &InputOptions::default()).unwrap();
        assert!(read.points == expected, "{name}");
        assert!(read.records.iter().copied().eq(0..u64::from(N)), "{name}");
        assert_eq!(read.z, if name.ends_with("xyz") { &heights[..] } else { &[] }, "{name}");
    }
}
