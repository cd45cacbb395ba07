//! `tiletool build --sites`: how many sites no path can reach.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use crate::support::{json, run, tiletool};
use serde_json::Value;

/// A house with a court, and a second house that shares a part of a wall with it.
const HOUSES: &str = r#"{"type":"FeatureCollection","features":[
    {"type":"Feature","geometry":{"type":"Polygon","coordinates":[
        [[1,1],[9,1],[9,9],[1,9],[1,1]],[[4,4],[4,6],[6,6],[6,4],[4,4]]]}},
    {"type":"Feature","geometry":{"type":"Polygon","coordinates":[[[9,3],[12,3],[12,7],[9,7],[9,3]]]}}]}"#;

/// Sites, and whether they are in a house. Two are at the same position.
const SITES: [(f64, f64, bool); 12] = [
    (2.5, 2.5, true),
    (2.5, 2.5, true),
    (8.25, 3.0, true),
    (10.0, 5.0, true),
    // On the shared wall.
    (9.0, 5.0, true),
    // At the end of the shared wall, beside the free space.
    (9.0, 3.0, false),
    // On rings, and at their corners.
    (1.0, 4.5, false),
    (4.0, 5.0, false),
    (12.0, 3.0, false),
    // In the court, and outside.
    (5.0, 5.0, false),
    (0.5, 0.5, false),
    (14.0, 5.0, false),
];

fn prepare(folder: &Path) {
    fs::write(folder.join("houses.geojson"), HOUSES).unwrap();
    let mut sites = String::new();
    for (x, y, _) in SITES {
        writeln!(sites, "{x},{y}").unwrap();
    }
    fs::write(folder.join("sites.csv"), sites).unwrap();
    let points = (0..900).map(|i| format!("{},{}\n", i % 30, f64::from(i / 30) + f64::from(i % 7) / 16.0));
    fs::write(folder.join("points.csv"), points.collect::<String>()).unwrap();
}

#[test]
fn a_build_counts_the_sites_in_holes_whatever_its_tiles() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    prepare(folder);
    let expected = SITES.iter().filter(|site| site.2).count() as u64;
    for options in [
        "",
        "--tile-vertices 4",
        "--tile-vertices 9 --threads 1",
        "--tile-vertices 50 --threads 4 --engine spade",
        "--tile-vertices 30 --memory 1MiB",
    ] {
        for points in ["", "points.csv "] {
            let build =
                format!("build {points}--obstacles houses.geojson --sites sites.csv -o t.tiles --force {options}");
            let built = json(folder, &format!("{} --json", build.trim()));
            assert_eq!(built["sites_in_holes"], expected, "{build}");
            let note = format!("{expected} sites are inside obstacles or other holes, where no path leads");
            let notes = built["notes"].as_array().unwrap();
            assert!(notes.contains(&note.into()), "{notes:?}");
        }
    }
    // The queries agree.
    for (x, y, is_inside) in SITES {
        let answer = json(folder, &format!("query knn t.tiles --at {x},{y} --json"));
        assert_eq!(answer["status"] == "inside_obstacle", is_inside, "({x}, {y}): {answer}");
    }
    let output = tiletool(folder, "build --sites sites.csv -o t.tiles --force")
        .output()
        .unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "no holes, no note");
}

#[test]
fn the_outside_is_a_hole_only_if_that_is_asked_for() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    prepare(folder);
    fs::write(folder.join("square.csv"), "4,4,16,4\n16,4,16,8\n16,8,4,8\n4,8,4,4\n").unwrap();
    // All sites but four in the square and one on its wall.
    for (exterior, expected) in [("keep", 0), ("hole", 7)] {
        let build =
            format!("build --walls square.csv --sites sites.csv --exterior {exterior} -o t.tiles --force --json");
        let built = json(folder, &build);
        assert_eq!(built["sites_in_holes"], expected, "{built}");
    }
}

/// Deferred lines are inserted into the finished file, and only then are its regions known.
#[test]
fn deferred_lines_do_not_change_the_number_of_sites_in_holes() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    run(folder, "generate uniform -n 4000 --long-segments 60 --seed 3 -o p.f64");
    // Houses beside the unit square, which the lines do not meet.
    let house = |x: f64| {
        let (from, to) = (x + 0.25, x + 0.75);
        format!(
            r#"{{"type":"Feature","geometry":{{"type":"Polygon","coordinates":[[[{from},3],[{to},3],[{to},4],[{from},4],[{from},3]]]}}}}"#
        )
    };
    let houses: Vec<String> = (0..20).map(|i| house(f64::from(i))).collect();
    let houses = format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, houses.join(","));
    fs::write(folder.join("houses.geojson"), houses).unwrap();
    let sites = (0..60).map(|i| format!("{},3.5\n", f64::from(i) / 3.0));
    fs::write(folder.join("sites.csv"), sites.collect::<String>()).unwrap();
    let build = |memory: &str| -> Value {
        let lines = "--walls p.u32 --obstacles houses.geojson --sites sites.csv";
        json(
            folder,
            &format!("build p.f64 {lines} -o t.tiles --force --json --tile-vertices 100 --memory {memory}"),
        )
    };
    let [much, little] = [build("64MiB"), build("1MiB")];
    assert_eq!(much["deferred_segments"], 0, "{much}");
    assert!(little["deferred_segments"].as_u64() > Some(0), "{little}");
    assert_eq!(much["sites_in_holes"], 40);
    assert_eq!(little["sites_in_holes"], 40);
    run(folder, "verify --deep t.tiles");
}
