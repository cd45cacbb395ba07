//! Files that change while they are read.
//!
//! A raw file that was cut off behind the points read so far once gave a file of those points and
//! exit code 0, and so did text: no reader compared what it read with the file's state at opening.
//! Now all files of all sources are compared.

use crate::input::data;
use delaunay_tiles::input::{
    InputError, InputOptions, PointBatch, PointSource, PolySource, RowFile, SegmentBatch, SegmentSource, SiteBatch,
    SiteSource,
};
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// What the error says of a changed file, and the function that changes it.
type Change = (&'static str, fn(&Path));

/// Ways in which a file changes.
const CHANGES: [Change; 4] = [
    ("bytes, and has", |path| {
        let file = File::options().write(true).open(path).unwrap();
        let length = file.metadata().unwrap().len();
        file.set_len(length / 2 / 48 * 48).unwrap();
    }),
    ("bytes, and has", |path| {
        let mut file = File::options().append(true).open(path).unwrap();
        file.write_all(&[0; 48]).unwrap();
    }),
    ("it was written to", |path| {
        let bytes = fs::read(path).unwrap();
        let mut file = File::options().write(true).open(path).unwrap();
        file.write_all(&bytes).unwrap();
    }),
    // The file was empty for a moment.
    ("it was written to", |path| {
        let bytes = fs::read(path).unwrap();
        fs::write(path, bytes).unwrap();
    }),
];

/// Replaces the file with another file of the same bytes.
fn replace(path: &Path) {
    let other = path.with_extension("other");
    fs::copy(path, &other).unwrap();
    fs::rename(other, path).unwrap();
}

/// Writes a file whose modification time is some seconds ago, since the system's clock for such
/// times is coarse.
fn write(path: &Path, bytes: &[u8]) {
    fs::write(path, bytes).unwrap();
    let file = File::options().write(true).open(path).unwrap();
    file.set_modified(SystemTime::now() - Duration::from_secs(10)).unwrap();
}

fn rows(count: u32, row: impl Fn(u32) -> String) -> Vec<u8> {
    (0..count).map(row).collect::<String>().into_bytes()
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

const MANY: u32 = 40_000;

fn line_strings(count: u32) -> Vec<u8> {
    let line = |n| format!(r#"{{"type":"LineString","coordinates":[[{n},0],[{n},1]]}}"#) + "\n";
    rows(count, line)
}

/// A source of any kind. Each call reads a batch; it returns `false` at the end of the files.
type Drain = Box<dyn FnMut() -> Result<bool, InputError>>;

fn points(paths: &[PathBuf]) -> Drain {
    let mut source = PointSource::open(paths, &InputOptions::default()).unwrap();
    let mut batch = PointBatch::default();
    Box::new(move || source.next_batch(&mut batch))
}

fn segments(paths: &[PathBuf]) -> Drain {
    let mut source = SegmentSource::open(paths).unwrap();
    let mut batch = SegmentBatch::default();
    Box::new(move || source.next_batch(&mut batch))
}

fn obstacles(paths: &[PathBuf]) -> Drain {
    let mut source = SegmentSource::open_obstacles(paths).unwrap();
    let mut batch = SegmentBatch::default();
    Box::new(move || source.next_batch(&mut batch))
}

fn sites(paths: &[PathBuf]) -> Drain {
    let mut source = SiteSource::open(paths, None).unwrap();
    let mut batch = SiteBatch::default();
    Box::new(move || source.next_batch(&mut batch))
}

fn poly(paths: &[PathBuf]) -> Drain {
    let mut source = Some(PolySource::open(&paths[0]).unwrap());
    let mut batch = SegmentBatch::default();
    Box::new(
        move || match source.as_mut().map(|source| source.next_batch(&mut batch)) {
            Some(Ok(false)) => source.take().unwrap().holes().map(|_| false),
            Some(other) => other,
            None => Ok(false),
        },
    )
}

fn row_file(paths: &[PathBuf]) -> Drain {
    let mut file = RowFile::open(&paths[0]).unwrap();
    Box::new(move || Ok(file.next_row()?.is_some()))
}

/// Name, bytes and source of a kind of file.
type Case = (&'static str, Vec<u8>, fn(&[PathBuf]) -> Drain);

fn cases() -> Vec<Case> {
    let text = rows(MANY, |n| format!("{n},{}\n", n % 199));
    let mut node = format!("{MANY} 2 0 0\n").into_bytes();
    node.extend(rows(MANY, |n| format!("{n} {n} {}\n", n % 199)));
    let mut with_segments = node.clone();
    with_segments.extend(format!("{MANY} 0\n").into_bytes());
    with_segments.extend(rows(MANY, |n| format!("{n} {n} {}\n", (n + 1) % MANY)));
    with_segments.extend(b"0\n");
    let polygon = |n| format!(r#"{{"type":"Polygon","coordinates":[[[{n},0],[{n},1],[0,9],[{n},0]]]}}"#) + "\n";
    let pairs: Vec<u8> = (0..2 * MANY).flat_map(u32::to_le_bytes).collect();
    let raw = (0..2 * MANY).flat_map(|n| f64::from(n).to_le_bytes()).collect();
    let of_lines = rows(MANY, |n| format!("{n},0,{n},1\n"));
    let mut cases: Vec<Case> = vec![
        ("points.f64", raw, points),
        ("points.node", node, points),
        ("points.poly", with_segments.clone(), points),
        ("segments.poly", with_segments, poly),
        ("segments.u32", pairs.clone(), segments),
        ("segments.u64", pairs, segments),
        ("rows.txt", text.clone(), row_file),
    ];
    cases.push(("points.csv", text.clone(), points));
    cases.push(("points.csv.gz", gzip(&text), points));
    cases.push(("segments.csv", of_lines, segments));
    cases.push(("sites.csv", text, sites));
    let site = |n| format!(r#"{{"type":"Point","coordinates":[{n},0]}}"#) + "\n";
    cases.push(("points.geojson", line_strings(MANY), points));
    cases.push(("segments.geojson", line_strings(MANY), segments));
    cases.push(("obstacles.geojson", rows(MANY, polygon), obstacles));
    cases.push(("sites.geojson", rows(MANY, site), sites));
    cases.push(("points.las", fs::read(data("las/autzen.las")).unwrap(), points));
    cases.push(("points.laz", fs::read(data("las/autzen.laz")).unwrap(), points));
    cases
}

fn drain(mut next: Drain) -> Result<u32, InputError> {
    let mut batches = 0;
    while next()? {
        batches += 1;
    }
    assert!(!next()?, "it has ended");
    Ok(batches)
}

fn says(result: Result<u32, InputError>, path: &Path, what: &str) {
    match result {
        Err(error @ InputError::Changed { .. }) => {
            let text = error.to_string();
            assert!(text.contains(path.to_str().unwrap()) && text.contains(what), "{text}");
        }
        other => panic!("{}: {other:?}, and not: {what}", path.display()),
    }
}

#[test]
fn every_reader_detects_a_file_that_changes_while_it_is_read() {
    let dir = tempfile::tempdir().unwrap();
    for (name, bytes, open) in cases() {
        let path = dir.path().join(name);
        let paths = [path.clone()];
        write(&path, &bytes);
        let all = drain(open(&paths)).unwrap();
        assert!(all > 0, "{name}: what nobody changes is read");
        for (what, change) in CHANGES {
            // The file changes when it was just opened, and, if it has several batches, after the
            // first batch.
            for batches in [0, 1] {
                write(&path, &bytes);
                let mut next = open(&paths);
                if batches == 1 && (all == 1 || !next().unwrap()) {
                    continue;
                }
                change(&path);
                says(drain(next), &path, what);
            }
        }
    }
}

#[test]
fn replacing_a_file_that_is_not_yet_open_is_detected() {
    let dir = tempfile::tempdir().unwrap();
    for (name, bytes, open) in cases() {
        let first = dir.path().join(format!("first {name}"));
        let path = dir.path().join(name);
        write(&first, &bytes);
        write(&path, &bytes);
        let paths = [first.clone(), path.clone()];
        if name.ends_with(".poly") || name.starts_with("rows") {
            continue;
        }
        let next = open(&paths);
        replace(&path);
        says(drain(next), &path, "another file has taken its place");
        // The first file is open already, so its reader does not depend on its name.
        let next = open(&paths);
        replace(&first);
        drain(next).unwrap();
    }
}

#[test]
fn a_named_pipe_is_read_without_an_error_for_its_length() {
    let dir = tempfile::tempdir().unwrap();
    let fifo = dir.path().join("points.f64");
    let made = std::process::Command::new("mkfifo").arg(&fifo).status();
    assert!(made.is_ok_and(|status| status.success()));
    let writer = {
        let fifo = fifo.clone();
        std::thread::spawn(move || {
            let mut fifo = File::options().write(true).open(fifo).unwrap();
            for n in 0..2 * MANY {
                fifo.write_all(&f64::from(n).to_le_bytes()).unwrap();
            }
        })
    };
    assert_eq!(drain(points(&[fifo])).unwrap(), MANY.div_ceil(8192));
    writer.join().unwrap();
}

#[test]
fn a_stopped_source_ends_within_a_long_run_of_blank_lines() {
    // 1.5 GB of blank lines in a small gzip kept the tool busy; nobody could stop it or see when it
    // would end.
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("blank.csv.gz");
    let blank = vec![b'\n'; 8 << 20];
    let bytes: Vec<u8> = [gzip(b"1,2\n3,4\n")]
        .into_iter()
        .chain((0..100).map(|_| gzip(&blank)))
        .flatten()
        .collect();
    fs::write(&path, bytes).unwrap();
    let mut source = PointSource::open(&[path], &InputOptions::default()).unwrap();
    let (reading, before) = (source.reading().clone(), source.reading().bytes());
    let reader = std::thread::spawn(move || source.next_batch(&mut PointBatch::default()));
    while reading.bytes() <= before + (64 << 10) && !reader.is_finished() {
        std::thread::yield_now();
    }
    reading.stop();
    assert!(matches!(reader.join().unwrap(), Err(InputError::Stopped)));
}
