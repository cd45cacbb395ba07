//! Raw f64.

use crate::input::{assert_says, drain, file, skipping, stream, with_format};
use delaunay_tiles::input::{Format, InputOptions, PointSource};
use std::io::{Cursor, ErrorKind, Read};

fn bytes(numbers: &[f64]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

fn with_dims(dims: u8) -> InputOptions {
    with_format(Format::F64).dims(dims)
}

#[test]
fn numbers_are_read_as_pairs_or_triples() {
    let numbers = bytes(&[1.0, 2.0, -0.0, 4.0, 5.0, 6.0]);
    let pairs = file("a.f64", &numbers, &InputOptions::default()).unwrap();
    assert_eq!(pairs.points, [(1.0, 2.0), (0.0, 4.0), (5.0, 6.0)]);
    assert!(!pairs.source.has_z());
    let triples = stream(&numbers, &with_dims(3)).unwrap();
    assert_eq!(triples.points, [(1.0, 2.0), (4.0, 5.0)]);
    assert_eq!(triples.z, [0.0, 6.0]);
    assert_eq!(file("a.f64", [], &InputOptions::default()).unwrap().points, []);
    assert_says(stream([], &with_dims(4)), &["invalid dims `4`: expected 2 or 3"]);
}

#[test]
fn many_triples_are_read_in_order() {
    let numbers: Vec<f64> = (0..150_000).map(f64::from).collect();
    let read = stream(bytes(&numbers), &with_dims(3)).unwrap();
    assert_eq!(read.points.len(), 50_000);
    for (n, &(x, y)) in read.points.iter().enumerate() {
        let first = n as f64 * 3.0;
        assert_eq!((x, y, read.z[n]), (first, first + 1.0, first + 2.0));
    }
}

#[test]
fn invalid_numbers_are_refused_or_skipped() {
    let numbers = bytes(&[1.0, 2.0, f64::NAN, 1.0, 3.0, f64::NEG_INFINITY, 7.0, 8.0]);
    assert_says(
        file("a.f64", &numbers, &InputOptions::default()),
        &[
            "a.f64: record 1 (byte 16): x is NaN, not a finite number",
            "`skip_invalid`",
        ],
    );
    let read = file("a.f64", &numbers, &skipping()).unwrap();
    assert_eq!(read.points, [(1.0, 2.0), (7.0, 8.0)]);
    assert_eq!(read.records, [0, 3]);
    assert_eq!(read.source.counts().invalid, 2);
}

/// Batches are checked as a whole, but the error names the invalid record.
#[test]
fn invalid_numbers_in_later_batches_are_named_or_skipped() {
    const INVALID: [usize; 3] = [9_000, 9_001, 20_000];
    let mut numbers: Vec<f64> = (0..75_000).map(f64::from).collect();
    numbers[3 * INVALID[0] + 2] = f64::INFINITY;
    numbers[3 * INVALID[1]] = 1e-300;
    numbers[3 * INVALID[2] + 1] = f64::NAN;
    assert_says(
        stream(bytes(&numbers), &with_dims(3)),
        &["record 9000 (byte 216000): z is inf, not a finite number"],
    );
    let options = with_dims(3).skip_invalid(true);
    let read = stream(bytes(&numbers), &options).unwrap();
    let kept: Vec<usize> = (0..25_000).filter(|n| !INVALID.contains(n)).collect();
    assert_eq!(read.source.counts().invalid, 3);
    assert!(read.records.iter().copied().eq(kept.iter().map(|&n| n as u64)));
    for (n, &record) in kept.iter().enumerate() {
        assert_eq!(read.points[n], (numbers[3 * record], numbers[3 * record + 1]));
        assert_eq!(read.z[n], numbers[3 * record + 2]);
    }
}

/// A reader that returns short and interrupted reads, as pipes do.
#[test]
fn short_and_interrupted_reads_lose_no_numbers() {
    struct Drip(Cursor<Vec<u8>>, usize);
    impl Read for Drip {
        fn read(&mut self, buf: &mut [u8]) -> std::io::Result<usize> {
            self.1 += 1;
            if self.1 % 5 == 3 {
                return Err(ErrorKind::Interrupted.into());
            }
            let n = buf.len().min(1 + 613 * (self.1 % 7));
            self.0.read(&mut buf[..n])
        }
    }
    let numbers: Vec<f64> = (0..40_000).map(f64::from).collect();
    let drip = Box::new(Drip(Cursor::new(bytes(&numbers)), 0));
    let read = PointSource::from_reader("drip", drip, &with_dims(2))
        .and_then(drain)
        .unwrap();
    assert!(read.points.iter().flat_map(|&(x, y)| [x, y]).eq(numbers));
}

#[test]
fn bytes_after_the_last_whole_point_are_refused_or_skipped() {
    let numbers = bytes(&[1.0, 2.0, 3.0]);
    let parts = [
        "byte 16: 8 bytes are left over after the last whole point of 16 bytes",
        "`dims`",
    ];
    assert_says(file("a.f64", &numbers, &InputOptions::default()), &parts);
    assert_says(stream(&numbers, &with_dims(2)), &parts);
    let read = file("a.f64", &numbers, &skipping()).unwrap();
    assert_eq!(read.points, [(1.0, 2.0)]);
    assert_eq!(read.source.counts().invalid, 1);
}

/// Bytes that begin like gzip are numbers, unless the file name says gzip.
#[test]
fn raw_numbers_that_begin_like_gzip_are_read_as_numbers() {
    let number = f64::from_le_bytes([0x1f, 0x8b, 8, 0, 0, 0, 0, 0x40]);
    let numbers = bytes(&[number, 1.0]);
    assert_eq!(
        file("a.f64", &numbers, &InputOptions::default()).unwrap().points,
        [(number, 1.0)]
    );
    assert_eq!(
        file("a.f64.gz", crate::input::gzip(&numbers), &InputOptions::default())
            .unwrap()
            .points,
        [(number, 1.0)]
    );
}
