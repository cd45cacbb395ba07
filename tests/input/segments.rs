//! Segments from files.

use delaunay_tiles::input::{InputError, SegmentBatch, SegmentSource};
use std::fs;
use std::path::PathBuf;

/// All ends, and all pairs of records.
type Read = (Vec<[f64; 4]>, Vec<[u64; 2]>);

fn read(files: &[(&str, &[u8])]) -> Result<Read, InputError> {
    let folder = tempfile::tempdir().unwrap();
    let paths: Vec<PathBuf> = files
        .iter()
        .map(|(name, content)| {
            let path = folder.path().join(name);
            fs::write(&path, content).unwrap();
            path
        })
        .collect();
    let mut source = SegmentSource::open(&paths)?;
    let (mut batch, mut all) = (SegmentBatch::default(), Read::default());
    while source.next_batch(&mut batch)? {
        assert!(!batch.is_empty());
        all.0.extend(batch.ends.iter().map(|[a, b]| [a.x, a.y, b.x, b.y]));
        all.1.extend_from_slice(&batch.records);
    }
    assert_eq!(source.segments(), (all.0.len() + all.1.len()) as u64);
    Ok(all)
}

#[cfg(feature = "geojson")]
#[test]
fn lines_and_rings_of_geojson() {
    let document = r#"{"type":"FeatureCollection","features":[
        {"type":"Feature","properties":{},"geometry":{"type":"Point","coordinates":[9,9]}},
        {"type":"Feature","properties":{},"geometry":{"type":"MultiPoint","coordinates":[[8,8],[7,7]]}},
        {"type":"Feature","properties":{},"geometry":{"type":"LineString","coordinates":[[0,0],[1,0],[1,1,5]]}},
        {"type":"Feature","properties":{},"geometry":{"coordinates":[[[2,0],[3,0]],[[2,1],[3,1]]],"type":"MultiLineString"}},
        {"type":"Feature","properties":{},"geometry":{"coordinates":[[6,6],[5,5]],"type":"MultiPoint"}},
        {"type":"Feature","properties":{},"geometry":null},
        {"type":"Feature","properties":{},"geometry":{"type":"MultiPolygon","coordinates":[[[[0,5],[1,5],[1,6],[0,5]]]]}}]}"#;
    let (ends, records) = read(&[("lines.geojson", document.as_bytes())]).unwrap();
    let expected = [
        [0.0, 0.0, 1.0, 0.0],
        [1.0, 0.0, 1.0, 1.0],
        [2.0, 0.0, 3.0, 0.0],
        [2.0, 1.0, 3.0, 1.0],
        [0.0, 5.0, 1.0, 5.0],
        [1.0, 5.0, 1.0, 6.0],
        [1.0, 6.0, 0.0, 5.0],
    ];
    assert_eq!(ends, expected);
    assert_eq!(records, [[0; 2]; 0]);
    let wrong = r#"{"type":"LineString","coordinates":[[0,0],[1,0],[1,1e300]]}"#;
    match read(&[("wrong.json", wrong.as_bytes())]) {
        Err(InputError::Segment { segment: 1, found, .. }) => assert!(found.contains("2^200"), "{found}"),
        other => panic!("{other:?}"),
    }
}

#[cfg(feature = "text")]
#[test]
fn rows_with_and_without_a_header() {
    let expected = [[0.0, 1.0, 2.0, 3.0], [4.0, 5.0, -6.5, 7.0]];
    for text in [
        "0,1,2,3\n4,5,-6.5,7\n",
        "x1;y1;x2;y2;name\n0;1;2;3;a\n# no row\n4;5;-6.5;7;b",
        "0 1 2 3\n4 5 -6.5 7\n",
    ] {
        assert_eq!(read(&[("rows.csv", text.as_bytes())]).unwrap().0, expected, "{text}");
    }
    for (text, line) in [("0,1,2,3\n4,5,6\n", 2), ("0,1,2,nan\n", 1), ("a,b,c,d\n0,1,2,e\n", 2)] {
        match read(&[("rows.csv", text.as_bytes())]) {
            Err(error @ InputError::Segment { .. }) => {
                assert!(error.to_string().contains(&format!("line {line}")), "{error}")
            }
            other => panic!("{text}: {other:?}"),
        }
    }
}

#[test]
fn pairs_of_record_numbers_over_several_files() {
    let small: Vec<u8> = (0..40_000u32).flat_map(u32::to_le_bytes).collect();
    let large: Vec<u8> = [1u64 << 40, 3].into_iter().flat_map(u64::to_le_bytes).collect();
    let (_, records) = read(&[("a.u32", &small), ("empty.u32", &[]), ("b.u64", &large)]).unwrap();
    assert_eq!(records.len(), 20_001);
    assert_eq!(records[7], [14, 15]);
    assert_eq!(records[20_000], [1 << 40, 3]);
    let cut = read(&[("a.u32", &small[..small.len() - 3])]);
    assert!(matches!(cut, Err(InputError::Malformed { .. })), "{cut:?}");
    let unknown = read(&[("a.f64", &small)]);
    assert!(
        matches!(unknown, Err(InputError::UnknownSegments { .. })),
        "{unknown:?}"
    );
}
