//! `verify` with the lines and sites of a build: what is compared, and the errors for different
//! input.

use std::fmt::Write;
use std::fs;

use crate::support::data;
use serde_json::Value;
use tempfile::TempDir;

struct Scratch(TempDir);

impl Scratch {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.0.path().join(name), content).unwrap();
    }

    /// Runs a command that must succeed. Returns its standard output.
    #[track_caller]
    fn ok(&self, args: &str) -> String {
        crate::support::run(self.0.path(), args)
    }

    #[track_caller]
    fn json(&self, args: &str) -> Value {
        crate::support::json(self.0.path(), &format!("{args} --json"))
    }

    /// Runs a command that must fail. Returns its standard error.
    #[track_caller]
    fn fails(&self, args: &str) -> String {
        crate::support::fails(self.0.path(), 1, args)
    }
}

const HOUSES: &str = r#"{"type": "FeatureCollection", "features": [
    {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates":
        [[[1, 1, 5], [4, 1, 5], [4, 4, 5], [1, 4, 5], [1, 1, 5]], [[2, 2, 6], [3, 2, 6], [3, 3, 6], [2, 2, 6]]]}},
    {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates":
        [[[4, 1], [4, 4], [7, 4], [7, 1]]]}}]}"#;

/// A town with points, break lines between records, walls, houses and shops.
fn town() -> Scratch {
    let scratch = Scratch::new();
    let rows: String = (0..100).fold("x,y,z\n".to_owned(), |mut rows, i| {
        writeln!(rows, "{},{},{}", i % 10, i / 10, i).unwrap();
        rows
    });
    scratch.write("points.csv", rows);
    scratch.write("paths.u32", [90u32, 99, 80, 89, 3, 3].map(u32::to_le_bytes).concat());
    scratch.write("creek.csv", "0,6,9,6\n");
    scratch.write("fences.csv", "x1,y1,x2,y2\n0,5,9,5\n0.5,7.5,3.5,7.5\n");
    scratch.write("houses.geojson", HOUSES);
    scratch.write("shops.csv", "x,y,name\n5.5,5.5,baker\n5.5,5.5,butcher\n0,0,baker\n");
    scratch
}

const LINES: &str = "--segments paths.u32 --segments creek.csv --walls fences.csv --obstacles houses.geojson \
    --sites shops.csv --site-id name";

#[test]
fn a_town_is_compared_with_all_of_its_input() {
    let scratch = town();
    for tile_vertices in [8, 30, 1000] {
        let build =
            format!("build points.csv {LINES} --missing-z zero -o town.tiles --force --tile-vertices {tile_vertices}");
        let summary = scratch.json(&build);
        assert_eq!(summary["segments"], 17);
        for memory in ["16MiB", "1GiB"] {
            let args = format!("verify --deep town.tiles {LINES} --memory {memory} --against points.csv");
            let report = scratch.json(&args);
            assert_eq!(report["ok"], true);
            assert_eq!(report["input_segments"], summary["segments"]);
            assert_eq!(report["input_sites"], 3);
            assert_eq!(report["input_points"], 100 + 2 * (17 - 3) + 3);
            assert_eq!(report["constraint_edges"], summary["constraint_edges"]);
            let text = scratch.ok(&args);
            assert!(
                text.contains("All segments of the input (17) are chains of edges"),
                "{text}"
            );
            assert!(
                text.contains("The file holds all sites of the input (3) and no others"),
                "{text}"
            );
        }
    }
    // The report has no counts of segments and sites if none were compared.
    scratch.ok("build points.csv -o plain.tiles --quiet");
    let report = scratch.json("verify plain.tiles --against points.csv");
    assert!(report.get("input_segments").is_none() && report.get("input_sites").is_none());
}

#[test]
fn a_difference_in_the_input_is_named_by_file_and_line() {
    let scratch = town();
    scratch.ok(&format!(
        "build points.csv {LINES} --missing-z zero -o town.tiles --quiet --tile-vertices 20"
    ));
    let with = |name: &str, content: &str, other: &str| {
        scratch.write(other, content);
        format!("verify town.tiles {} --against points.csv", LINES.replace(name, other))
    };
    let without = |option: &str| {
        let lines = LINES.replace(option, "").replace("  ", " ");
        format!("verify town.tiles {} --against points.csv", lines.trim())
    };
    for (args, expected) in [
        (
            with("fences.csv", "0,5,9,5\n0.5,7.5,3.5,7.75\n", "moved.csv"),
            "moved.csv: row 1 (counted from 0): wall 5 from (0.5, 7.5) to (3.5, 7.75) is not a chain of edges",
        ),
        (with("fences.csv", "0,5,9,5\n", "fewer.csv"), "not a chain"),
        (
            with("fences.csv", "0,5,8,5\n0.5,7.5,3.5,7.5\n", "shorter.csv"),
            "shorter.csv: row 0 (counted from 0): wall 4 from (8, 5) to (9, 5) is an edge of the file, but not of the input",
        ),
        (
            with("houses.geojson", &HOUSES.replace("[7, 4]", "[7, 3]"), "smaller.geojson"),
            "smaller.geojson: feature 1 (counted from 0): obstacle 7 from",
        ),
        (
            with(
                "shops.csv",
                "x,y,name\n5.5,5.5,baker\n5.5,5.5,butcher\n0,0,banker\n",
                "bank.csv",
            ),
            "site 2 of the input (counted from 0) at (0, 0) is not in the file",
        ),
        (
            with("shops.csv", "x,y,name\n5.5,5.5,baker\n5.5,5.5,butcher\n", "two.csv"),
            "site baker at (0, 0) of the file is not in the input",
        ),
        (
            without("--obstacles houses.geojson"),
            "obstacle 6 from (1, 1) to (1, 2) is an edge of the file",
        ),
        (
            without("--sites shops.csv --site-id name"),
            "of the file is not in the input",
        ),
    ] {
        let error = scratch.fails(&args);
        assert!(error.contains(expected), "{args}: {error}");
    }
    scratch.write("other.u32", [90u32, 99, 80, 79, 3, 3].map(u32::to_le_bytes).concat());
    scratch.write("far.u32", [90u32, 99, 80, 100, 3, 3].map(u32::to_le_bytes).concat());
    let lines = |pairs: &str| {
        format!(
            "verify town.tiles --against points.csv {}",
            LINES.replace("paths.u32", pairs)
        )
    };
    let error = scratch.fails(&lines("other.u32"));
    assert!(
        error.contains("other.u32: pair 1 (counted from 0): break line 1 from (0, 8) to (9, 7)"),
        "{error}"
    );
    assert!(scratch.fails(&lines("far.u32")).contains("no point has this number"));
    // Inputs that the command line does not name.
    let error = scratch.fails(&format!("verify town.tiles {LINES}"));
    assert!(
        error.contains("the file was also built from 100 points; name the files of points with --against"),
        "{error}"
    );
    let error = scratch.fails("verify town.tiles --against points.csv");
    assert!(error.contains("the file has vertices from lines or sites ("), "{error}");
    let error = scratch.fails(&format!("verify town.tiles {LINES} --against - --format text"));
    assert!(error.contains("name a file instead of -"), "{error}");
}

#[test]
fn verify_accepts_files_of_lines_alone_and_poly_files() {
    let scratch = town();
    scratch
        .ok("build --obstacles houses.geojson --sites shops.csv --site-id name -o town.tiles --missing-z zero --quiet");
    scratch.ok("verify --deep town.tiles --obstacles houses.geojson --sites shops.csv --site-id name");
    let rows = "4 2 0 0\n1 0 0\n2 9 0\n3 9 9\n4 0 9\n4 0\n1 1 2\n2 2 3\n3 3 4\n4 4 1\n1\n1 2.5 2.5\n";
    scratch.write("square.poly", rows);
    scratch.write("late.poly", rows.replace("2.5 2.5", "3.5 2.5"));
    scratch.write("open.poly", rows.replace("4 4 1\n", "4 4 4\n"));
    scratch.ok("build square.poly -o square.tiles --exterior hole --quiet");
    let arena = data("arena/arena.poly");
    scratch.ok(&format!("build {arena} -o arena.tiles --exterior hole --quiet"));
    scratch.ok(&format!("verify --deep arena.tiles --against {arena}"));
    let report = scratch.json("verify --deep square.tiles --against square.poly");
    assert_eq!(
        (&report["input_segments"], &report["input_points"]),
        (&4.into(), &4.into())
    );
    assert!(
        scratch
            .fails("verify square.tiles --against late.poly")
            .contains("hole points")
    );
    let error = scratch.fails("verify square.tiles --against open.poly");
    assert!(
        error.contains("wall 3 from (0, 0) to (0, 9) is an edge of the file"),
        "{error}"
    );
}

#[test]
fn verify_splits_the_lines_that_the_build_split() {
    let scratch = Scratch::new();
    scratch.write("cross.csv", "0,0,4,4.1\n4,0,0,4.1\n0,1,7,3\n");
    scratch.write("others.csv", "0,0,4,4.1\n4,0,0,4\n0,1,7,3\n");
    scratch.write("apart.csv", "0,0,4,4.1\n4,0,3,0\n");
    scratch.write(
        "fence.geojson",
        r#"{"type":"LineString","coordinates":[[0,3,10],[7,1,20],[7,1,20],[0,2,15]]}"#,
    );
    scratch.write("gate.csv", "1.5,2,gate\n");
    // The third point is on the last line.
    scratch.write("points.csv", "x,y\n1.5,2\n9,9\n3.5,2\n6,2\n");
    let all = "--segments cross.csv --walls fence.geojson --sites gate.csv";
    scratch.ok(&format!(
        "build points.csv {all} --crossings split --missing-z zero -o cross.tiles --quiet"
    ));
    scratch.ok("verify --deep cross.tiles");
    let printed = scratch.ok(&format!("verify cross.tiles --against points.csv {all}"));
    assert!(
        printed.contains("split where they cross each other or cell borders, are chains of edges"),
        "{printed}"
    );
    let error = scratch.fails("verify cross.tiles --against points.csv --segments cross.csv --sites gate.csv");
    assert!(error.contains("but the given lines have 3;"), "{error}");
    scratch.ok("build points.csv --segments cross.csv --crossings split --missing-z zero -o few.tiles --quiet");
    let error = scratch.fails("verify few.tiles --against points.csv --segments others.csv");
    assert!(error.contains("is not a chain of edges that come from it"), "{error}");
    let error = scratch.fails("verify few.tiles --against points.csv --segments apart.csv");
    assert!(
        error.contains("the build split 3 crossings, but the given lines have 0;"),
        "{error}"
    );
    let error = scratch.fails("verify few.tiles --segments cross.csv");
    assert!(error.contains("the file was also built from 4 points"), "{error}");
}

/// There are more segments between records than are looked up at once.
#[test]
fn many_pairs_of_records_are_verified_in_little_memory() {
    let scratch = Scratch::new();
    scratch.ok("generate grid -n 90000 -o g.f64");
    let points = fs::read(scratch.0.path().join("g.f64")).unwrap();
    let points_bits: Vec<[u64; 2]> = points
        .chunks(16)
        .map(|p| [0, 8].map(|at| u64::from_le_bytes(p[at..at + 8].try_into().unwrap())))
        .collect();
    let mut along: Vec<u32> = (0..points_bits.len() as u32).collect();
    let key = |v: u32| points_bits[v as usize].map(f64::from_bits);
    along.sort_by(|&a, &b| key(a).partial_cmp(&key(b)).unwrap());
    let pairs = along.windows(2).filter(|pair| key(pair[0])[0] == key(pair[1])[0]);
    let bytes: Vec<u8> = pairs.flatten().flat_map(|v| v.to_le_bytes()).collect();
    scratch.write("columns.u32", &bytes);
    scratch.ok("build g.f64 --walls columns.u32 -o g.tiles --tile-vertices 2000 --quiet");
    for memory in ["12MiB", "1GiB"] {
        let report = scratch.json(&format!(
            "verify g.tiles --against g.f64 --walls columns.u32 --memory {memory}"
        ));
        assert_eq!(report["input_segments"], bytes.len() / 8);
        assert_eq!(report["input_points"], 90_000);
        // Unknown on systems without /proc.
        if let (Some(peak), "12MiB") = (report["peak_memory_bytes"].as_u64(), memory) {
            assert!(peak <= 44 << 20, "{peak}");
        }
    }
    let mut wrong = bytes.clone();
    let (at, other) = (8 * 88_000, 8 * 20_000);
    wrong.copy_within(other..other + 4, at);
    scratch.write("columns.u32", wrong);
    for memory in ["12MiB", "1GiB"] {
        let args = format!("verify g.tiles --against g.f64 --walls columns.u32 --memory {memory}");
        let error = scratch.fails(&args);
        assert!(error.contains("columns.u32: pair 88000 (counted from 0)"), "{error}");
    }
}
