//! `tiletool digest`: the digest that the file stores, and the one that is computed from its tiles.

use std::fs;
use std::path::Path;

use crate::support::{errors, fails, json, run, tiletool};
use serde_json::Value;

/// The names of the sums in JSON, in the order of the lines.
const SUMS: [&str; 7] = [
    "triangles",
    "vertices",
    "constraint_edges",
    "hole_triangles",
    "vertices_with_z",
    "edge_sources",
    "sites",
];

/// Points with z, two houses that share a wall, a wall, and a site.
fn prepare(folder: &Path) {
    let houses = r#"{"type":"FeatureCollection","features":[
        {"type":"Feature","geometry":{"type":"Polygon","coordinates":[[[1,1],[9,1],[9,9],[1,9],[1,1]]]}},
        {"type":"Feature","geometry":{"type":"Polygon","coordinates":[[[9,1],[12,1],[12,9],[9,9],[9,1]]]}}]}"#;
    fs::write(folder.join("houses.geojson"), houses).unwrap();
    fs::write(folder.join("walls.csv"), "13.5,2.5,17.5,6.5\n").unwrap();
    fs::write(folder.join("later.csv"), "15.5,1.5,18.5,4.5\n3,3,5,3\n").unwrap();
    fs::write(folder.join("sites.csv"), "0.5,0.5\n").unwrap();
    let points = (0..400).map(|i| format!("{},{},{}\n", i % 20, f64::from(i / 20) + f64::from(i % 7) / 16.0, i % 9));
    fs::write(folder.join("points.csv"), points.collect::<String>()).unwrap();
}

/// Returns the counts of the lines.
fn counts(digest: &str) -> Vec<u64> {
    let count = |line: &str| line.split_whitespace().nth(1).unwrap().parse().unwrap();
    digest.lines().map(count).collect()
}

#[test]
fn the_stored_digest_is_that_of_the_tiles_after_builds_edits_and_compaction() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    prepare(folder);
    let lines = "--obstacles houses.geojson --walls walls.csv --sites sites.csv --missing-z zero";
    run(
        folder,
        &format!("build points.csv {lines} -o t.tiles --tile-vertices 30 --quiet"),
    );
    let check = || {
        let output = tiletool(folder, "digest t.tiles").output().unwrap();
        let note = errors(&output);
        assert!(output.status.success() && note.starts_with("note: "), "{note}");
        assert!(note.contains("--recompute") && note.lines().count() == 1, "{note}");
        let stored = String::from_utf8(output.stdout).unwrap();
        let output = tiletool(folder, "digest --recompute t.tiles").output().unwrap();
        assert_eq!(errors(&output), "");
        assert_eq!(String::from_utf8(output.stdout).unwrap(), stored);
        let values = [
            json(folder, "digest t.tiles --json"),
            json(folder, "digest t.tiles --json --recompute"),
        ];
        assert_eq!(
            values.each_ref().map(|value| value["recomputed"].as_bool()),
            [Some(false), Some(true)]
        );
        for (name, line) in SUMS.iter().zip(stored.lines()) {
            let words: Vec<&str> = line.split_whitespace().collect();
            for value in &values {
                assert_eq!(value[name], words[1].parse::<u64>().unwrap());
                assert_eq!(value[format!("{name}_digest")], Value::from(words[2]));
            }
        }
        run(folder, "verify --deep t.tiles");
        stored
    };
    let built = check();
    let of_build = counts(&built);
    assert!(of_build.iter().all(|&count| count > 0), "{built}");
    // The shared wall has two sources, one for each house. Eight points cut it into nine edges.
    assert_eq!(of_build[5] - of_build[2], 9, "{built}");
    run(folder, "constrain t.tiles --walls later.csv --missing-z zero");
    let edited = check();
    assert!(
        counts(&edited).iter().zip(&of_build).all(|(now, before)| now >= before),
        "{edited}"
    );
    assert!(
        edited
            .lines()
            .zip(built.lines())
            .take(6)
            .all(|(now, before)| now != before),
        "{edited}"
    );
    run(folder, "compact t.tiles");
    assert_eq!(check(), edited);
    // The same lines at once make the same triangulation.
    fs::write(
        folder.join("walls.csv"),
        "13.5,2.5,17.5,6.5\n15.5,1.5,18.5,4.5\n3,3,5,3\n",
    )
    .unwrap();
    run(
        folder,
        &format!("build points.csv {lines} -o t.tiles --tile-vertices 50 --quiet --force"),
    );
    assert_eq!(check(), edited);
}

#[test]
fn only_recomputing_reads_the_tiles() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    prepare(folder);
    run(folder, "build points.csv -o t.tiles --tile-vertices 100 --quiet");
    let digest = run(folder, "digest t.tiles");
    let path = folder.join("t.tiles");
    let mut bytes = fs::read(&path).unwrap();
    // The first core.
    bytes[12_288 + 100] ^= 1;
    fs::write(&path, bytes).unwrap();
    assert_eq!(run(folder, "digest t.tiles"), digest);
    let error = fails(folder, 1, "digest --recompute t.tiles");
    assert!(error.contains("checksum"), "{error}");
}
