//! `tiletool info`: what input files of every format hold. The expected numbers come from laspy and
//! GDAL, and from the scripts that made the files.

use std::fs;
use std::io::Write;
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::{Value, json};

use crate::support::{command, complaint, data, fails, json as report, run};

/// Describes a file of the test data.
fn info(name: &str) -> Value {
    report(Path::new("."), &format!("info --json {}", data(name)))
}

/// Checks keys of the contents of a file or layer. All other counts must be 0.
#[track_caller]
fn check(contents: &Value, expected: &Value) {
    const COUNTS: [&str; 17] = [
        "features",
        "without_geometry",
        "points",
        "multi_points",
        "line_strings",
        "multi_line_strings",
        "polygons",
        "multi_polygons",
        "positions",
        "positions_with_z",
        "sites",
        "faces",
        "edges",
        "segments",
        "holes",
        "withheld",
        "invalid",
    ];
    for key in COUNTS {
        let count = expected.get(key).cloned().unwrap_or(json!(0));
        assert_eq!(contents[key], count, "{key}: {contents:#}");
    }
    for (key, value) in expected.as_object().unwrap() {
        assert_eq!(contents[key], *value, "{key}: {contents:#}");
    }
}

/// Counts geometries of one kind as those of another.
fn unite(contents: &mut Value, kind: &str, multi: &str) {
    let number = |key: &str| contents[key].as_u64().unwrap_or_default();
    let all = number(kind) + number(multi);
    contents[kind] = json!(0);
    contents[multi] = json!(all);
}

#[test]
fn the_same_features_are_found_in_every_format() {
    let lines = json!({
        "features": 30, "without_geometry": 1, "line_strings": 24, "multi_line_strings": 5, "positions": 201,
        "positions_with_z": 201, "min_z": 20.390625, "max_z": 89.875, "epsg": 25833,
        "bounds": {"min_x": 400001.0, "min_y": 5800001.203125, "max_x": 400335.359375, "max_y": 5800283.03125},
    });
    let polygons = json!({
        "features": 24, "polygons": 18, "multi_polygons": 6, "positions": 540, "epsg": 25833, "min_z": null,
        "bounds": {"min_x": 400008.0, "min_y": 5800008.0, "max_x": 400382.0, "max_y": 5800254.0},
    });
    let sites = json!({"features": 20, "points": 20, "positions": 20, "sites": 20, "epsg": 25833});
    let clusters = json!({"features": 5, "multi_points": 5, "positions": 20, "sites": 20, "epsg": 25833});
    for (name, expected) in [
        ("lines", &lines),
        ("polygons", &polygons),
        ("sites", &sites),
        ("clusters", &clusters),
    ] {
        for suffix in ["geojson", "fgb"] {
            let mut found = info(&format!("formats/{name}.{suffix}"));
            let mut expected = expected.clone();
            if suffix == "fgb" {
                // GDAL wrote multi-geometries alone.
                for contents in [&mut found["contents"][0], &mut expected] {
                    unite(contents, "line_strings", "multi_line_strings");
                    unite(contents, "polygons", "multi_polygons");
                }
            }
            check(&found["contents"][0], &expected);
            let fields: Vec<_> = found["contents"][0]["fields"].as_array().unwrap().iter().collect();
            let names: Vec<_> = fields.iter().map(|field| field["name"].clone()).collect();
            assert_eq!(names, ["number", "name"], "{found:#}");
        }
    }
    let found = info("formats/all.gpkg");
    let layers = found["contents"].as_array().unwrap();
    let names: Vec<_> = layers.iter().map(|layer| layer["layer"].clone()).collect();
    assert_eq!(names, ["lines", "polygons", "sites", "clusters"]);
    for (layer, expected) in layers.iter().zip([&lines, &polygons, &sites, &clusters]) {
        check(layer, expected);
        assert!(
            layer["fields"].to_string().contains(r#"{"name":"number","type":""#),
            "{layer:#}"
        );
    }
    let found = info("formats/all.gpkg:sites");
    assert_eq!(found["contents"].as_array().unwrap().len(), 1);
    check(&found["contents"][0], &sites);
    check(
        &info("formats/mixed.fgb")["contents"][0],
        &json!({
            "features": 78, "points": 20, "multi_points": 5, "line_strings": 24, "multi_line_strings": 5, "polygons": 18,
            "multi_polygons": 6, "positions": 781, "sites": 40
        }),
    );
}

#[test]
fn shapefiles_have_the_fields_and_the_system_of_the_files_beside_them() {
    let found = info("formats/sites.shp");
    assert_eq!(found["format"], "shapefile");
    let contents = &found["contents"][0];
    assert_eq!((&contents["points"], &contents["unit"]), (&json!(20), &json!("m")));
    let fields = contents["fields"].as_array().unwrap();
    assert!(fields.iter().any(|field| field["name"] == "number"), "{fields:?}");
    // A shapefile has no type for single lines.
    let contents = &info("formats/lines.shp")["contents"][0];
    assert_eq!(
        (&contents["features"], &contents["positions"]),
        (&json!(30), &json!(201))
    );
    assert_eq!(
        (&contents["min_z"], &contents["max_z"]),
        (&json!(20.390625), &json!(89.875))
    );
}

#[test]
fn las_has_its_header_classes_and_returns() {
    let counts = |list: &Value, key: &str| -> Vec<(u64, u64)> {
        let number = |row: &Value, key: &str| row[key].as_u64().unwrap();
        let rows = list.as_array().unwrap().iter();
        rows.map(|row| (number(row, key), number(row, "points"))).collect()
    };
    for (name, variety, points, format, classes, returns) in [
        (
            "autzen.las",
            "LAS",
            106,
            1,
            &[(1, 82), (2, 24)][..],
            &[(1, 90), (2, 12), (3, 2), (4, 2)][..],
        ),
        (
            "autzen.laz",
            "LAZ",
            106,
            3,
            &[(1, 82), (2, 24)],
            &[(1, 90), (2, 12), (3, 2), (4, 2)],
        ),
        (
            "autzen.copc.laz",
            "COPC",
            107,
            7,
            &[(0, 5), (2, 73), (5, 23), (6, 2), (9, 4)],
            &[(1, 93), (2, 11), (3, 3)],
        ),
        (
            "extrabytes.laz",
            "LAZ",
            1065,
            3,
            &[(1, 789), (2, 276)],
            &[(1, 925), (2, 114), (3, 21), (4, 5)],
        ),
        (
            "32-1-472-150-76.laz",
            "LAZ",
            5658,
            1,
            &[(1, 3648), (2, 1461), (7, 30), (9, 519)],
            &[(1, 3519), (2, 1682), (3, 410), (4, 47)],
        ),
    ] {
        let found = info(&format!("las/{name}"));
        let las = &found["las"];
        assert_eq!(
            (&found["variety"], &las["point_format"]),
            (&json!(variety), &json!(format)),
            "{name}"
        );
        assert_eq!(counts(&las["classes"], "class"), classes, "{name}");
        assert_eq!(counts(&las["returns"], "return"), returns, "{name}");
        assert_eq!(las["scale"], json!([0.01, 0.01, 0.01]), "{name}");
        check(
            &found["contents"][0],
            &json!({"points": points, "positions": points, "positions_with_z": points}),
        );
    }
    let copc = info("las/autzen.copc.laz");
    let las = &copc["las"];
    assert_eq!((&las["version"], &las["copc_levels"]), (&json!("1.4"), &json!(1)));
    assert!((las["copc_spacing"].as_f64().unwrap() - 30.67129251700636).abs() < 1e-9);
    assert_eq!((&las["created_year"], &las["created_day"]), (&json!(2024), &json!(114)));
    let old = info("las/autzen.las");
    assert_eq!(old["las"]["software"], "TerraScan");
    assert_eq!(
        (&old["contents"][0]["epsg"], &old["contents"][0]["unit"]),
        (&json!(2994), &json!("ft"))
    );
    let extra = info("las/extrabytes.laz");
    let fields = extra["contents"][0]["fields"].as_array().unwrap();
    let last: Vec<_> = fields.iter().rev().take(5).rev().map(|field| &field["name"]).collect();
    assert_eq!(last, ["Colors", "Reserved", "Flags", "Intensity", "Time"]);
    // Withheld points are in the counts of classes, and not among the points.
    let mut bytes = fs::read(data("las/autzen.las")).unwrap();
    let start = bytes[96..]
        .first_chunk::<4>()
        .map(|start| u32::from_le_bytes(*start))
        .unwrap() as usize;
    for point in [0, 7] {
        bytes[start + 28 * point + 15] |= 0x80;
    }
    let scratch = tempfile::tempdir().unwrap();
    fs::write(scratch.path().join("a.las"), bytes).unwrap();
    let found = report(scratch.path(), "info a.las --json");
    let expected = json!({"points": 104, "positions": 104, "positions_with_z": 104, "withheld": 2});
    check(&found["contents"][0], &expected);
    assert_eq!(counts(&found["las"]["classes"], "class"), [(1, 82), (2, 24)]);
    // For people.
    let text = run(Path::new("."), &format!("info {}", data("las/autzen.copc.laz")));
    for part in [
        "COPC",
        "1 level",
        "ground",
        "107, with z",
        "gps_time",
        "408.14 to    505.74",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn files_of_points_have_the_same_points_in_every_format() {
    let bounds = info("formats/points.csv")["contents"][0]["bounds"].clone();
    for (name, format, variety, fields) in [
        ("points.csv", "text", Value::Null, json!(["x", "y", "z"])),
        ("columns.parquet", "parquet", Value::Null, json!(["id", "x", "y", "z"])),
        (
            "columns_decimal.parquet",
            "parquet",
            Value::Null,
            json!(["Easting", "Northing", "Height"]),
        ),
        (
            "geo_multipoint.parquet",
            "parquet",
            json!("GeoParquet"),
            json!(["geometry"]),
        ),
    ] {
        let found = info(&format!("formats/{name}"));
        assert_eq!(
            (&found["format"], &found["variety"]),
            (&json!(format), &variety),
            "{name}"
        );
        let contents = &found["contents"][0];
        let expected = json!({"points": 200, "positions": 200, "positions_with_z": 200, "bounds": bounds});
        check(contents, &expected);
        let names: Vec<_> = contents["fields"].as_array().unwrap().iter().collect();
        let names: Vec<_> = names.iter().map(|field| field["name"].clone()).collect();
        assert_eq!(json!(names), fields, "{name}");
    }
}

#[test]
fn meshes_have_faces_and_edges() {
    for (name, variety) in [
        ("tin.ply", json!("binary, little-endian")),
        ("tin_ascii.ply", json!("ascii")),
        ("tin.obj", Value::Null),
    ] {
        let found = info(&format!("formats/{name}"));
        assert_eq!(found["variety"], variety, "{name}");
        let contents = &found["contents"][0];
        let number = |key: &str| contents[key].as_u64().unwrap();
        // Euler's formula for a triangulated disc.
        assert!(number("faces") > 0);
        assert_eq!(
            number("points") + number("faces") + 1,
            number("edges") + 2,
            "{contents:#}"
        );
    }
    let poly = &info("arena/arena.poly")["contents"][0];
    assert_eq!((&poly["segments"], &poly["holes"]), (&json!(112), &json!(5)));
    let scratch = tempfile::tempdir().unwrap();
    fs::write(
        scratch.path().join("a.u32"),
        [0u32, 7, 7, 3].map(u32::to_le_bytes).concat(),
    )
    .unwrap();
    let pairs = report(scratch.path(), "info a.u32 --json");
    assert_eq!(
        (&pairs["format"], &pairs["contents"][0]["segments"]),
        (&json!("u32"), &json!(2))
    );
}

#[test]
fn invalid_records_are_counted_and_are_not_in_the_bounds() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    fs::write(folder.join("a.csv"), "lon,lat,name\n1,2,a\n3,?,b\n5,-6,c\n1e999,0,d\n").unwrap();
    let found = report(folder, "info a.csv --json");
    let contents = &found["contents"][0];
    let bounds = json!({"min_x": 1.0, "min_y": -6.0, "max_x": 5.0, "max_y": 2.0});
    check(
        contents,
        &json!({"points": 2, "positions": 2, "invalid": 2, "bounds": bounds}),
    );
    assert_eq!(contents["fields"][2], json!({"name": "name", "type": ""}));
    let features = json!([
        {"type": "Feature", "properties": {"a": 1, "b": null}, "geometry": {"type": "Point", "coordinates": [7, 8, 9]}},
        {"type": "Feature", "properties": {"b": "x", "a": "y"}, "geometry": {"type": "LineString",
            "coordinates": [[0, 0], [1], ["a", 2], [3, 4, -5]]}},
        {"type": "Feature", "properties": null, "geometry": null},
    ]);
    let document = json!({"type": "FeatureCollection", "features": features});
    fs::write(folder.join("a.geojson"), document.to_string()).unwrap();
    let found = report(folder, "info a.geojson --json");
    let expected = json!({
        "features": 3, "without_geometry": 1, "points": 1, "line_strings": 1, "positions": 3, "positions_with_z": 2,
        "sites": 1, "invalid": 2, "min_z": -5.0, "max_z": 9.0, "epsg": 4326, "is_geographic": true,
        "fields": [{"name": "a", "type": "number or string"}, {"name": "b", "type": "string or null"}],
    });
    check(&found["contents"][0], &expected);
    // The options of reading, several files, and gzip.
    let mut zipped = GzEncoder::new(Vec::new(), Compression::fast());
    zipped.write_all(b"a;b;c\n9;1;2\n9;3;4\n").unwrap();
    fs::write(folder.join("b.csv.gz"), zipped.finish().unwrap()).unwrap();
    let lines = run(folder, "info --json --columns b,c b.csv.gz b.csv.gz");
    assert_eq!(lines.lines().count(), 2);
    let found: Value = serde_json::from_str(lines.lines().next().unwrap()).unwrap();
    assert_eq!(
        (&found["is_gzip"], &found["contents"][0]["bounds"]["max_x"]),
        (&json!(true), &json!(3.0))
    );
    let text = run(folder, "info a.csv a.geojson");
    for part in [
        "a.csv",
        "a.geojson",
        "invalid            2",
        "without geometry",
        "2 of them with z",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn files_that_cannot_be_described_are_errors_that_say_what_to_do() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    fs::write(folder.join("empty.csv"), "").unwrap();
    fs::write(folder.join("unknown.dat"), "1 2\n3 4\n").unwrap();
    fs::write(folder.join("p.csv"), "0,0\n4,0\n0,4\n").unwrap();
    run(folder, "build p.csv -o p.tiles");
    fs::copy(folder.join("p.tiles"), folder.join("q.csv")).unwrap();
    fs::copy(data("las/autzen.laz"), folder.join("mislabelled.ply")).unwrap();
    for (name, parts) in [
        ("empty.csv", &["empty"][..]),
        ("unknown.dat", &["option `--format`"]),
        ("p.tiles", &["tiletool inspect p.tiles"]),
        ("q.csv", &["tiletool inspect q.csv"]),
        ("mislabelled.ply", &["this is las", "--format"]),
        ("nowhere.las", &["cannot be opened"]),
        ("-", &["standard input"]),
        ("https://localhost/a.las", &["on this machine"]),
    ] {
        let mut info = command(folder, &["info", "--json", name]);
        if name == "-" {
            info = command(folder, &["info", "--json", "--", name]);
        }
        let error = complaint(info, 1);
        assert!(error.contains(name) || name == "-", "{error}");
        assert!(parts.iter().all(|part| error.contains(part)), "{parts:?}: {error}");
    }
    let text = run(folder, "info --format text unknown.dat");
    assert!(text.contains("points             2\n"), "{text}");
    fails(folder, 2, "info");
    let layers = format!("info {}:houses", data("formats/all.gpkg"));
    assert!(fails(folder, 1, &layers).contains("clusters"));
}

/// No cut and no changed byte may make the tool panic or take long.
#[test]
fn damaged_files_are_errors_or_described() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    for name in [
        "formats/lines.fgb",
        "formats/polygons.shp",
        "formats/lines.gpkg",
        "formats/tin.ply",
        "formats/geo_wkb.parquet",
        "las/autzen.laz",
        "las/autzen.copc.laz",
        "las/extrabytes.laz",
    ] {
        let bytes = fs::read(data(name)).unwrap();
        let file = Path::new(name).file_name().unwrap().to_str().unwrap();
        for part in [1, 9, 17] {
            fs::write(folder.join(file), &bytes[..bytes.len() * part / 18]).unwrap();
            let error = fails(folder, 1, &format!("info {file}"));
            assert!(error.contains(file), "{error}");
        }
        for at in (0..24).map(|n| n * bytes.len() / 24 / 3 + n) {
            let mut changed = bytes.clone();
            changed[at] ^= 0xff;
            fs::write(folder.join(file), &changed).unwrap();
            let output = command(folder, &["info", "--json", file]).output().unwrap();
            assert!(
                matches!(output.status.code(), Some(0 | 1)),
                "{file}, byte {at}: {output:?}"
            );
        }
    }
}
