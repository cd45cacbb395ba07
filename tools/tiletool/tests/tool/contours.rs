//! `tiletool export --contours` from the command line.

use std::fs;
use std::process::Command;

use crate::support::{fails, json, names, run};
use serde_json::Value;
use tempfile::TempDir;

/// Returns a folder with `a.tiles`: a pyramid of height 4 on a square of 4.
fn scratch() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.xyz"), "0 0 0\n4 0 0\n0 4 0\n4 4 0\n2 2 4\n").unwrap();
    run(folder.path(), "build a.xyz -o a.tiles --tile-vertices 4 --quiet");
    folder
}

#[test]
fn contours_are_lines_with_their_height() {
    let folder = scratch();
    let folder = folder.path();
    let printed = run(folder, "export a.tiles -o c.geojson --contours 2 --base -1");
    assert!(printed.starts_with("c.geojson: 2 contours, 10 points; "), "{printed}");
    let text = fs::read_to_string(folder.join("c.geojson")).unwrap();
    let collection: Value = serde_json::from_str(&text).unwrap();
    let mut rings: Vec<_> = collection["features"]
        .as_array()
        .unwrap()
        .iter()
        .map(|feature| {
            assert_eq!(feature["properties"]["closed"], true);
            let z = feature["properties"]["z"].as_f64().unwrap();
            (z, feature["geometry"]["coordinates"].to_string())
        })
        .collect();
    rings.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Counter-clockwise, from the smallest point.
    let ring = |low: f64, z: f64| {
        let high = 4.0 - low;
        format!(
            "[[{low:?},{low:?},{z:?}],[{high:?},{low:?},{z:?}],[{high:?},{high:?},{z:?}],[{low:?},{high:?},{z:?}],[{low:?},{low:?},{z:?}]]"
        )
    };
    assert_eq!(rings, [(1.0, ring(0.5, 1.0)), (3.0, ring(1.5, 3.0))]);
    assert_eq!(names(folder), ["a.tiles", "a.xyz", "c.geojson"]);

    let summary = json(folder, "export a.tiles -o c.fgb --contours 0.5 --json");
    // The level of the top is a point, and that of the square has nothing below it.
    assert_eq!((&summary["contours"], &summary["points"]), (&7.into(), &35.into()));
    assert_eq!((&summary["step"], &summary["base"]), (&0.5.into(), &0.0.into()));
    let bytes = fs::metadata(folder.join("c.fgb")).unwrap().len();
    assert_eq!(summary["bytes"], bytes);
}

#[test]
fn contours_are_cut_at_polygons() {
    let folder = scratch();
    let folder = folder.path();
    // A hole of 2 by 2 in a square that is larger than the pyramid, but for its south.
    let outer = "[[-9,1.5],[9,1.5],[9,9],[-9,9],[-9,1.5]]";
    let hole = "[[1,1.75],[3,1.75],[3,3.25],[1,3.25],[1,1.75]]";
    fs::write(
        folder.join("p.geojson"),
        format!(r#"{{"type": "Polygon", "coordinates": [{outer}, {hole}]}}"#),
    )
    .unwrap();
    let printed = run(
        folder,
        "export a.tiles -o c.geojson --contours 1 --base 1 --clip p.geojson",
    );
    let text = fs::read_to_string(folder.join("c.geojson")).unwrap();
    let collection: Value = serde_json::from_str(&text).unwrap();
    let mut lines: Vec<_> = collection["features"]
        .as_array()
        .unwrap()
        .iter()
        .map(|feature| {
            assert_eq!(feature["properties"]["closed"], false);
            feature["geometry"]["coordinates"].to_string()
        })
        .collect();
    lines.sort();
    // What runs along a side of the hole or along the border in the south is inside.
    let expected = [
        "[[1.0,3.0,2.0],[1.0,1.5,2.0]]",
        "[[1.5,1.75,3.0],[1.5,1.5,3.0],[2.5,1.5,3.0],[2.5,1.75,3.0]]",
        "[[3.0,1.5,2.0],[3.0,3.0,2.0]]",
        "[[3.5,1.5,1.0],[3.5,3.5,1.0],[0.5,3.5,1.0],[0.5,1.5,1.0]]",
    ];
    assert_eq!(lines, expected, "{printed}");
}

/// An independent reader, if there is one.
#[test]
fn gdal_reads_contours() {
    let folder = scratch();
    let folder = folder.path();
    for name in ["c.geojson", "c.fgb"] {
        run(folder, &format!("export a.tiles -o {name} --contours 1 --base 0.5"));
        let command = Command::new("ogrinfo")
            .args(["-al", "-so"])
            .arg(folder.join(name))
            .output();
        let Ok(output) = command else {
            eprintln!("ogrinfo is not installed");
            return;
        };
        let text = String::from_utf8_lossy(&output.stdout);
        for expected in [
            "Feature Count: 4",
            "3D Line String",
            "z: Real",
            "closed: Integer(Boolean)",
        ] {
            assert!(text.contains(expected), "{name}: {expected}: {text}");
        }
        assert!(
            text.contains("Extent: (0.250000, 0.250000) - (3.750000, 3.750000)"),
            "{text}"
        );
    }
}

#[test]
fn options_without_an_effect_on_contours_are_refused() {
    let folder = scratch();
    let folder = folder.path();
    for (args, code, expected) in [
        (
            "-o c.ply --contours 1",
            2,
            "--contours is for geojson and fgb, and not for ply",
        ),
        (
            "-o c.tif --contours 1",
            2,
            "--contours is for geojson and fgb, and not for tif",
        ),
        ("-o c.geojson --contours 0", 2, "a length is a number above 0"),
        ("-o c.geojson --base 1", 2, "--contours"),
        ("-o c.geojson --contours 1 --what edges", 2, "exclude each other"),
        ("-o c.geojson --contours 1 --clip b.geojson", 1, "b.geojson"),
        (
            "-o c.geojson --contours 1 --resolution 1",
            2,
            "--resolution is for rasters",
        ),
        ("-o c.geojson --contours 1e-9", 1, "choose a larger step"),
    ] {
        let error = fails(folder, code, &format!("export a.tiles {args}"));
        assert!(error.contains(expected), "{args}: {error}");
    }
    assert_eq!(names(folder), ["a.tiles", "a.xyz"]);
}
