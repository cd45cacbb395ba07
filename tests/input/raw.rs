//! Raw f64.

use crate::{assert_says, file, skipping, stream, with_format};
use delaunay_tiles::input::{Format, InputOptions};

fn bytes(numbers: &[f64]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

fn with_dims(dims: u8) -> InputOptions {
    InputOptions {
        dims,
        ..with_format(Format::F64)
    }
}

#[test]
fn pairs_and_triples() {
    let numbers = bytes(&[1.0, 2.0, -0.0, 4.0, 5.0, 6.0]);
    let pairs = file("a.f64", &numbers, &InputOptions::default()).unwrap();
    assert_eq!(pairs.points, [(1.0, 2.0), (0.0, 4.0), (5.0, 6.0)]);
    assert!(!pairs.source.has_z());
    let triples = stream(&numbers, &with_dims(3)).unwrap();
    assert_eq!(triples.points, [(1.0, 2.0), (4.0, 5.0)]);
    assert_eq!(triples.z, [0.0, 6.0]);
    assert_eq!(file("a.f64", [], &InputOptions::default()).unwrap().points, []);
    assert_says(
        stream([], &with_dims(4)),
        &["`4` is not possible for --dims; it is 2 or 3"],
    );
}

#[test]
fn many() {
    let numbers: Vec<f64> = (0..150_000).map(f64::from).collect();
    let read = stream(bytes(&numbers), &with_dims(3)).unwrap();
    assert_eq!(read.points.len(), 50_000);
    for (n, &(x, y)) in read.points.iter().enumerate() {
        let first = n as f64 * 3.0;
        assert_eq!((x, y, read.z[n]), (first, first + 1.0, first + 2.0));
    }
}

#[test]
fn invalid_numbers() {
    let numbers = bytes(&[1.0, 2.0, f64::NAN, 1.0, 3.0, f64::NEG_INFINITY, 7.0, 8.0]);
    assert_says(
        file("a.f64", &numbers, &InputOptions::default()),
        &[
            "a.f64: record 1 (byte 16): x is NaN, not a finite number",
            "--skip-invalid",
        ],
    );
    let read = file("a.f64", &numbers, &skipping()).unwrap();
    assert_eq!(read.points, [(1.0, 2.0), (7.0, 8.0)]);
    assert_eq!(read.records, [0, 3]);
    assert_eq!(read.source.counts().invalid, 2);
}

#[test]
fn a_rest() {
    let numbers = bytes(&[1.0, 2.0, 3.0]);
    let parts = [
        "byte 16: 8 bytes are left over behind the last whole point of 16 bytes",
        "--dims",
    ];
    assert_says(file("a.f64", &numbers, &InputOptions::default()), &parts);
    assert_says(stream(&numbers, &with_dims(2)), &parts);
    let read = file("a.f64", &numbers, &skipping()).unwrap();
    assert_eq!(read.points, [(1.0, 2.0)]);
    assert_eq!(read.source.counts().invalid, 1);
}

/// Bytes that begin like gzip are numbers, unless the name says gzip.
#[test]
fn magic_is_a_number() {
    let number = f64::from_le_bytes([0x1f, 0x8b, 8, 0, 0, 0, 0, 0x40]);
    let numbers = bytes(&[number, 1.0]);
    assert_eq!(
        file("a.f64", &numbers, &InputOptions::default()).unwrap().points,
        [(number, 1.0)]
    );
    #[cfg(feature = "text")]
    assert_eq!(
        file("a.f64.gz", crate::gzip(&numbers), &InputOptions::default())
            .unwrap()
            .points,
        [(number, 1.0)]
    );
}
