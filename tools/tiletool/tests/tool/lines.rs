//! `tiletool build` with lines, obstacles and sites from the command line: the result of each
//! option, and mistakes.

use std::fs;

use crate::support::{errors, names, tiletool};
use serde_json::Value;
use tempfile::TempDir;

/// A folder in which the tool runs.
struct Scratch(TempDir);

impl Scratch {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for (name, content) in files {
            fs::write(folder.path().join(name), content).unwrap();
        }
        Self(folder)
    }

    /// Runs a command that must succeed. Returns its standard output.
    #[track_caller]
    fn ok(&self, args: &str) -> String {
        crate::support::run(self.0.path(), args)
    }

    fn json(&self, args: &str) -> Value {
        crate::support::json(self.0.path(), args)
    }

    /// Builds and verifies `t.tiles`. Returns the summaries of the build and of the file.
    fn build(&self, args: &str) -> [Value; 2] {
        let built = self.json(&format!("build {args} -o t.tiles --force --json"));
        self.ok("verify --deep t.tiles");
        [built, self.json("inspect t.tiles --json")]
    }

    /// Runs a command that must fail with this exit code and leave no new files. Returns its
    /// standard error.
    fn fails(&self, code: i32, args: &str) -> String {
        let before = names(self.0.path());
        let output = tiletool(self.0.path(), args).output().unwrap();
        let errors = errors(&output);
        assert_eq!(output.status.code(), Some(code), "{args}: {errors}");
        assert!(output.stdout.is_empty(), "{args}");
        assert_eq!(names(self.0.path()), before, "{args}");
        errors
    }
}

/// Asserts that a summary has these values.
#[track_caller]
fn assert_has(summary: &Value, values: &[(&str, u64)]) {
    for (key, value) in values {
        assert_eq!(summary[key], *value, "{key} of {summary}");
    }
}

/// 7 × 7 points.
const GRID: &str = "x,y\n\
    0,0\n1,0\n2,0\n3,0\n4,0\n5,0\n6,0\n0,1\n1,1\n2,1\n3,1\n4,1\n5,1\n6,1\n0,2\n1,2\n2,2\n3,2\n4,2\n5,2\n6,2\n\
    0,3\n1,3\n2,3\n3,3\n4,3\n5,3\n6,3\n0,4\n1,4\n2,4\n3,4\n4,4\n5,4\n6,4\n0,5\n1,5\n2,5\n3,5\n4,5\n5,5\n6,5\n\
    0,6\n1,6\n2,6\n3,6\n4,6\n5,6\n6,6\n";

/// A house of two by two, and one of one by one.
const HOUSES: &str = r#"{"type":"FeatureCollection","features":[
    {"type":"Feature","geometry":{"type":"Polygon","coordinates":[[[1,1],[3,1],[3,3],[1,3],[1,1]]]}},
    {"type":"Feature","geometry":{"type":"Polygon","coordinates":[[[4,4],[5,4],[5,5],[4,5],[4,4]]]}}]}"#;

/// The diagonals of two squares, and a line by itself.
const CROSSES: &str = "0,0,2,2\n2,0,0,2\n0,6,6,6\n3,3,5,5\n3,5,5,3\n";

/// A valid triangle, and a polygon that crosses itself.
const BOW: &str = r#"{"type":"FeatureCollection","features":[
    {"type":"Feature","geometry":{"type":"Polygon","coordinates":[[[0,9],[1,9],[0,10],[0,9]]]}},
    {"type":"Feature","geometry":{"type":"Polygon","coordinates":[[[20,0],[28,4],[28,0],[20,12],[20,0]]]}}]}"#;

/// A valid triangle, and a square whose hole is beside it.
const BESIDE: &str = r#"{"type":"FeatureCollection","features":[
    {"type":"Feature","geometry":{"type":"Polygon","coordinates":[[[0,9],[1,9],[0,10],[0,9]]]}},
    {"type":"Feature","geometry":{"type":"Polygon","coordinates":[
        [[0,0],[4,0],[4,4],[0,4],[0,0]],[[6,1],[6,3],[8,3],[8,1],[6,1]]]}}]}"#;

/// A polygon without area: each of its two sides occurs in both directions.
const FLAT: &str = r#"{"type":"Polygon","coordinates":[[[5,1],[7,1],[5,1]]]}"#;

/// Three shops, two of them at the same position.
const SHOPS: &str = r#"{"type":"FeatureCollection","features":[
    {"type":"Feature","properties":{"name":"baker"},"geometry":{"type":"Point","coordinates":[0.5,0.25]}},
    {"type":"Feature","properties":{"name":"cobbler"},"geometry":{"type":"Point","coordinates":[4,0]}},
    {"type":"Feature","properties":{"name":"miller"},"geometry":{"type":"Point","coordinates":[4,0]}}]}"#;

/// A square with an inner square, which has a hole point.
const COURT: &str = "8 2 0 0\n1 0 0\n2 9 0\n3 9 9\n4 0 9\n5 3 3\n6 6 3\n7 6 6\n8 3 6\n\
    8 0\n1 1 2\n2 2 3\n3 3 4\n4 4 1\n5 5 6\n6 6 7\n7 7 8\n8 8 5\n1\n1 4 4\n";

fn town() -> Scratch {
    Scratch::new(&[
        ("grid.csv", GRID),
        ("houses.geojson", HOUSES),
        ("cross.csv", CROSSES),
        ("shops.geojson", SHOPS),
        ("court.poly", COURT),
        ("bow.geojson", BOW),
        ("flat.geojson", FLAT),
        ("beside.geojson", BESIDE),
        (
            "bad.poly",
            "4 2 0 0\n1 0 0\n2 6 6\n3 6 0\n4 0 6\n2 0\n1 1 2\n2 3 4\n0\n",
        ),
        ("path.csv", "0,0,6,0\n6,0,6,6\n"),
        ("fence.csv", "0,2.5,6,2.5\n"),
    ])
}

#[test]
fn break_lines_and_walls_become_constraint_edges() {
    let town = town();
    for (option, kind) in [("--segments", "break line"), ("--walls", "wall")] {
        let [built, shown] = town.build(&format!("grid.csv {option} path.csv {option} fence.csv"));
        // The path is on the hull and passes through an end of the fence, which divides the grid.
        let counts = [
            ("segments", 3),
            ("constraint_edges", 6 + 7 + 1),
            ("added_vertices", 2),
            ("vertices", 51),
            ("crossings", 0),
            ("regions", 2),
            ("hole_regions", 0),
            ("hole_triangles", 0),
            ("sites", 0),
        ];
        assert_has(&built, &counts);
        assert_has(
            &shown,
            &[("regions", 2), ("constraint_edges", 14), ("added_vertices", 2)],
        );
        let lines = shown["lines"].as_array().unwrap();
        let expected = [("path.csv", 0, 2), ("fence.csv", 2, 1)];
        assert_eq!(lines.len(), 2);
        for (line, (name, first, count)) in lines.iter().zip(expected) {
            assert_eq!((&line["name"], &line["kind"]), (&name.into(), &kind.into()));
            assert_has(line, &[("first_line", first), ("count", count)]);
        }
    }
}

#[test]
fn obstacles_are_holes() {
    let town = town();
    let [built, shown] = town.build("grid.csv --obstacles houses.geojson");
    let counts = [
        ("segments", 8),
        ("constraint_edges", 12),
        ("added_vertices", 0),
        ("regions", 3),
        ("hole_regions", 2),
        ("hole_triangles", 8 + 2),
    ];
    assert_has(&built, &counts);
    assert_has(&built, &[("input_bytes", (GRID.len() + HOUSES.len()) as u64)]);
    let counts = [
        ("regions", 3),
        ("hole_regions", 2),
        ("hole_triangles", 10),
        ("triangles", 72),
    ];
    assert_has(&shown, &counts);
    assert_eq!(shown["lines"][0]["kind"], "obstacle");
    assert_eq!(shown["exterior_is_hole"], false);
    let digest = town.ok("digest --recompute t.tiles");
    assert!(digest.contains("hole"), "{digest}");
    // Without points, and as text for people.
    let printed = town.ok("build --obstacles houses.geojson -o t.tiles --force");
    assert!(
        printed.contains("regions  3, including 2 holes with 4 triangles"),
        "{printed}"
    );
    let printed = town.ok("inspect t.tiles --regions");
    assert!(
        printed.contains("including 2 holes, area 5.00000, 4 triangles"),
        "{printed}"
    );
}

#[test]
fn the_exterior_is_kept_or_a_hole() {
    let town = town();
    // The court is a hole because of its hole point, and the ring around it is free. The whole hull
    // consists of walls.
    let [built, _] = town.build("court.poly --exterior keep");
    let counts = [("segments", 8), ("points", 8), ("regions", 2), ("hole_regions", 1)];
    assert_has(&built, &counts);
    assert_has(&built, &[("hole_triangles", 2), ("triangles", 10)]);
    let keep = town.ok("digest --recompute t.tiles");
    let [_, shown] = town.build("court.poly --exterior hole");
    assert_has(&shown, &[("hole_triangles", 2), ("hole_points", 1)]);
    assert_eq!(town.ok("digest --recompute t.tiles"), keep);
    assert_eq!(shown["lines"][0]["name"], "court.poly");
    assert_eq!(shown["lines"][0]["kind"], "wall");
    // A point outside the walls creates an exterior.
    fs::write(town.0.path().join("far.csv"), "20,20\n").unwrap();
    for (exterior, holes) in [("keep", 1), ("hole", 2)] {
        let [built, shown] = town.build(&format!("court.poly far.csv --exterior {exterior}"));
        assert_has(&built, &[("regions", 3), ("hole_regions", holes)]);
        assert_eq!(shown["exterior_is_hole"], exterior == "hole");
    }
    // Without lines, the only region reaches the hull.
    let [built, _] = town.build("grid.csv --exterior hole");
    assert_has(&built, &[("regions", 1), ("hole_regions", 1), ("hole_triangles", 72)]);
}

#[test]
fn sites_keep_their_ids() {
    let town = town();
    let [built, shown] = town.build("grid.csv --sites shops.geojson --site-id name");
    assert_has(
        &built,
        &[("sites", 3), ("added_vertices", 1), ("vertices", 50), ("segments", 0)],
    );
    assert_has(&shown, &[("sites", 3), ("regions", 0)]);
    // By default, the ids are the record numbers.
    let [built, _] = town.build("grid.csv --sites shops.geojson --obstacles houses.geojson");
    assert_has(&built, &[("sites", 3), ("hole_regions", 2)]);
    let error = town.fails(
        1,
        "build grid.csv --sites shops.geojson --site-id owner -o no.tiles --quiet",
    );
    for part in ["shops.geojson", "owner"] {
        assert!(error.contains(part), "{error}");
    }
    fs::write(
        town.0.path().join("shops.csv"),
        "x,y,name\n0.5,0.25,baker\n4,0,cobbler\n",
    )
    .unwrap();
    let [built, _] = town.build("grid.csv --sites shops.csv --site-id name");
    assert_has(&built, &[("sites", 2)]);
    let error = town.fails(
        1,
        "build grid.csv --sites shops.csv --site-id owner -o no.tiles --quiet",
    );
    for part in ["shops.csv", "owner"] {
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn lines_that_cross_are_named() {
    let town = town();
    let fence = "fence.csv: row 0 (counted from 0)";
    let house = "houses.geojson: feature 0 (counted from 0)";
    for (args, lines) in [
        (
            "--walls path.csv --walls cross.csv",
            vec![
                "error: 2 pairs of segments cross:".to_owned(),
                "  cross.csv: row 0 (counted from 0) and cross.csv: row 1 (counted from 0) at (1, 1)".to_owned(),
                "  cross.csv: row 3 (counted from 0) and cross.csv: row 4 (counted from 0) at (4, 4)".to_owned(),
            ],
        ),
        (
            "grid.csv --segments path.csv --segments fence.csv --obstacles houses.geojson",
            vec![
                "error: 2 pairs of segments cross:".to_owned(),
                format!("  {fence} and {house} at (1, 2.5)"),
                format!("  {fence} and {house} at (3, 2.5)"),
            ],
        ),
        (
            "bad.poly --walls path.csv",
            vec![
                "error: two lines cross:".to_owned(),
                "  bad.poly: segment 0 (counted from 0) and bad.poly: segment 1 (counted from 0) at (3, 3)".to_owned(),
            ],
        ),
        (
            "--obstacles houses.geojson --obstacles bow.geojson",
            vec![
                "error: two lines cross:".to_owned(),
                "  bow.geojson: feature 1 (counted from 0) crosses itself at (26, 3)".to_owned(),
            ],
        ),
    ] {
        let error = town.fails(1, &format!("build {args} -o no.tiles --quiet"));
        let (found, hint) = error.trim_end().rsplit_once('\n').unwrap();
        assert_eq!(found.lines().collect::<Vec<_>>(), lines, "{args}");
        assert!(hint.contains("--crossings split"), "{hint}");
    }
    // At most ten crossings are listed.
    let comb: String = (1..=11).map(|x| format!("{x},0,{x},9\n")).collect();
    fs::write(town.0.path().join("comb.csv"), comb + "0,5,12,5\n").unwrap();
    let error = town.fails(1, "build --walls comb.csv -o no.tiles --quiet");
    assert!(error.starts_with("error: 11 pairs of segments cross:\n"), "{error}");
    assert_eq!(error.matches("comb.csv: row 11").count(), 10, "{error}");
    assert!(error.contains("\n  and others\n"), "{error}");
    // Two sides, each in both directions, cross the path four times at the same position, and this
    // is the only crossing to report.
    let error = town.fails(1, "build --walls path.csv --obstacles flat.geojson -o no.tiles --quiet");
    assert!(error.starts_with("error: 4 pairs of segments cross:\n"), "{error}");
    assert_eq!(error.lines().count(), 3, "{error}");
}

#[test]
fn lines_that_cross_are_split() {
    let town = town();
    for (args, segments, crossings, edges) in [
        ("--walls cross.csv", 5, 2, 9),
        (
            "--obstacles houses.geojson --obstacles bow.geojson",
            8 + 3 + 4,
            1,
            8 + 3 + 6,
        ),
        // The fence and both walls of the house are split where they cross, and the path is split
        // at the end of the fence.
        (
            "--segments path.csv --segments fence.csv --obstacles houses.geojson",
            2 + 1 + 8,
            2,
            3 + 3 + 2 + 8,
        ),
        ("bad.poly", 2, 1, 4),
    ] {
        let [built, shown] = town.build(&format!("{args} --crossings split"));
        let counts = [
            ("segments", segments),
            ("crossings", crossings),
            ("constraint_edges", edges),
        ];
        assert_has(&built, &counts);
        assert_has(&shown, &[("crossings", crossings), ("constraint_edges", edges)]);
    }
    // A polygon that is inside out is an error, or still covers with --crossings split.
    let error = town.fails(
        1,
        "build --obstacles houses.geojson --obstacles beside.geojson -o no.tiles --quiet",
    );
    assert!(
        error
            .starts_with("error: beside.geojson: feature 1 (counted from 0) is inside out at (6, 1): one of its holes"),
        "{error}"
    );
    assert!(
        error.ends_with("or give --crossings split, which covers such parts too\n"),
        "{error}"
    );
    let [built, _] = town.build("--obstacles beside.geojson --crossings split");
    assert_has(&built, &[("crossings", 0), ("inverted_parts", 1), ("hole_regions", 3)]);
    assert_eq!(
        built["notes"][0],
        "1 part of a polygon is inside out, because rings are nested wrongly or cross, and still covered; the first is in \
         beside.geojson: feature 1 (counted from 0) at (6, 1)"
    );
    // If nothing crosses, --crossings split makes no difference.
    let [built, _] = town.build("grid.csv --obstacles houses.geojson --crossings split");
    assert_has(&built, &[("crossings", 0), ("added_vertices", 0)]);
    let split = town.ok("digest --recompute t.tiles");
    town.build("grid.csv --obstacles houses.geojson --crossings error");
    assert_eq!(town.ok("digest --recompute t.tiles"), split);
}

#[test]
fn segments_of_a_poly_file_refer_to_its_own_points() {
    let town = town();
    let error = town.fails(1, "build grid.csv court.poly -o no.tiles --quiet");
    assert!(
        error.contains("court.poly: give .poly files, and those whose edges are kept, before all other inputs"),
        "{error}"
    );
    // Two .poly files, the second shifted by 20 to the right, and points after them.
    let shifted: String = COURT
        .lines()
        .enumerate()
        .map(|(n, line)| match n {
            1..=8 => {
                let fields: Vec<u32> = line.split(' ').map(|field| field.parse().unwrap()).collect();
                format!("{} {} {}\n", fields[0], fields[1] + 20, fields[2])
            }
            19 => "1 24 4\n".to_owned(),
            _ => format!("{line}\n"),
        })
        .collect();
    fs::write(town.0.path().join("far.poly"), shifted).unwrap();
    let [built, shown] = town.build("court.poly far.poly grid.csv --walls path.csv");
    assert_has(&built, &[("segments", 8 + 8 + 2), ("hole_regions", 2)]);
    assert_has(&shown, &[("hole_points", 2)]);
    let lines = shown["lines"].as_array().unwrap();
    let names: Vec<_> = lines
        .iter()
        .map(|line| (line["name"].as_str().unwrap(), line["first_line"].as_u64().unwrap()))
        .collect();
    assert_eq!(names, [("path.csv", 0), ("court.poly", 2), ("far.poly", 10)]);
}

#[test]
fn wrong_options_and_files_are_errors_that_name_them() {
    let town = town();
    for (code, args, parts) in [
        (
            2,
            "grid.csv --obstacle houses.geojson",
            &["--obstacle", "--obstacles"][..],
        ),
        (2, "grid.csv --wall path.csv", &["--walls"]),
        (
            2,
            "grid.csv --segments path.csv --crossings merge",
            &["merge", "error", "split"],
        ),
        (2, "court.poly --exterior drop", &["drop", "keep", "hole"]),
        (2, "grid.csv --site-id name", &["--sites"]),
        (2, "--exterior hole", &["INPUT"]),
        (
            1,
            "--obstacles cross.csv",
            &["cross.csv", "polygons are read from GeoJSON"],
        ),
        (
            1,
            "--obstacles shops.geojson",
            &["shops.geojson: obstacle 0 (byte", "this is a Point"],
        ),
        (1, "--walls absent.csv", &["absent.csv", "cannot be opened"]),
    ] {
        let error = town.fails(code, &format!("build {args} -o no.tiles"));
        assert!(parts.iter().all(|part| error.contains(part)), "{args}: {error}");
    }
}
