//! Obstacles that are inside out, from the command line: they are reported or covered, and never
//! make other covered areas free.

use std::fs;
use std::path::Path;

use crate::support::{data, fails, json, names, run};

fn obstacles(folder: &Path, name: &str) {
    fs::copy(data(&format!("obstacles/{name}")), folder.join(name)).unwrap();
}

/// Returns the status of a path within a lobe that has the wrong direction, under another polygon.
fn status_in_lobe(folder: &Path, file: &str) -> String {
    let path = json(folder, &format!("query path {file} --from 4.5,2.5 --to 4.5,3.5 --json"));
    path["status"].as_str().unwrap().to_owned()
}

/// A lobe of one polygon once had the wrong direction under another polygon: +1 - 1 = 0, and paths
/// led through it without any message.
#[test]
fn a_polygon_that_is_inside_out_under_another_one_is_named() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let message = "feature 0 (counted from 0) is inside out at (3, 3): one of its holes is outside the polygon";
    for name in ["bow_touch.geojson", "bow_touch_alone.geojson"] {
        obstacles(folder, name);
        let error = fails(folder, 1, &format!("build --obstacles {name} -o t.tiles --quiet"));
        assert!(error.starts_with(&format!("error: {name}: {message}")), "{error}");
        assert_eq!(
            names(folder).iter().filter(|name| name.starts_with("t.tiles")).count(),
            0
        );
    }
    // Rings that cross are reported as crossings.
    obstacles(folder, "bow.geojson");
    let error = fails(folder, 1, "build --obstacles bow.geojson -o t.tiles --quiet");
    assert!(
        error.contains("bow.geojson: feature 0 (counted from 0) crosses itself at "),
        "{error}"
    );
}

#[test]
fn with_split_lines_every_obstacle_is_covered() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    for (name, is_split) in [("bow_touch.geojson", false), ("bow.geojson", true)] {
        obstacles(folder, name);
        let built = json(
            folder,
            &format!("build --obstacles {name} --crossings split -o t.tiles --force --json"),
        );
        assert_eq!(built["inverted_parts"], 1, "{name}");
        let note = built["notes"][0].as_str().unwrap();
        assert!(
            note.starts_with("1 part of a polygon is inside out, because "),
            "{note}"
        );
        assert!(
            note.contains(&format!("the first is in {name}: feature 0 (counted from 0) at ")),
            "{note}"
        );
        if !is_split {
            assert_eq!(status_in_lobe(folder, "t.tiles"), "inside_obstacle");
        }
        run(folder, &format!("verify --deep t.tiles --obstacles {name}"));
    }
    // The polygon alone gives a different file than both polygons.
    obstacles(folder, "bow_touch_alone.geojson");
    run(
        folder,
        "build --obstacles bow_touch_alone.geojson --crossings split -o t.tiles --force --quiet",
    );
    fails(folder, 1, "verify t.tiles --obstacles bow_touch.geojson");
}

/// A ring that goes round twice, and a MultiPolygon with a part in another one and a part twice.
const OVERLAPPING: &str = r#"{"type":"FeatureCollection","features":[
{"type":"Feature","geometry":{"type":"Polygon","coordinates":[[[1,1],[4,1],[4,4],[1,4],[1,1],[4,1],[4,4],[1,4],[1,1]]]}},
{"type":"Feature","geometry":{"type":"MultiPolygon","coordinates":[[[[3,1],[8,1],[8,8],[3,8],[3,1]]],
[[[5,5],[7,5],[7,7],[5,7],[5,5]]],[[[5,5],[7,5],[7,7],[5,7],[5,5]]]]}}]}"#;

#[test]
fn obstacles_that_overlap_themselves_are_compared_as_they_are_stored() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    fs::write(folder.join("twice.geojson"), OVERLAPPING).unwrap();
    fs::write(
        folder.join("corners.csv"),
        "-1,-1\n9,-1\n9,9\n-1,9\n3,4\n4,1\n3,1\n4,4\n",
    )
    .unwrap();
    for (options, crosses) in [("", false), (" --crossings split", true)] {
        // Without its crossing, the second obstacle begins beside the first one.
        let text = if crosses {
            OVERLAPPING.to_owned()
        } else {
            OVERLAPPING.replace("[3,", "[4,")
        };
        fs::write(folder.join("twice.geojson"), text).unwrap();
        run(
            folder,
            &format!("build corners.csv --obstacles twice.geojson -o t.tiles --force --quiet{options}"),
        );
        run(
            folder,
            "verify --deep t.tiles --against corners.csv --obstacles twice.geojson",
        );
    }
    fs::write(folder.join("twice.geojson"), OVERLAPPING.replace("[3,", "[4,")).unwrap();
    run(folder, "build corners.csv -o t.tiles --force --quiet");
    run(folder, "constrain t.tiles --obstacles twice.geojson");
    run(
        folder,
        "verify --deep t.tiles --against corners.csv --obstacles twice.geojson",
    );
    assert_eq!(status_in_lobe(folder, "t.tiles"), "inside_obstacle");
}

#[test]
fn constrain_names_a_polygon_that_is_inside_out_and_changes_nothing() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    obstacles(folder, "bow_touch_alone.geojson");
    // The other polygon is in the file already.
    fs::write(
        folder.join("valid.geojson"),
        r#"{"type":"Polygon","coordinates":[[[3,3],[3,0],[6,0],[6,6],[3,6],[3,3]]]}"#,
    )
    .unwrap();
    fs::write(folder.join("corners.csv"), "-1,-1\n9,-1\n9,9\n-1,9\n").unwrap();
    run(folder, "build corners.csv --obstacles valid.geojson -o t.tiles --quiet");
    let before = fs::read(folder.join("t.tiles")).unwrap();
    let error = fails(folder, 1, "constrain t.tiles --obstacles bow_touch_alone.geojson");
    assert!(
        error.contains("bow_touch_alone.geojson: feature 0 (counted from 0): it is inside out at (3, 3)"),
        "{error}"
    );
    assert!(fs::read(folder.join("t.tiles")).unwrap() == before);
    assert_eq!(status_in_lobe(folder, "t.tiles"), "inside_obstacle");
}
