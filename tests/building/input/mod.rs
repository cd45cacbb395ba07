//! The readers: they return what a file contains, numbered and checked, or an error that says what
//! is wrong.

mod ahead;
mod changed;
mod copc;
mod crafted;
mod hostile;
mod mesh;
mod node;
mod parquet;
mod poly;
mod raw;
mod segments;
mod source;

mod geojson;
mod hostile_lines;
mod hostile_vector;
mod las;
mod many;
mod obstacles;
mod rings;
mod sites;
mod text;
mod vector;

use crate::support::test_data::{data, shared};
use delaunay_tiles::input::{Format, InputError, InputOptions, PointBatch, PointSource};
use std::error::Error;
use std::io::Cursor;
use std::path::PathBuf;

/// Everything that a source returns.
#[derive(Debug)]
struct Read {
    points: Vec<(f64, f64)>,
    z: Vec<f64>,
    records: Vec<u64>,
    source: PointSource,
}

fn drain(mut source: PointSource) -> Result<Read, InputError> {
    let (mut points, mut z, mut records) = (Vec::new(), Vec::new(), Vec::new());
    assert!(source.sample(64)?.into_iter().all(|p| p.is_valid()));
    let expected = source.expected_points();
    let mut batch = PointBatch::default();
    while source.next_batch(&mut batch)? {
        assert!((1..=8192).contains(&batch.len()), "a batch of {} points", batch.len());
        assert_eq!(batch.records.len(), batch.len());
        assert_eq!(batch.z.len(), if source.has_z() { batch.len() } else { 0 });
        assert!(
            batch
                .points
                .iter()
                .all(|p| p.is_valid() && bits(*p) == bits(p.normalized()))
        );
        assert!(batch.z.iter().all(|z| z.is_finite()));
        points.extend(batch.points.iter().map(|p| (p.x, p.y)));
        z.extend(&batch.z);
        records.extend(&batch.records);
    }
    assert!(batch.is_empty());
    assert!(records.is_sorted_by(|a, b| a < b));
    let counts = source.counts();
    assert_eq!(counts.points, points.len() as u64);
    assert_eq!(
        counts.records,
        counts.points + counts.withheld + counts.filtered + counts.invalid
    );
    // Records that are left out need not have been read, and a rest is a record.
    let read = counts.records - counts.filtered..=counts.records;
    assert!(
        expected.is_none_or(|expected| read.contains(&expected) || expected.abs_diff(counts.records) <= 1)
            || source
                .notes()
                .iter()
                .any(|note| note.ends_with("rows have no geometry")),
        "{expected:?} of {counts:?}"
    );
    Ok(Read {
        points,
        z,
        records,
        source,
    })
}

fn bits(p: delaunay_tiles::geometry::Point) -> (u64, u64) {
    (p.x.to_bits(), p.y.to_bits())
}

/// Reads bytes as a stream.
fn stream(bytes: impl AsRef<[u8]>, options: &InputOptions) -> Result<Read, InputError> {
    let bytes = Cursor::new(bytes.as_ref().to_vec());
    PointSource::from_reader("stream", Box::new(bytes), options).and_then(drain)
}

/// Reads bytes as a file named `name`.
fn file(name: &str, bytes: impl AsRef<[u8]>, options: &InputOptions) -> Result<Read, InputError> {
    files(&[(name, bytes.as_ref())], options)
}

/// Reads files one after the other.
fn files(files: &[(&str, &[u8])], options: &InputOptions) -> Result<Read, InputError> {
    let dir = tempfile::tempdir().unwrap();
    let paths: Vec<PathBuf> = files.iter().map(|(name, _)| dir.path().join(name)).collect();
    for (path, (_, bytes)) in paths.iter().zip(files) {
        std::fs::write(path, bytes).unwrap();
    }
    let read = PointSource::open(&paths, options).and_then(drain)?;
    let counts = read.source.counts();
    assert_eq!(
        Some(counts.bytes_read),
        read.source.total_bytes(),
        "all bytes were read"
    );
    Ok(read)
}

fn with_format(format: Format) -> InputOptions {
    InputOptions::default().format(format)
}

fn skipping() -> InputOptions {
    InputOptions::default().skip_invalid(true)
}

/// Returns the message of an error, followed by those of its causes.
#[track_caller]
fn message(result: Result<Read, InputError>) -> String {
    let error = result
        .map(|read| read.points)
        .expect_err("this should not have been read");
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text
}

/// Asserts that the error's message contains `parts`.
#[track_caller]
fn assert_says(result: Result<Read, InputError>, parts: &[&str]) {
    let message = message(result);
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}
