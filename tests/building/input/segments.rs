//! Segments from files.

use delaunay_tiles::input::{InputError, RecordKind, SegmentBatch, SegmentSource};
use std::fs;
use std::path::PathBuf;

/// Everything that a source returns.
#[derive(Debug)]
pub struct Segments {
    pub ends: Vec<[f64; 4]>,
    pub z: Vec<[f64; 2]>,
    pub records: Vec<[u64; 2]>,
    pub lines: Vec<u64>,
    pub source: SegmentSource,
}

pub fn drain(mut source: SegmentSource) -> Result<Segments, InputError> {
    let (mut ends, mut z, mut records, mut lines) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut batch = SegmentBatch::default();
    while source.next_batch(&mut batch)? {
        let segments = batch.ends.len() + batch.records.len();
        assert!((1..=8192).contains(&segments), "a batch of {segments} segments");
        assert_eq!(batch.lines.len(), segments);
        assert_eq!(batch.z.len(), if source.has_z() { batch.ends.len() } else { 0 });
        assert!(batch.ends.as_flattened().iter().all(|p| p.is_valid()));
        assert!(batch.z.as_flattened().iter().all(|z| !z.is_infinite()));
        for &line in &batch.lines {
            assert!(source.origin(line).is_some());
        }
        ends.extend(batch.ends.iter().map(|[a, b]| [a.x, a.y, b.x, b.y]));
        z.extend_from_slice(&batch.z);
        records.extend_from_slice(&batch.records);
        lines.extend_from_slice(&batch.lines);
    }
    assert!(batch.is_empty() && batch.lines.is_empty());
    assert_eq!(source.segments(), lines.len() as u64);
    assert!(lines.is_sorted());
    let all: u64 = source.sources().iter().map(|(_, lines)| lines).sum();
    assert!(lines.last().is_none_or(|&last| last < all));
    assert_eq!(source.origin(all), None);
    Ok(Segments {
        ends,
        z,
        records,
        lines,
        source,
    })
}

/// Writes files, and opens and reads them.
pub fn open(
    files: &[(&str, &[u8])],
    open: fn(&[PathBuf]) -> Result<SegmentSource, InputError>,
) -> Result<Segments, InputError> {
    let folder = tempfile::tempdir().unwrap();
    let paths: Vec<PathBuf> = files.iter().map(|(name, _)| folder.path().join(name)).collect();
    for (path, (_, content)) in paths.iter().zip(files) {
        fs::write(path, content).unwrap();
    }
    open(&paths).and_then(drain)
}

fn read(files: &[(&str, &[u8])]) -> Result<Segments, InputError> {
    open(files, SegmentSource::open)
}

#[test]
fn line_strings_and_rings_of_geojson_give_segments() {
    let document = r#"{"type":"FeatureCollection","features":[
        {"type":"Feature","properties":{},"geometry":{"type":"Point","coordinates":[9,9]}},
        {"type":"Feature","properties":{},"geometry":{"type":"MultiPoint","coordinates":[[8,8],[7,7]]}},
        {"type":"Feature","properties":{},"geometry":{"type":"LineString","coordinates":[[0,0],[1,0],[1,1,5]]}},
        {"type":"Feature","properties":{},"geometry":{"coordinates":[[[2,0],[3,0]],[[2,1],[3,1]]],"type":"MultiLineString"}},
        {"type":"Feature","properties":{},"geometry":{"coordinates":[[6,6],[5,5]],"type":"MultiPoint"}},
        {"type":"Feature","properties":{},"geometry":null},
        {"type":"Feature","properties":{},"geometry":{"type":"MultiPolygon","coordinates":[[[[0,5],[1,5],[1,6],[0,5]]]]}}]}"#;
    let read_all = read(&[("lines.geojson", document.as_bytes())]).unwrap();
    let expected = [
        [0.0, 0.0, 1.0, 0.0],
        [1.0, 0.0, 1.0, 1.0],
        [2.0, 0.0, 3.0, 0.0],
        [2.0, 1.0, 3.0, 1.0],
        [0.0, 5.0, 1.0, 5.0],
        [1.0, 5.0, 1.0, 6.0],
        [1.0, 6.0, 0.0, 5.0],
    ];
    assert_eq!(read_all.ends, expected);
    assert_eq!(read_all.records, [[0; 2]; 0]);
    assert_eq!(read_all.lines, [2, 2, 3, 3, 6, 6, 6]);
    let wrong = r#"{"type":"LineString","coordinates":[[0,0],[1,0],[1,1e300]]}"#;
    match read(&[("wrong.json", wrong.as_bytes())]) {
        Err(InputError::Record {
            kind: RecordKind::Segment,
            number: 1,
            found,
            ..
        }) => assert!(found.contains("2^200"), "{found}"),
        other => panic!("{other:?}"),
    }
}

/// A feature is a line, whatever its geometry; so is a geometry outside of any feature.
#[test]
fn lines_are_numbered_over_all_files() {
    let collection = r#"{"type":"FeatureCollection","id":1,"properties":{},"features":[{"type":"Feature","geometry":null},
        {"type":"Feature","geometry":{"type":"GeometryCollection","geometries":[
            {"type":"LineString","coordinates":[[0,0],[1,0]]},{"type":"LineString","coordinates":[[0,1],[1,1]]}]}}]}"#;
    let rows = r#"{"type":"LineString","coordinates":[[0,2],[1,2]]}
        {"type":"GeometryCollection","geometries":[]}
        {"type":"Feature","geometry":{"type":"LineString","coordinates":[[0,3],[1,3]]}}"#;
    let pairs: Vec<u8> = [5u32, 6, 7, 8].into_iter().flat_map(u32::to_le_bytes).collect();
    let empty = r#"{"type":"FeatureCollection","features":[]}"#;
    let all = read(&[
        ("a.geojson", collection.as_bytes()),
        ("empty.geojson", empty.as_bytes()),
        ("b.geojsonl", rows.as_bytes()),
        ("c.u32", &pairs),
    ])
    .unwrap();
    assert_eq!(all.lines, [1, 1, 2, 4, 5, 6]);
    let sources = [("a.geojson", 2), ("empty.geojson", 0), ("b.geojsonl", 3), ("c.u32", 2)];
    assert_eq!(
        all.source.sources(),
        sources.map(|(name, lines)| (name.to_owned(), lines))
    );
    for (line, words) in [
        (0, "a.geojson: feature 0 (counted from 0)"),
        (1, "a.geojson: feature 1 (counted from 0)"),
        (2, "b.geojsonl: feature 0 (counted from 0)"),
        (4, "b.geojsonl: feature 2 (counted from 0)"),
        (6, "c.u32: pair 1 (counted from 0)"),
    ] {
        let origin = all.source.origin(line).unwrap();
        assert!(origin.to_string().ends_with(words), "{origin}");
    }
    assert_eq!(all.source.origin(7), None);
}

#[test]
fn z_is_kept_for_all_ends_or_for_none() {
    let high = r#"{"type":"LineString","coordinates":[[0,0,5],[1,0],[2,0,-0.0]]}"#;
    let flat = r#"{"type":"LineString","coordinates":[[0,1],[1,1,7]]}"#;
    let mixed = read(&[
        ("rows.csv", b"0,2,1,2\n"),
        ("high.json", high.as_bytes()),
        ("flat.json", flat.as_bytes()),
    ]);
    let mixed = mixed.unwrap();
    let z = mixed.z.as_flattened().iter().map(|z| (!z.is_nan()).then_some(*z));
    let z: Vec<Option<f64>> = z.collect();
    assert_eq!(z, [None, None, Some(5.0), None, None, Some(0.0), None, Some(7.0)]);
    assert!(z[5].unwrap().is_sign_positive());
    let notes = mixed.source.notes();
    assert_eq!(notes.len(), 3, "{notes:?}");
    for (note, words) in notes.iter().zip([
        "rows.csv: 2 ends have no z, and others have",
        "high.json: 2 ends have no z, and others have",
        "flat.json: 1 ends have no z, and others have",
    ]) {
        assert!(note.ends_with(words), "{note}");
    }
    let flat = read(&[("flat.json", flat.as_bytes())]).unwrap();
    assert!(!flat.source.has_z() && flat.z.is_empty());
    assert!(
        flat.source.notes()[0].contains("flat.json: the z of 1 ends is not kept"),
        "{:?}",
        flat.source.notes()
    );
    let wrong = read(&[(
        "z.json",
        br#"{"type":"LineString","coordinates":[[0,0,1],[1,0,1e999]]}"#,
    )]);
    assert!(
        wrong
            .unwrap_err()
            .to_string()
            .contains("z.json: segment 0 (byte 44): z is inf")
    );
}

/// Batches are bounded, even if a geometry is not.
#[test]
fn a_line_longer_than_a_batch_keeps_its_segments() {
    let positions: Vec<String> = (0..30_000).map(|x| format!("[{x},{}]", x % 7)).collect();
    let text = format!(r#"{{"coordinates":[{}],"type":"LineString"}}"#, positions.join(","));
    let all = read(&[("long.json", text.as_bytes())]).unwrap();
    assert_eq!(all.ends.len(), 29_999);
    for (n, [x1, y1, x2, y2]) in all.ends.iter().enumerate() {
        let n = n as f64;
        assert_eq!([*x1, *y1, *x2, *y2], [n, n % 7.0, n + 1.0, (n + 1.0) % 7.0]);
    }
}

#[test]
fn rows_with_and_without_a_header_give_the_same_segments() {
    let expected = [[0.0, 1.0, 2.0, 3.0], [4.0, 5.0, -6.5, 7.0]];
    for text in [
        "0,1,2,3\n4,5,-6.5,7\n",
        "x1;y1;x2;y2;name\n0;1;2;3;a\n# no row\n4;5;-6.5;7;b",
        "0 1 2 3\n4 5 -6.5 7\n",
    ] {
        let all = read(&[("rows.csv", text.as_bytes())]).unwrap();
        assert_eq!(all.ends, expected, "{text}");
        assert_eq!(all.lines, [0, 1]);
        assert!(
            all.source
                .origin(1)
                .unwrap()
                .to_string()
                .ends_with("rows.csv: row 1 (counted from 0)")
        );
    }
    for (text, line) in [("0,1,2,3\n4,5,6\n", 2), ("0,1,2,nan\n", 1), ("a,b,c,d\n0,1,2,e\n", 2)] {
        match read(&[("rows.csv", text.as_bytes())]) {
            Err(
                error @ InputError::Record {
                    kind: RecordKind::Segment,
                    ..
                },
            ) => {
                assert!(error.to_string().contains(&format!("line {line}")), "{error}")
            }
            other => panic!("{text}: {other:?}"),
        }
    }
}

#[test]
fn pairs_of_record_numbers_are_read_over_several_files() {
    let small: Vec<u8> = (0..40_000u32).flat_map(u32::to_le_bytes).collect();
    let large: Vec<u8> = [1u64 << 40, 3].into_iter().flat_map(u64::to_le_bytes).collect();
    let all = read(&[("a.u32", &small), ("empty.u32", &[]), ("b.u64", &large)]).unwrap();
    assert_eq!(all.records.len(), 20_001);
    assert_eq!(all.records[7], [14, 15]);
    assert_eq!(all.records[20_000], [1 << 40, 3]);
    assert!(all.lines.iter().copied().eq(0..20_001));
    assert!(all.ends.is_empty() && all.z.is_empty() && all.source.notes().is_empty());
    let cut = read(&[("a.u32", &small[..small.len() - 3])]);
    assert!(matches!(cut, Err(InputError::Malformed { .. })), "{cut:?}");
    let unknown = read(&[("a.f64", &small)]);
    assert!(
        matches!(
            unknown,
            Err(InputError::UnknownFormat {
                kind: RecordKind::Segment,
                ..
            })
        ),
        "{unknown:?}"
    );
    let missing = SegmentSource::open(&[PathBuf::from("no/such.u32")]).map(|_| ());
    assert!(matches!(missing, Err(InputError::Open { .. })), "{missing:?}");
}

/// A named pipe can be read only once, so it stays open from the first open on.
#[cfg(unix)]
#[test]
fn a_named_pipe_among_files_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let [file, pipe] = ["first.u32", "second.u32"].map(|name| folder.path().join(name));
    fs::write(&file, [1u32, 2].map(u32::to_le_bytes).concat()).unwrap();
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    if !made.is_ok_and(|status| status.success()) {
        println!("skipped: no mkfifo");
        return;
    }
    let writer = {
        let pipe = pipe.clone();
        std::thread::spawn(move || fs::write(pipe, [3u32, 4].map(u32::to_le_bytes).concat()))
    };
    let all = SegmentSource::open(&[file, pipe]).and_then(drain).unwrap();
    assert_eq!(all.records, [[1, 2], [3, 4]]);
    writer.join().unwrap().unwrap();
}
