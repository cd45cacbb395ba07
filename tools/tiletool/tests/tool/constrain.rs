//! `tiletool constrain`, `unconstrain` and `compact` from the command line: their results, mistakes,
//! and kills at any moment.

use std::fs;
use std::path::Path;
use std::time::Instant;

use crate::support::cases::cases;
use crate::support::{data, fails, json, kill_after, run, tiletool};

/// Returns a folder with a file of the islands' corners, and a file built with the islands as
/// holes.
fn islands() -> tempfile::TempDir {
    let scratch = tempfile::tempdir().unwrap();
    fs::copy(
        data("indonesia/indonesia_ne10m.geojson"),
        scratch.path().join("islands.geojson"),
    )
    .unwrap();
    run(
        scratch.path(),
        "build islands.geojson -o points.tiles --tile-vertices 700",
    );
    run(
        scratch.path(),
        "build --obstacles islands.geojson -o whole.tiles --tile-vertices 700",
    );
    scratch
}

#[test]
fn islands_become_holes_of_a_file_of_points() {
    let scratch = islands();
    let folder = scratch.path();
    let summary = json(folder, "constrain points.tiles --obstacles islands.geojson --json");
    assert_eq!(summary["hole_regions"], 339);
    assert_eq!(summary["hole_triangles"], 22_863);
    assert_eq!(
        run(folder, "digest --recompute points.tiles"),
        run(folder, "digest --recompute whole.tiles")
    );
    run(
        folder,
        "verify --deep points.tiles --against islands.geojson --obstacles islands.geojson",
    );
    let bytes = json(folder, "compact points.tiles --json");
    assert!(bytes["bytes_after"].as_u64() < bytes["bytes_before"].as_u64());
    run(folder, "verify --deep points.tiles");
    assert_eq!(
        run(folder, "digest --recompute points.tiles"),
        run(folder, "digest --recompute whole.tiles")
    );
}

#[test]
fn a_mistake_is_an_error_and_leaves_the_file_unchanged() {
    let scratch = islands();
    let folder = scratch.path();
    let before = fs::read(folder.join("points.tiles")).unwrap();
    fs::write(folder.join("off.csv"), "0,0,9,9\n9,0,0,9\n").unwrap();
    fs::write(folder.join("empty.csv"), "").unwrap();
    for (args, says) in [
        ("constrain points.tiles", "no lines are given"),
        ("constrain points.tiles --segments off.csv", "off.csv"),
        ("constrain points.tiles --segments off.csv", "crosses"),
        ("constrain points.tiles --segments empty.csv", "no lines in these files"),
        ("constrain islands.geojson --segments off.csv", "it is no tile file"),
        ("constrain nothing.tiles --segments off.csv", "nothing.tiles"),
        ("compact points.tiles -o whole.tiles", "whole.tiles exists"),
        ("compact islands.geojson", "it is no tile file"),
    ] {
        let error = fails(folder, 1, args);
        assert!(error.contains(says), "{args}: {error}");
    }
    assert_eq!(fs::read(folder.join("points.tiles")).unwrap(), before);
}

/// Writes every other island to `even.geojson`, and the rest to `odd.geojson`.
fn divide_islands(folder: &Path) {
    let text = fs::read(folder.join("islands.geojson")).unwrap();
    let mut all: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let features = all["features"].as_array().unwrap().clone();
    assert!(features.len() > 1, "{}", features.len());
    for (name, first) in [("even.geojson", 0), ("odd.geojson", 1)] {
        all["features"] = features.iter().skip(first).step_by(2).cloned().collect();
        fs::write(folder.join(name), all.to_string()).unwrap();
    }
}

#[test]
fn islands_are_removed_as_if_the_file_had_been_built_without_them() {
    let scratch = islands();
    let folder = scratch.path();
    divide_islands(folder);
    run(folder, "build --obstacles odd.geojson -o odd.tiles");
    let odd = run(folder, "digest --recompute odd.tiles");
    let before = fs::read(folder.join("whole.tiles")).unwrap();
    let planned = json(
        folder,
        "unconstrain whole.tiles --obstacles even.geojson --dry-run --json",
    );
    assert_eq!(fs::read(folder.join("whole.tiles")).unwrap(), before);
    let summary = json(folder, "unconstrain whole.tiles --obstacles even.geojson --json");
    for key in [
        "removed_segments",
        "removed_vertices",
        "freed_edges",
        "hole_regions",
        "triangles",
    ] {
        assert_eq!(summary[key], planned[key], "{key}");
    }
    assert_eq!(summary["removed_segments"], summary["freed_edges"]);
    assert_eq!(run(folder, "digest --recompute whole.tiles"), odd);
    run(folder, "verify --deep whole.tiles --obstacles odd.geojson");
    let error = fails(folder, 1, "verify whole.tiles --obstacles islands.geojson");
    assert!(error.contains("is not a chain of edges"), "{error}");
    run(folder, "compact whole.tiles");
    run(folder, "verify --deep whole.tiles --obstacles odd.geojson");
    // All that is left goes, and nothing remains.
    let text = run(folder, "unconstrain whole.tiles --obstacles odd.geojson");
    assert!(text.contains("0 vertices, 0 triangles"), "{text}");
    run(folder, "verify --deep whole.tiles");

    // Beside a wall that comes and goes by its number, nothing changes.
    let plain = run(folder, "digest --recompute points.tiles");
    fs::write(folder.join("wall.csv"), "100,-7.123,100,5.321\n100,5.321,101,5.322\n").unwrap();
    run(folder, "constrain points.tiles --walls wall.csv");
    let text = run(folder, "unconstrain points.tiles --line 0 --line 1");
    assert!(text.contains("removed 2 lines"), "{text}");
    assert_eq!(run(folder, "digest --recompute points.tiles"), plain);
    for (args, says) in [
        ("unconstrain points.tiles", "no lines are given"),
        (
            "unconstrain points.tiles --walls wall.csv",
            "no line of this kind has the segment from (100, -7.123)",
        ),
        ("unconstrain points.tiles --line 7", "no line 7"),
        ("unconstrain points.tiles --line seven", "invalid"),
    ] {
        let code = if says == "invalid" { 2 } else { 1 };
        let error = fails(folder, code, args);
        assert!(error.contains(says), "{args}: {error}");
    }
    let text = run(
        folder,
        "unconstrain points.tiles --walls wall.csv --line 7 --skip-missing",
    );
    assert!(text.contains("3 segments or lines left out"), "{text}");
}

#[test]
fn a_removal_killed_at_any_moment_is_applied_completely_or_not_at_all() {
    let scratch = islands();
    let folder = scratch.path();
    let whole = run(folder, "digest --recompute whole.tiles");
    let before = fs::read(folder.join("whole.tiles")).unwrap();
    divide_islands(folder);
    let removal = "unconstrain whole.tiles --obstacles even.geojson";
    let began = Instant::now();
    run(folder, removal);
    let took = began.elapsed();
    let odd = run(folder, "digest --recompute whole.tiles");
    let all = cases(64) as u32;
    for kill in 0..all {
        fs::write(folder.join("whole.tiles"), &before).unwrap();
        kill_after(tiletool(folder, removal), took * kill * 5 / (4 * all));
        let digest = run(folder, "digest --recompute whole.tiles");
        assert!(digest == whole || digest == odd, "kill {kill}");
    }
}

#[test]
fn an_edit_killed_at_any_moment_is_applied_completely_or_not_at_all() {
    let scratch = islands();
    let folder = scratch.path();
    let (points, whole) = (
        run(folder, "digest --recompute points.tiles"),
        run(folder, "digest --recompute whole.tiles"),
    );
    let before = fs::read(folder.join("points.tiles")).unwrap();
    let began = Instant::now();
    run(folder, "constrain points.tiles --obstacles islands.geojson");
    let took = began.elapsed();
    let mut seen = [0; 2];
    let all = cases(100);
    for kill in 0..all {
        fs::write(folder.join("points.tiles"), &before).unwrap();
        // A second kill follows. What the first one left must not disturb it.
        for moment in [kill as f64 / (0.88 * all as f64), 0.5] {
            let edit = tiletool(folder, "constrain points.tiles --obstacles islands.geojson --quiet");
            kill_after(edit, took.mul_f64(moment));
            let found = run(folder, "digest --recompute points.tiles");
            assert!(
                found == points || found == whole,
                "killed after {moment} of the time: {found}"
            );
            seen[usize::from(found == whole)] += 1;
            if found == whole {
                // The second edit would insert the lines once more.
                break;
            }
        }
        run(folder, "verify points.tiles");
    }
    assert!(seen[0] > 0, "{seen:?}");
}

/// Returns a folder with these files.
fn folder_with(files: &[(&str, &str)]) -> tempfile::TempDir {
    let scratch = tempfile::tempdir().unwrap();
    for (name, text) in files {
        fs::write(scratch.path().join(name), text).unwrap();
    }
    scratch
}

/// `verify` once rejected files that `constrain` had changed. An edit numbered the ends of its
/// lines from the number of vertices on, but a build counts two records for each segment. And
/// `verify` read all break lines before all walls, whichever had been added first. Now an edit
/// continues the numbers of the file, and `verify` follows the order in which lines were added.
#[test]
fn verify_with_all_inputs_accepts_an_edited_file() {
    let files = [
        ("p.csv", "0,0\n9,0\n0,9\n9,9\n2,1\n"),
        ("b.csv", "0,0,2,1\n"),
        ("n.csv", "1,3,3,3\n"),
        ("wall.csv", "1,1,3,2\n2,1,4,1\n"),
        ("seg.csv", "1,3,3,3\n2,5,3,3\n"),
        ("cross.csv", "5,1,8,4\n5,4,8,1\n"),
        (
            "house.geojson",
            r#"{"type":"Polygon","coordinates":[[[5,5],[7,5],[7,7],[5,7],[5,5]]]}"#,
        ),
        ("sites.csv", "8,8,a\n0.5,8,b\n"),
    ];
    // A build, the edits after it, and the options of `verify`, which name the files of each kind
    // in the order in which they were added.
    for (build, edits, verify) in [
        // A segment whose ends are points also counts two records.
        (
            "--segments b.csv",
            ["--segments n.csv"].as_slice(),
            "--segments b.csv --segments n.csv",
        ),
        // Break lines that were added after walls.
        (
            "--walls wall.csv",
            &["--segments seg.csv"],
            "--walls wall.csv --segments seg.csv",
        ),
        (
            "--walls wall.csv",
            &["--segments seg.csv"],
            "--segments seg.csv --walls wall.csv",
        ),
        // Sites, split lines, and edits of several kinds, one after the other.
        (
            "--segments cross.csv --crossings split --sites sites.csv",
            &[
                "--walls n.csv --obstacles house.geojson",
                "--segments b.csv",
                "--walls wall.csv",
            ],
            "--segments cross.csv --sites sites.csv --walls n.csv --obstacles house.geojson --segments b.csv --walls wall.csv",
        ),
    ] {
        let scratch = folder_with(&files);
        let folder = scratch.path();
        run(folder, &format!("build p.csv {build} -o x.tiles"));
        for edit in edits {
            run(folder, &format!("constrain x.tiles {edit}"));
        }
        let verify = format!("verify --deep x.tiles --against p.csv {verify}");
        run(folder, &verify);
        run(folder, "compact x.tiles");
        run(folder, &verify);
        // A file that was not added is rejected.
        let error = fails(folder, 1, &format!("{verify} --segments wall.csv"));
        assert!(error.contains("--segments names"), "{error}");
    }
}

/// The points come from a .poly file, whose segments are walls of the build. The walls of an edit
/// follow them.
#[test]
fn verify_accepts_edits_of_a_file_built_from_a_poly_file() {
    let scratch = folder_with(&[("wall.csv", "0.5,0.5,1.5,1.5\n"), ("first.csv", "1,0.5,1.5,0.5\n")]);
    let folder = scratch.path();
    let poly = "5 2 0 0\n1 0 0\n2 4 0\n3 4 4\n4 0 4\n5 2 2\n2 0\n1 1 2\n2 3 4\n0\n";
    fs::write(folder.join("square.poly"), poly).unwrap();
    run(folder, "build square.poly --walls first.csv -o x.tiles");
    run(folder, "constrain x.tiles --walls wall.csv");
    run(
        folder,
        "verify --deep x.tiles --against square.poly --walls first.csv --walls wall.csv",
    );
    fails(
        folder,
        1,
        "verify x.tiles --against square.poly --walls wall.csv --walls first.csv",
    );
}
