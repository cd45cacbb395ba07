//! Lines, obstacles and sites without z take it from the surface of the points.

use std::fs;

use std::path::Path;

use crate::support::{fails, json, run};

/// A slope of 21 by 21 points, z = 100 + x / 4 - y / 8, and lines without z.
fn scratch() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut ground = "x,y,z\n".to_owned();
    for (x, y) in (0..21).flat_map(|x| (0..21).map(move |y| (f64::from(x), f64::from(y)))) {
        ground += &format!("{x},{y},{}\n", 100.0 + x / 4.0 - y / 8.0);
    }
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("ground.csv", &ground);
    write("lakes.csv", "0.5,0.5,16.5,16.5\n3,9.5,9.5,3\n");
    write("apart.csv", "0.5,0.5,16.5,16.5\n3,2.5,9.5,3\n");
    write("out.csv", "18.5,10.25,24,10.25\n");
    write("shops.csv", "12,12\n3.25,7.5\n");
    folder
}

/// Returns the vertices of a file: x, y and z.
fn vertices(folder: &Path, file: &str) -> Vec<[f64; 3]> {
    run(folder, &format!("export {file} -o {file}.obj"));
    let text = fs::read_to_string(folder.join(format!("{file}.obj"))).unwrap();
    let rows = text.lines().filter_map(|line| line.strip_prefix("v "));
    rows.map(|row| {
        let values: Vec<f64> = row.split(' ').map(|value| value.parse().unwrap()).collect();
        values.try_into().unwrap()
    })
    .collect()
}

#[test]
fn a_build_lays_lines_and_sites_on_the_slope_and_notes_it() {
    let scratch = scratch();
    let folder = scratch.path();
    let lines = "--segments lakes.csv --segments out.csv --sites shops.csv --crossings split";
    let built = json(
        folder,
        &format!("build ground.csv {lines} -o a.tiles --tile-vertices 50 --json"),
    );
    let notes = built["notes"].to_string();
    assert!(
        notes.contains("8 vertices without z took it from the triangulation of the points, 1 of them outside"),
        "{notes}"
    );
    let all = vertices(folder, "a.tiles");
    assert_eq!(all.len(), 449);
    for [x, y, z] in all {
        // Outside the hull, which ends at x = 20, the nearest point of the hull counts.
        assert!((z - (100.0 + x.min(20.0) / 4.0 - y / 8.0)).abs() < 1e-12, "{x} {y} {z}");
    }
    let one = fs::read(folder.join("a.tiles")).unwrap();
    assert!(!folder.join("a.tiles.partial").exists());
    run(
        folder,
        &format!("build ground.csv {lines} -o a.tiles --tile-vertices 50 --threads 1 --force --quiet"),
    );
    assert_eq!(one.len(), fs::read(folder.join("a.tiles")).unwrap().len());
    let refused = fails(
        folder,
        1,
        "build ground.csv --segments apart.csv --missing-z error -o b.tiles",
    );
    assert!(
        refused.contains("apart.csv: row 0 (counted from 0) has no z at (0.5, 0.5)") && refused.contains("leave out"),
        "{refused}"
    );
}

#[test]
fn draped_files_pass_verification_against_their_input() {
    let scratch = scratch();
    let folder = scratch.path();
    let inputs = "--segments apart.csv --obstacles pond.geojson --sites shops.csv";
    fs::write(
        folder.join("pond.geojson"),
        r#"{"type":"Polygon","coordinates":[[[4.5,9.5],[8.5,9.5],[8.5,15.5],[4.5,9.5]]]}"#,
    )
    .unwrap();
    for way in ["--tile-vertices 5000", "--tile-vertices 20 --threads 2 --memory 30MB"] {
        run(
            folder,
            &format!("build ground.csv {inputs} -o a.tiles --quiet --force {way}"),
        );
        run(folder, &format!("verify --deep a.tiles --against ground.csv {inputs}"));
    }
    run(folder, "build ground.csv -o b.tiles --quiet");
    run(folder, "constrain b.tiles --segments apart.csv");
    run(
        folder,
        "verify --deep b.tiles --against ground.csv --segments apart.csv",
    );
    let on_slope = |&[x, y, z]: &[f64; 3]| (z - (100.0 + x / 4.0 - y / 8.0)).abs() < 1e-12;
    assert!(vertices(folder, "b.tiles").iter().all(on_slope));
}

#[test]
fn ponds_are_flat_and_pass_verification() {
    let scratch = scratch();
    let folder = scratch.path();
    fs::write(
        folder.join("ponds.geojson"),
        r#"{"type":"MultiPolygon","coordinates":[
            [[[4.5,9.5],[8.5,9.5],[8.5,15.5],[4.5,9.5]]], [[[12,2],[15,2],[15,6],[12,6],[12,2]]]]}"#,
    )
    .unwrap();
    let inputs = "--flatten ponds.geojson --segments lakes.csv --sites shops.csv";
    let built = json(
        folder,
        &format!("build ground.csv {inputs} --crossings split -o a.tiles --tile-vertices 50 --json"),
    );
    // A triangle with 4 columns of points, and a square of 4 by 5.
    assert_eq!(
        (built["ponds"].as_u64(), built["flattened"].as_u64()),
        (Some(2), Some(32))
    );
    assert_eq!(
        run(folder, "query z a.tiles --at 8,11"),
        format!("{}\n", 100.0 + 4.5 / 4.0 - 9.5 / 8.0)
    );
    assert_eq!(
        run(folder, "query z a.tiles --at 14,3.3"),
        format!("{}\n", 100.0 + 12.0 / 4.0 - 6.0 / 8.0)
    );
    run(folder, &format!("verify --deep a.tiles --against ground.csv {inputs}"));
    // The same lines, but no ponds.
    run(
        folder,
        "build ground.csv --segments ponds.geojson -o steep.tiles --quiet",
    );
    let steep = fails(
        folder,
        1,
        "verify steep.tiles --against ground.csv --flatten ponds.geojson",
    );
    assert!(steep.contains("another z"), "{steep}");
    let refused = fails(folder, 1, "build shops.csv --flatten ponds.geojson -o b.tiles");
    assert!(
        refused.contains("no z") && !folder.join("b.tiles").exists(),
        "{refused}"
    );
}
