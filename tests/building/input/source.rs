//! Several inputs as one set.

use crate::input::{assert_says, drain, files};
use delaunay_tiles::input::{Format, InputOptions, MissingZ, PointBatch, PointSource, Returns};
use std::path::{Path, PathBuf};

fn doubles(numbers: &[f64]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

fn is_send<T: Send>(_: &T) {}
fn is_error<T: std::error::Error + Send + Sync + 'static>() {}

#[test]
fn record_numbers_continue_over_all_inputs() {
    let options = InputOptions::default().skip_invalid(true);
    let raw = doubles(&[1.0, 2.0, f64::NAN, 0.0, 3.0, 4.0]);
    let inputs: [(&str, &[u8]); 3] = [
        ("a.f64", &raw),
        ("b.node", b"2 2 0 0\n1 5 6\n2 5 oops\n"),
        ("c.f64", &raw),
    ];
    let read = files(&inputs, &options).unwrap();
    assert_eq!(
        read.points,
        [(1.0, 2.0), (3.0, 4.0), (5.0, 6.0), (1.0, 2.0), (3.0, 4.0)]
    );
    assert_eq!(read.records, [0, 2, 3, 5, 7]);
    let counts = read.source.counts();
    assert_eq!((counts.records, counts.points, counts.invalid), (8, 5, 3));
    is_send(&read.source);
    is_error::<delaunay_tiles::input::InputError>();
}

#[test]
fn one_input_with_z_requires_z_of_all() {
    let raw = doubles(&[1.0, 2.0]);
    let both: [(&str, &[u8]); 2] = [("a.f64", &raw), ("b.node", b"1 3 0 0\n0 3 4 5\n")];
    assert_says(
        files(&both, &InputOptions::default()),
        &[
            "a.f64: byte 0: record 0 has no z, and other points have",
            "(option `missing_z`: zero)",
        ],
    );
    let zero = InputOptions::default().missing_z(MissingZ::Zero);
    let read = files(&both, &zero).unwrap();
    assert_eq!(read.z, [0.0, 5.0]);
    assert_eq!(read.source.notes().len(), 1);
    assert!(read.source.notes()[0].ends_with("a.f64: 1 points without z got z = 0"));
}

#[test]
fn the_file_name_decides_the_format() {
    for (name, format) in [
        ("a.csv", Some(Format::Text)),
        ("dir.las/a.CSV.gz", Some(Format::Text)),
        ("a.tsv", Some(Format::Text)),
        ("a.b.xyz", Some(Format::Text)),
        ("a.f64", Some(Format::F64)),
        ("a.node", Some(Format::Node)),
        ("a.poly.gz", Some(Format::Poly)),
        ("a.geojsonl", Some(Format::GeoJson)),
        ("a.copc.laz", Some(Format::Las)),
        ("a.fgb.gz", Some(Format::FlatGeobuf)),
        ("a.shp", Some(Format::Shapefile)),
        ("a.gpkg", Some(Format::GeoPackage)),
        ("dir/a.GPKG:lines of 2.5 m", Some(Format::GeoPackage)),
        ("a.gpkg:", None),
        ("a.dwg", None),
        ("a.PLY.gz", Some(Format::Ply)),
        ("a.obj", Some(Format::Obj)),
        ("a.parquet", Some(Format::Parquet)),
        ("csv", None),
        (".csv", None),
        ("a.gz", None),
    ] {
        assert_eq!(Format::from_path(Path::new(name)), format, "{name}");
    }
    for format in [
        Format::Text,
        Format::F64,
        Format::Node,
        Format::Poly,
        Format::GeoJson,
        Format::Las,
        Format::FlatGeobuf,
        Format::Shapefile,
        Format::GeoPackage,
        Format::Ply,
        Format::Obj,
        Format::Parquet,
    ] {
        assert_eq!(format.to_string().parse::<Format>().unwrap(), format);
    }
    assert!(
        "dwg"
            .parse::<Format>()
            .unwrap_err()
            .to_string()
            .contains("invalid format `dwg`")
    );
    assert_eq!("last".parse::<Returns>().unwrap(), Returns::Last);
    assert!("second".parse::<Returns>().is_err());
}

#[test]
fn inputs_that_cannot_be_opened_are_named_in_the_error() {
    let open = |path: &str| PointSource::open(&[PathBuf::from(path)], &InputOptions::default()).and_then(drain);
    assert_says(open("no/such.f64"), &["no/such.f64: cannot be opened"]);
    assert_says(
        open("points.dwg"),
        &[
            "points.dwg: neither the name nor the content tells the format",
            "option `format`",
            ".geojson",
        ],
    );
    let twice = PointSource::open(&[PathBuf::from("-"), PathBuf::from("-")], &InputOptions::default());
    assert_says(
        twice.and_then(drain),
        &["invalid input `-`: standard input can be read only once"],
    );
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("folder.f64");
    std::fs::create_dir(&folder).unwrap();
    assert!(PointSource::open(&[folder], &InputOptions::default()).is_err());
    assert!(
        drain(PointSource::open(&[], &InputOptions::default()).unwrap())
            .unwrap()
            .points
            .is_empty()
    );
}

/// After an error there are no more points, and the progress never exceeds the total.
#[test]
fn an_error_ends_the_stream() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.f64");
    let mut numbers = vec![1.0; 40_000];
    numbers[30_001] = f64::INFINITY;
    std::fs::write(&path, doubles(&numbers)).unwrap();
    let mut source = PointSource::open(&[path.clone(), path], &InputOptions::default()).unwrap();
    assert_eq!(source.total_bytes(), Some(640_000));
    let mut batch = PointBatch::default();
    assert!(source.next_batch(&mut batch).unwrap());
    assert_eq!(batch.len(), 8192);
    assert!(source.bytes_read() > 0 && source.bytes_read() <= 640_000);
    assert!(source.next_batch(&mut batch).is_err());
    assert!(batch.is_empty());
    assert!(!source.next_batch(&mut batch).unwrap());
}

/// A named pipe can be read only once, so it stays open from the first open on.
#[cfg(unix)]
#[test]
fn a_named_pipe_among_files_is_read() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("first.f64");
    std::fs::write(&file, doubles(&[7.0, 8.0])).unwrap();
    let pipe = dir.path().join("second.f64");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    if !made.is_ok_and(|status| status.success()) {
        println!("skipped: no mkfifo");
        return;
    }
    let writer = {
        let pipe = pipe.clone();
        std::thread::spawn(move || std::fs::write(pipe, doubles(&[1.0, 2.0, 3.0, 4.0])))
    };
    let source = PointSource::open(&[file, pipe], &InputOptions::default()).unwrap();
    assert_eq!(source.total_bytes(), None);
    assert_eq!(drain(source).unwrap().points, [(7.0, 8.0), (1.0, 2.0), (3.0, 4.0)]);
    writer.join().unwrap().unwrap();
}
