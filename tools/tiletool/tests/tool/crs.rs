//! Coordinate reference systems of inputs and outputs, and the selection of points.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::support::{fails, json as report, run};

const UTM: &str = "urn:ogc:def:crs:EPSG::25832";

/// Writes a GeoJSON file of a geometry, in the system of a URN.
fn write(folder: &Path, name: &str, urn: Option<&str>, geometry: &Value) {
    let mut document = json!({"type": "FeatureCollection"});
    if let Some(urn) = urn {
        document["crs"] = json!({"type": "name", "properties": {"name": urn}});
    }
    document["features"] = json!([{"type": "Feature", "properties": {}, "geometry": geometry}]);
    // The member must come before the features; objects are in the order of their keys.
    fs::write(folder.join(name), document.to_string()).unwrap();
}

fn points(offset: f64) -> Value {
    let at = |i: u32| json!([offset + f64::from(i % 10), f64::from(i / 10)]);
    json!({"type": "MultiPoint", "coordinates": (0..100).map(at).collect::<Vec<_>>()})
}

fn line(offset: f64) -> Value {
    json!({"type": "LineString", "coordinates": [[offset + 1.5, 1.5], [offset + 7.5, 6.0]]})
}

#[test]
fn files_in_different_systems_are_an_error_that_names_both() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    write(folder, "p.geojson", Some(UTM), &points(500.0));
    write(folder, "l.geojson", Some("urn:ogc:def:crs:EPSG::26917"), &line(500.0));
    let build = "build p.geojson --segments l.geojson -o a.tiles";
    let error = fails(folder, 1, build);
    for part in ["p.geojson", "l.geojson", "EPSG:25832", "EPSG:26917", "--crs"] {
        assert!(error.contains(part), "{part}: {error}");
    }
    assert!(!folder.join("a.tiles").exists());
    // The option overrides what both say.
    run(folder, &format!("{build} --crs EPSG:25832"));
    assert_eq!(report(folder, "inspect a.tiles --json")["epsg"], 25832);
    // An edit is checked against the file.
    let edit = "constrain a.tiles --segments m.geojson";
    write(
        folder,
        "m.geojson",
        Some("urn:ogc:def:crs:OGC:1.3:CRS84"),
        &line(500.25),
    );
    let error = fails(folder, 1, edit);
    assert!(error.contains("m.geojson") && error.contains("a.tiles"), "{error}");
    write(
        folder,
        "m.geojson",
        Some(UTM),
        &json!({"type": "LineString", "coordinates": [[502.5, 7.5], [503.5, 7.0]]}),
    );
    run(folder, edit);
    assert!(fails(folder, 2, "build p.geojson -o b.tiles --crs 25832").contains("EPSG:25832"));
}

#[test]
fn the_system_is_kept_shown_and_written_by_queries() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    write(folder, "p.geojson", Some(UTM), &points(500.0));
    run(folder, "build p.geojson -o a.tiles");
    let inspected = report(folder, "inspect a.tiles --json");
    let of = |key: &str| inspected[key].clone();
    assert_eq!(
        ["crs", "crs_name", "epsg", "unit", "is_geographic"].map(of),
        [
            json!(UTM),
            json!("ETRS89 / UTM zone 32N"),
            json!(25832),
            json!("m"),
            json!(false)
        ]
    );
    assert!(run(folder, "inspect a.tiles").contains("EPSG:25832, ETRS89 / UTM zone 32N, in m"));
    for query in [
        "locate a.tiles --at 503.5,2.25",
        "path a.tiles --from 501.5,1 --to 508,8",
    ] {
        let answer: Value = serde_json::from_str(&run(folder, &format!("query {query} --geojson"))).unwrap();
        assert_eq!(answer["crs"]["properties"]["name"], UTM, "{query}");
    }
    // GeoJSON that names no system has longitudes and latitudes, if its coordinates can be such.
    write(folder, "plain.geojson", None, &points(0.0));
    run(folder, "build plain.geojson -o plain.tiles");
    assert_eq!(report(folder, "inspect plain.tiles --json")["crs"], "OGC:CRS84");
    let answer: Value = serde_json::from_str(&run(folder, "query locate plain.tiles --at 3.5,2.25 --geojson")).unwrap();
    assert_eq!(answer.get("crs"), None);
    write(folder, "far.geojson", None, &points(500.0));
    run(folder, "build far.geojson -o far.tiles");
    assert_eq!(report(folder, "inspect far.tiles --json")["crs"], Value::Null);
}

#[test]
fn a_profile_follows_only_lines_in_the_system_of_the_file() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let at = |i: u32| json!([f64::from(i % 10), f64::from(i / 10), f64::from(i % 10)]);
    let points = json!({"type": "MultiPoint", "coordinates": (0..100).map(at).collect::<Vec<_>>()});
    write(folder, "p.geojson", Some(UTM), &points);
    run(folder, "build p.geojson -o a.tiles");
    write(folder, "same.geojson", Some(UTM), &line(0.0));
    write(folder, "plain.geojson", None, &line(0.0));
    let expected = run(folder, "query profile a.tiles --from 1.5,1.5 --to 7.5,6 --csv");
    for name in ["same", "plain"] {
        let profile = format!("query profile a.tiles --line {name}.geojson --csv");
        assert_eq!(run(folder, &profile), expected, "{name}");
    }
    write(folder, "other.geojson", Some("urn:ogc:def:crs:EPSG::26917"), &line(0.0));
    // The member is behind two lines.
    let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::26917"}});
    let feature = json!({"type": "Feature", "properties": {}, "geometry": line(0.0)});
    let late = format!(r#"{{"type": "FeatureCollection", "features": [{feature}, {feature}], "crs": {crs}}}"#);
    fs::write(folder.join("late.geojson"), late).unwrap();
    for name in ["other", "late"] {
        let profile = format!("query profile a.tiles --line {name}.geojson --csv");
        let error = fails(folder, 1, &profile);
        for part in ["a.tiles", name, "EPSG:25832", "EPSG:26917", "--crs"] {
            assert!(error.contains(part), "{part}: {error}");
        }
        assert_eq!(run(folder, &format!("{profile} --crs EPSG:25832")), expected, "{name}");
    }
}

#[test]
fn lines_that_lie_elsewhere_get_a_note() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    write(folder, "p.geojson", None, &points(500.0));
    write(folder, "near.geojson", None, &line(500.0));
    write(folder, "far.geojson", None, &line(9000.0));
    let build = "build p.geojson --segments near.geojson --segments far.geojson -o a.tiles --json";
    let notes = report(folder, build)["notes"].to_string();
    assert!(notes.contains("far.geojson lies elsewhere than the points"), "{notes}");
    assert!(!notes.contains("near.geojson lies"), "{notes}");
}

#[test]
fn points_are_selected_by_place_and_number() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    write(folder, "p.geojson", None, &points(0.0));
    for (options, points) in [
        ("--every 1", 100),
        ("--bounds 2,3,5,4", 8),
        ("--every 7", 15),
        ("--every 2 --bounds 2,3,5,4", 4),
    ] {
        let built = report(folder, &format!("build p.geojson -o a.tiles --force --json {options}"));
        assert_eq!(
            (&built["points"], &built["filtered"]),
            (&json!(points), &json!(100 - points)),
            "{options}"
        );
    }
    assert!(fails(folder, 2, "build p.geojson -o b.tiles --bounds 5,3,2,4").contains("XMIN,YMIN,XMAX,YMAX"));
}

#[test]
fn polygons_to_clip_by_must_have_the_system_of_the_tiles() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    write(folder, "p.geojson", Some(UTM), &points(500.0));
    run(folder, "build p.geojson -o a.tiles");
    let square = |urn: Option<&str>, name: &str| {
        let ring = json!([[500.5, 0.5], [502.5, 0.5], [502.5, 2.5], [500.5, 2.5], [500.5, 0.5]]);
        write(folder, name, urn, &json!({"type": "Polygon", "coordinates": [ring]}));
    };
    square(Some("urn:ogc:def:crs:EPSG::26917"), "other.geojson");
    square(Some(UTM), "same.geojson");
    square(None, "unknown.geojson");
    let export = |rest: &str| format!("export a.tiles --what vertices -o v.geojson --json --clip {rest}");
    let error = fails(folder, 1, &export("other.geojson"));
    for part in ["other.geojson", "a.tiles", "EPSG:25832", "EPSG:26917", "--crs"] {
        assert!(error.contains(part), "{part}: {error}");
    }
    assert!(!folder.join("v.geojson").exists());
    for sound in ["same.geojson", "unknown.geojson", "other.geojson --crs EPSG:25832"] {
        assert_eq!(report(folder, &export(sound))["vertices"], 4, "{sound}");
    }
    // A ring without area selects nothing.
    let flat = json!([[500.5, 0.5], [502.5, 2.5], [501.5, 1.5], [500.5, 0.5]]);
    write(
        folder,
        "flat.geojson",
        Some(UTM),
        &json!({"type": "Polygon", "coordinates": [flat]}),
    );
    let all = "export a.tiles -o t.geojson --json --clip";
    assert_eq!(report(folder, &format!("{all} flat.geojson"))["triangles"], 0);
    assert!(
        report(folder, &format!("{all} same.geojson"))["triangles"]
            .as_u64()
            .unwrap()
            > 4
    );
}

#[test]
fn polygons_to_clip_by_keep_to_the_memory() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    write(folder, "p.geojson", None, &points(0.0));
    run(folder, "build p.geojson -o a.tiles");
    // A circle whose edges take more than half of 32 MiB.
    let corner = |i: u32| {
        let angle = std::f64::consts::TAU * f64::from(i % 120_000) / 120_000.0;
        json!([5.0 + angle.cos(), 5.0 + angle.sin()])
    };
    let ring: Vec<Value> = (0..=120_000).map(corner).collect();
    write(
        folder,
        "c.geojson",
        None,
        &json!({"type": "Polygon", "coordinates": [ring]}),
    );
    let export = "export a.tiles -o t.geojson --json --clip c.geojson";
    let error = fails(folder, 1, &format!("{export} --memory 32MiB"));
    assert!(error.contains("c.geojson") && error.contains("--memory"), "{error}");
    let exported = report(folder, &format!("{export} --memory 128MiB"));
    assert!(exported["triangles"].as_u64().unwrap() > 0);
}
