//! Sites from files.

use crate::input::gzip;
use delaunay_tiles::input::{InputError, RecordKind, SiteBatch, SiteId, SiteSource};
use std::fs;
use std::path::PathBuf;

/// Everything that a source returns.
#[derive(Debug)]
pub struct Sites {
    pub points: Vec<(f64, f64)>,
    pub z: Vec<f64>,
    pub ids: Vec<SiteId>,
    pub source: SiteSource,
}

pub fn drain(mut source: SiteSource) -> Result<Sites, InputError> {
    let (mut points, mut z, mut ids) = (Vec::new(), Vec::new(), Vec::new());
    let mut batch = SiteBatch::default();
    while source.next_batch(&mut batch)? {
        assert!((1..=8192).contains(&batch.len()), "a batch of {} sites", batch.len());
        assert_eq!(batch.ids.len(), batch.len());
        assert_eq!(batch.z.len(), if source.has_z() { batch.len() } else { 0 });
        assert!(batch.points.iter().all(|p| p.is_valid()));
        points.extend(batch.points.iter().map(|p| (p.x, p.y)));
        z.extend_from_slice(&batch.z);
        ids.extend_from_slice(&batch.ids);
    }
    assert!(batch.is_empty());
    assert_eq!(source.sites(), points.len() as u64);
    assert_eq!(
        source.sites(),
        source.sources().iter().map(|(_, sites)| sites).sum::<u64>()
    );
    Ok(Sites { points, z, ids, source })
}

fn read(files: &[(&str, &[u8])], id_field: Option<&str>) -> Result<Sites, InputError> {
    let folder = tempfile::tempdir().unwrap();
    let paths: Vec<PathBuf> = files.iter().map(|(name, _)| folder.path().join(name)).collect();
    for (path, (_, content)) in paths.iter().zip(files) {
        fs::write(path, content).unwrap();
    }
    SiteSource::open(&paths, id_field).and_then(drain)
}

fn text(name: &str) -> SiteId {
    SiteId::Text(name.to_owned())
}

/// Returns the ids of a file with this content.
#[track_caller]
fn ids(name: &str, content: &str, id_field: Option<&str>) -> Vec<SiteId> {
    read(&[(name, content.as_bytes())], id_field).unwrap().ids
}

#[track_caller]
fn assert_says(result: Result<Sites, InputError>, parts: &[&str]) {
    let error = result.map(|all| all.ids).unwrap_err().to_string();
    for part in parts {
        assert!(error.contains(part), "`{part}` is not in: {error}");
    }
}

#[test]
fn ids_of_rows_are_taken_from_the_named_or_third_column() {
    use SiteId::Number;
    let expected = [text("a b"), Number(7), text("007"), text("-7"), text("7.0")];
    let rows = "1,2,a b\n3,4,7\n# none\n5,6,007\n7,8,-7\n9,10,7.0\n";
    let all = read(&[("a.csv", rows.as_bytes())], None).unwrap();
    assert_eq!(all.ids, expected);
    assert_eq!(
        all.points,
        [(1.0, 2.0), (3.0, 4.0), (5.0, 6.0), (7.0, 8.0), (9.0, 10.0)]
    );
    assert!(!all.source.has_z());
    // No header and no third column, or a third column with another name.
    assert_eq!(ids("a.txt", "1 2\n3 4\n", None), [Number(0), Number(1)]);
    assert_eq!(ids("a.csv", "x,y,name\n1,2,a\n3,4,b\n", None), [Number(0), Number(1)]);
    // A header with a column `id` at any position, or with an empty third name.
    assert_eq!(ids("a.csv", "ID;lat;lon\n5;1;2\n6;3;4\n", None), [Number(5), Number(6)]);
    assert_eq!(ids("a.csv", "x,y,\n1,2,five\n", None), [text("five")]);
    // A column that is chosen by name or by number.
    let named = "lon,lat,Name,id\n1,2,a,3\n";
    assert_eq!(ids("a.csv", named, Some("name")), [text("a")]);
    assert_eq!(ids("a.csv", named, Some("id")), [Number(3)]);
    assert_eq!(ids("a.csv", named, Some("4")), [Number(3)]);
    assert_eq!(ids("a.csv", named, None), [Number(3)]);
    assert_eq!(ids("a.csv", "1,2,3,4\n", Some("4")), [Number(4)]);
    assert_eq!(ids("a.csv", "", Some("name")), []);
    let largest = "1,2,18446744073709551615\n1,2,18446744073709551616\n";
    assert_eq!(
        ids("a.csv", largest, None),
        [Number(u64::MAX), text("18446744073709551616")]
    );
    for id in ids("a.csv", largest, None) {
        assert!(largest.contains(&id.to_string()));
    }
}

#[test]
fn rows_without_valid_position_or_id_are_refused() {
    let one = |content: &str, id_field| read(&[("a.csv", content.as_bytes())], id_field);
    assert_says(
        one("1,2,a\n3,4\n", None),
        &["a.csv: site 1 (line 2): the row has no column 3 for the id: `3,4`"],
    );
    assert_says(one("1,2,a\n3,4,\n", None), &["a.csv: site 1 (line 2): the id is empty"]);
    assert_says(
        one("1,2,a\n3,up,b\n", None),
        &["a.csv: site 1 (line 2): y is `up`, not a number"],
    );
    assert_says(
        one("1,2,a\n1e300,0,b\n", None),
        &["site 1 (line 2): x is 1e300", "2^200"],
    );
    assert_says(
        one("x,y,n\n1,2,a\n", Some("name")),
        &[
            "a.csv: line 1: no column `name`",
            "`x,y,n`",
            "the id field is the name of a column",
        ],
    );
    assert_says(
        one("1,2,a\n", Some("name")),
        &["a.csv: line 1: no column `name`", "`1,2,a`"],
    );
    assert_says(one("1,2,a\n", Some("4")), &["no column `4`"]);
    assert_says(one("1,2,a\n", Some("0")), &["no column `0`"]);
    assert_says(one("a,b\n1,2\n", None), &["no column for x"]);
    let long = format!("1,2,{}\n", "n".repeat(SiteId::LONGEST));
    assert_eq!(one(&long, None).unwrap().ids.len(), 1);
    let longer = long.replace('\n', "n\n");
    assert_says(
        one(&longer, None),
        &["a.csv: site 0 (line 1): the id has 1025 bytes; the limit is 1024"],
    );
    let bytes = read(&[("a.csv", b"1,2,\xff\n")], None);
    assert_says(bytes, &["site 0 (line 1): the id is not in UTF-8"]);
    for name in ["a.f64", "a.node", "a.u32", "a"] {
        assert!(
            matches!(
                read(&[(name, b"")], None),
                Err(InputError::UnknownFormat {
                    kind: RecordKind::Site,
                    ..
                })
            ),
            "{name}"
        );
    }
}

const FEATURES: &str = r#"{"type":"FeatureCollection","id":"none","properties":{"name":"none"},"features":[
    {"type":"Feature","id":"first","properties":{"name":"a","rank":1,"id":null},"geometry":{"type":"Point","coordinates":[1,2]}},
    {"type":"Feature","geometry":{"coordinates":[[3,4],[5,6]],"type":"MultiPoint"},"properties":{"rank":2,"name":"b","nested":{"name":"c"}},"id":5},
    {"type":"Feature","geometry":null,"properties":null},
    {"type":"Feature","id":6,"properties":{"name":"","rank":3.5,"id":"own"},"geometry":{"type":"GeometryCollection","geometries":[
        {"type":"Point","coordinates":[7,8]},{"type":"LineString","coordinates":[[9,9],[9,8]]},
        {"coordinates":[[9,9],[9,8]],"type":"LineString"},{"type":"MultiPoint","coordinates":[[9,10]]}]}}]}"#;

#[test]
fn points_of_geojson_give_sites_with_their_ids() {
    use SiteId::Number;
    let all = read(&[("a.geojson", FEATURES.as_bytes())], None).unwrap();
    assert_eq!(
        all.points,
        [(1.0, 2.0), (3.0, 4.0), (5.0, 6.0), (7.0, 8.0), (9.0, 10.0)]
    );
    assert_eq!(all.ids, [0, 1, 2, 3, 4].map(Number));
    let note = "a.geojson: 2 geometries are no points, and give no sites";
    assert!(all.source.notes()[0].ends_with(note), "{:?}", all.source.notes());
    assert_eq!(
        ids("a.geojson", FEATURES, Some("rank")),
        [Number(1), Number(2), Number(2), text("3.5"), text("3.5")]
    );
    // The member `id` is used if there is no property of that name.
    assert_eq!(
        ids("a.geojson", FEATURES, Some("id")),
        [text("first"), Number(5), Number(5), text("own"), text("own")]
    );
    let found = read(&[("a.geojson", FEATURES.as_bytes())], Some("name"));
    assert_says(found, &["a.geojson: site 3 (byte ", "the id is empty"]);
}

#[test]
fn features_without_the_wanted_id_are_refused() {
    let point = r#""geometry":{"type":"Point","coordinates":[1,2]}"#;
    for (members, parts) in [
        ("", &["there is no property `name` for the id"][..]),
        (r#""properties":{"other":1},"#, &["there is no property `name`"]),
        (r#""properties":{"name":null},"#, &["there is no property `name`"]),
        (r#""properties":[1],"id":7,"#, &["there is no property `name`"]),
        (
            r#""properties":{"name":[1]},"#,
            &["the id is neither text nor a number"],
        ),
        (
            r#""properties":{"name":true},"#,
            &["the id is neither text nor a number"],
        ),
    ] {
        let good = format!(r#"{{"type":"Feature","properties":{{"name":"a"}},{point}}}"#);
        let document = format!(r#"{good}{{"type":"Feature",{members}{point}}}"#);
        let all = read(&[("a.geojson", document.as_bytes())], Some("name"));
        assert_says(all, parts);
        let all = read(&[("a.geojson", document.as_bytes())], Some("name"));
        assert_says(all, &[&format!("a.geojson: site 1 (byte {})", good.len())]);
    }
    let bare = read(&[("a.json", br#"{"type":"Point","coordinates":[1,2]}"#)], Some("name"));
    assert_says(bare, &["a.json: site 0 (byte 0): there is no property `name`"]);
    // A feature without points needs no id.
    let none = r#"{"type":"Feature","geometry":null}{"type":"Feature","geometry":{"type":"LineString","coordinates":[[0,0],[1,1]]}}"#;
    assert_eq!(ids("a.json", none, Some("name")), []);
    let long = format!(r#"{{"type":"Feature","id":"{}",{point}}}"#, "n".repeat(1025));
    assert_says(
        read(&[("a.json", long.as_bytes())], Some("id")),
        &["the id has 1025 bytes"],
    );
    let digits = format!(r#"{{"type":"Feature","id":{},{point}}}"#, "1".repeat(1025));
    assert_says(
        read(&[("a.json", digits.as_bytes())], Some("id")),
        &["the id has 1025 bytes"],
    );
    let invalid = r#"{"type":"MultiPoint","coordinates":[[1,2],[1,null]]}"#;
    assert_says(
        read(&[("a.json", invalid.as_bytes())], None),
        &["a.json: site 1 (byte 42): an element of the position is not a number"],
    );
}

#[test]
fn sites_of_several_files_share_z_and_numbers() {
    let line = r#"{"type":"MultiPoint","coordinates":[[1,2],[3,4,5]]}"#;
    let zipped = gzip(b"x,y,z\n5,6,7\n");
    let files: [(&str, &[u8]); 3] = [("a.csv", b"8,9\n"), ("b.csv.gz", &zipped), ("c.json", line.as_bytes())];
    let all = read(&files, None).unwrap();
    assert!(
        matches!(all.z[..], [a, 7.0, c, 5.0] if a.is_nan() && c.is_nan()),
        "{:?}",
        all.z
    );
    assert_eq!(all.ids, [0, 1, 2, 3].map(SiteId::Number));
    assert_eq!(
        all.source.sources(),
        [("a.csv", 1), ("b.csv.gz", 1), ("c.json", 2)].map(|(name, n)| (name.to_owned(), n))
    );
    let notes = all.source.notes();
    assert_eq!(notes.len(), 2, "{notes:?}");
    assert!(
        notes[0].ends_with("a.csv: 1 sites have no z, and others have"),
        "{notes:?}"
    );
    assert!(
        notes[1].ends_with("c.json: 1 sites have no z, and others have"),
        "{notes:?}"
    );
    let flat = read(&files[2..], None).unwrap();
    assert!(!flat.source.has_z() && flat.z.is_empty());
    let bad = read(&[("a.csv", b"8,9\n9,9\n"), ("b.csv", b"1,2\nx,2\n")], None);
    assert!(
        matches!(
            bad,
            Err(InputError::Record {
                kind: RecordKind::Site,
                number: 3,
                ..
            })
        ),
        "{bad:?}"
    );
}

/// Batches are bounded, even if a feature is not.
#[test]
fn more_sites_than_a_batch_are_read() {
    let positions: Vec<String> = (0..20_000).map(|n| format!("[{n},1]")).collect();
    let content = format!(
        r#"{{"type":"Feature","geometry":{{"type":"MultiPoint","coordinates":[{}]}},"id":"all"}}"#,
        positions.join(",")
    );
    let all = read(&[("a.json", content.as_bytes())], Some("id")).unwrap();
    assert!(all.points.iter().enumerate().all(|(n, p)| *p == (n as f64, 1.0)));
    assert_eq!(all.ids, vec![text("all"); 20_000]);
    let rows: String = (0..20_000).map(|n| format!("{n},1\n")).collect();
    assert!(
        ids("a.csv", &rows, None)
            .into_iter()
            .eq((0..20_000).map(SiteId::Number))
    );
}
