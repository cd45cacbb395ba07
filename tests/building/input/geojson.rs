//! GeoJSON.

use crate::input::{assert_says, data, drain, file, skipping, stream, with_format};
use delaunay_tiles::input::{Format, InputOptions, MissingZ, PointSource};

fn read(text: &str) -> Result<crate::input::Read, delaunay_tiles::input::InputError> {
    stream(text, &with_format(Format::GeoJson))
}

#[test]
fn every_geometry_type_gives_its_positions() {
    let cases: [(&str, &[(f64, f64)]); 9] = [
        (r#"{"type":"Point","coordinates":[1,2]}"#, &[(1.0, 2.0)]),
        (
            r#"{"coordinates":[[1,2],[3,4]],"type":"MultiPoint"}"#,
            &[(1.0, 2.0), (3.0, 4.0)],
        ),
        (
            r#"{"type":"LineString","coordinates":[[1,2],[3,4]]}"#,
            &[(1.0, 2.0), (3.0, 4.0)],
        ),
        (
            r#"{"type":"Polygon","coordinates":[[[0,0],[1,0],[0,1],[0,0]]]}"#,
            &[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.0, 0.0)],
        ),
        (
            r#"{"type":"MultiPolygon","coordinates":[[[[0,0],[1,0],[0,1],[0,0]]],[]]}"#,
            &[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.0, 0.0)],
        ),
        (
            r#"{"type":"GeometryCollection","geometries":[{"type":"Point","coordinates":[1,2]},
               {"type":"MultiLineString","coordinates":[[[3,4],[5,6]]]}]}"#,
            &[(1.0, 2.0), (3.0, 4.0), (5.0, 6.0)],
        ),
        (
            r#"{"type":"Feature","geometry":null,"properties":{"coordinates":[[7,8]]}}"#,
            &[],
        ),
        (r#"{"type":"Polygon","coordinates":[]}"#, &[]),
        (r#"{"type":"FeatureCollection","features":[]}"#, &[]),
    ];
    for (text, points) in cases {
        assert_eq!(read(text).unwrap().points, points, "{text}");
    }
}

/// A `bbox` and a `crs` before `features`, members in any order, escapes in names, and a byte-order
/// mark.
#[test]
fn foreign_members_in_any_order_do_not_change_the_points() {
    let text = "\u{feff}".to_owned()
        + r#"{"bbox":[0,0,9,9],"crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::25832"}},
        "n\u0061me":"a \"b\" \ud83d\ude00 \\","features":[
        {"geometry":{"coordinates":[1.5,-2E+1],"type":"Point","bbox":[[3]]},"type":"Feature","id":[{}, [true,false,null]]},
        {"type":"Feature"},
        {"type":"Feature","properties":null,"geom\u0065try":{"type":"Point","coordinates":[-0.0,4,5,6]}}
        ],"type":"FeatureCollection"}"#;
    let read = file("a.geojson", text, &InputOptions::default()).unwrap();
    assert_eq!(read.points, [(1.5, -20.0), (0.0, 4.0)]);
    assert_eq!(read.source.crs_of_files()[0].1, "urn:ogc:def:crs:EPSG::25832");
    // The first position decides whether the source has z.
    assert!(!read.source.has_z());
}

#[test]
fn a_position_without_z_is_refused_or_gets_zero() {
    let text = r#"{"type":"LineString","coordinates":[[1,2,3],[4,5],[6,7,8,9]]}"#;
    assert_says(
        file("a.json", text, &InputOptions::default()),
        &[
            "a.json: byte 44: record 1 has no z, and other points have",
            "(option `missing_z`: zero)",
        ],
    );
    let zero = InputOptions::default().missing_z(MissingZ::Zero);
    let read = file("a.json", text, &zero).unwrap();
    assert_eq!(read.z, [3.0, 0.0, 8.0]);
    let notes = read.source.notes();
    assert!(notes[0].ends_with("a.json: 1 lines give their 3 vertices"), "{notes:?}");
    assert!(notes[1].ends_with("a.json: 1 points without z got z = 0"), "{notes:?}");
}

#[test]
fn concatenated_features_are_read_one_after_the_other() {
    let feature = r#"{"type":"Feature","properties":{},"geometry":{"type":"Point","coordinates":[1,2]}}"#;
    for between in ["\n", "\r\n", "", "\n\u{1e}"] {
        let text = [feature, feature, feature].join(between);
        let read = file("a.geojsonl", &text, &InputOptions::default()).unwrap();
        assert_eq!(read.records, [0, 1, 2]);
        // A stream without a name is recognized by its first brace.
        assert_eq!(stream(&text, &InputOptions::default()).unwrap().points, read.points);
    }
}

#[test]
fn invalid_positions_are_refused_or_skipped() {
    let text = r#"{"type":"MultiPoint","coordinates":[[1,2],[3],[],[null,4],["5",6],[1e999,7],[1e100,8],[9,10]]}"#;
    let all = read(text);
    assert_says(
        all,
        &[
            "stream: record 1 (byte 42): the position has 1 of at least 2 elements",
            "`skip_invalid`",
        ],
    );
    let options = with_format(Format::GeoJson).skip_invalid(true);
    let read = stream(text, &options).unwrap();
    assert_eq!(read.points, [(1.0, 2.0), (9.0, 10.0)]);
    assert_eq!(read.records, [0, 7]);
}

#[test]
fn a_broken_document_is_refused_with_its_byte_and_reason() {
    for (text, parts) in [
        ("", &["byte 0: the file is empty"][..]),
        (" \n", &["the file is empty"]),
        ("[]", &["byte 0: this is not an object; expected GeoJSON (RFC 7946)"]),
        ("{}", &["byte 1: an object without a `type`"]),
        (r#"{"type":"Topology"}"#, &["the type `Topology` is not a GeoJSON type"]),
        (r#"{"type":7}"#, &["`type` is not a string"]),
        (
            r#"{"type":"Point","coordinates":[1,2]"#,
            &["byte 35: the file ends in the middle of a value"],
        ),
        (
            r#"{"type":"Point","coordinates":[1,]}"#,
            &["byte 32: trailing comma not enabled; this is not JSON"],
        ),
        (r#"{"type":"Point","coordinates":[1 2]}"#, &["byte 33: missing comma"]),
        (
            r#"{"type":"Point","coordinates":[01,2]}"#,
            &["byte 31: malformed number"],
        ),
        (
            r#"{"type":"Point","coordinates":[1.,2]}"#,
            &["byte 31: malformed number"],
        ),
        (
            r#"{"type":"Point","coordinates":[NaN,2]}"#,
            &["byte 31: malformed json"],
        ),
        (
            r#"{"type":"Point","coordinates":[nil,2]}"#,
            &["byte 31: invalid literal"],
        ),
        (
            r#"{"type":"Point","coordinates":{}}"#,
            &["`coordinates` is not an array"],
        ),
        (
            r#"{"type":"Point","coordinates":[[1,2]]}"#,
            &["an object of type Point has wrong members"],
        ),
        (
            r#"{"type":"Polygon","coordinates":[[1,2],[3,4]]}"#,
            &["an object of type Polygon has wrong members"],
        ),
        (
            r#"{"type":"MultiPoint","coordinates":[[1,2],3]}"#,
            &["positions and arrays mixed"],
        ),
        (
            r#"{"type":"MultiPoint","coordinates":[[1,[2]]]}"#,
            &["an array too deep"],
        ),
        (
            r#"{"type":"FeatureCollection"}"#,
            &["an object of type FeatureCollection has wrong members"],
        ),
        (
            r#"{"type":"FeatureCollection","features":{}}"#,
            &["`features` is not an array"],
        ),
        (
            r#"{"type":"FeatureCollection","features":[3]}"#,
            &["this is not an object"],
        ),
        (
            r#"{"type":"FeatureCollection","features":[{"type":"Point","coordinates":[1,2]}]}"#,
            &["an object of type Point has wrong members, or is in the wrong position"],
        ),
        (
            r#"{"type":"FeatureCollection","features":[],"coordinates":[1,2]}"#,
            &["an object of type FeatureColl"],
        ),
        (r#"{"a":"b"#, &["the file ends in the middle of a value"]),
        ("{\"a\":\"\n\"}", &["byte 6: not escaped control character"]),
        (r#"{"a" 1}"#, &["byte 5: missing colon"]),
        (r#"{"a":"\x"}"#, &["byte 6: unknown escape sequence"]),
        (r#"{"a":"\u12g4"}"#, &["byte 6: malformed escape sequence"]),
        (r#"{1:2}"#, &["byte 1: expecting member name or object end"]),
        (
            r#"{"type":"Point","coordinates":[1,2]} x"#,
            &["byte 37: malformed json"],
        ),
        (
            r#"{"type":"Point","coordinates":[1,2]} 7"#,
            &["byte 37: this is not an object"],
        ),
    ] {
        assert_says(read(text), parts);
        assert!(stream(text, &with_format(Format::GeoJson).skip_invalid(true)).is_err());
    }
    assert_says(read(&r#"{"a":"#.repeat(200_000)), &["nesting deeper than 128"]);
    assert_says(
        read(&format!(r#"{{"a":{}}}"#, "[".repeat(200_000))),
        &["nesting deeper than 128"],
    );
    let digits = "1".repeat(200_000);
    assert_says(
        read(&format!(r#"{{"type":"Point","coordinates":[{digits},2]}}"#)),
        &["record 0 (byte 30): x is inf, not a finite number"],
    );
    assert_says(
        read(&format!(
            r#"{{"type":"Point","coordinates":[{},2]}}"#,
            digits.repeat(20)
        )),
        &["a name, number or string of more than 2097152 bytes"],
    );
    assert_says(
        read(&format!(r#"{{"{}":2}}"#, digits.repeat(20))),
        &["a name, number or string of more than 2097152 bytes"],
    );
    let passed_over = format!(
        r#"{{"a":["{0}",{0}],"type":"Point","coordinates":[1,2]}}"#,
        digits.repeat(20)
    );
    assert_eq!(read(&passed_over).unwrap().points, [(1.0, 2.0)]);
    assert_says(
        stream(b"{\"a\":\"\xfc\"}", &with_format(Format::GeoJson)),
        &["byte 6: invalid UTF-8 data; this is not JSON, or not in UTF-8"],
    );
    let long = format!(
        r#"{{"{0}":"{0}","type":"Point","coordinates":[1,2]}}"#,
        "long ".repeat(300_000)
    );
    assert_eq!(read(&long).unwrap().points, [(1.0, 2.0)]);
}

/// The crate `geojson` gives the same coordinates in the same order.
#[test]
fn positions_of_a_map_equal_those_of_the_geojson_crate() {
    let path = data("indonesia/indonesia_ne10m.geojson");
    let read = drain(PointSource::open(std::slice::from_ref(&path), &InputOptions::default()).unwrap()).unwrap();
    // 23,541 vertices; each of 339 rings repeats its first position at its end.
    assert_eq!(read.points.len(), 23_541 + 339);
    let mut distinct: Vec<_> = read.points.iter().map(|p| (p.0.to_bits(), p.1.to_bits())).collect();
    distinct.sort_unstable();
    distinct.dedup();
    assert_eq!(distinct.len(), 23_541);
    assert!(!read.source.has_z());
    let note = read.source.notes()[0].clone();
    assert!(
        note.ends_with("indonesia_ne10m.geojson: 339 polygons give their 23880 vertices"),
        "{note}"
    );

    let text = std::fs::read_to_string(path).unwrap();
    let geojson::GeoJson::FeatureCollection(collection) = text.parse().unwrap() else {
        panic!("not a collection");
    };
    let mut expected = Vec::new();
    for feature in collection.features {
        let geojson::GeometryValue::Polygon { coordinates } = feature.geometry.unwrap().value else {
            panic!("not a polygon");
        };
        expected.extend(coordinates.iter().flatten().map(|p| (p[0], p[1])));
    }
    assert_eq!(read.points, expected);
}

#[test]
fn a_document_cut_short_at_any_length_is_refused() {
    let text = r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{"a":"b\n\u0041","c":[true,null]},
        "geometry":{"type":"LineString","coordinates":[[1.5e2,2],[3,4,5]]}}]}"#;
    for length in 0..text.len() {
        assert!(read(&text[..length]).is_err(), "{length}");
        assert!(file("a.geojson", &text[..length], &skipping()).is_err(), "{length}");
    }
    assert_eq!(read(text).unwrap().points.len(), 2);
}
