//! `tiletool constrain` and `compact`, as their user meets them: what they make, mistakes, and kills at any moment.

mod support;

use std::fs;
use std::time::Instant;

use support::{data, fails, json, kill_after, run, tiletool};

/// Islands as holes of a file of their corners, and of one that knew them from the start.
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
    assert_eq!(run(folder, "digest points.tiles"), run(folder, "digest whole.tiles"));
    run(
        folder,
        "verify --deep points.tiles --against islands.geojson --obstacles islands.geojson",
    );
    let bytes = json(folder, "compact points.tiles --json");
    assert!(bytes["bytes_after"].as_u64() < bytes["bytes_before"].as_u64());
    run(folder, "verify --deep points.tiles");
    assert_eq!(run(folder, "digest points.tiles"), run(folder, "digest whole.tiles"));
}

#[test]
fn mistakes() {
    let scratch = islands();
    let folder = scratch.path();
    let before = fs::read(folder.join("points.tiles")).unwrap();
    fs::write(folder.join("off.csv"), "95,5,96,5\n").unwrap();
    fs::write(folder.join("empty.csv"), "").unwrap();
    for (args, says) in [
        ("constrain points.tiles", "there are no lines"),
        ("constrain points.tiles --segments off.csv", "off.csv"),
        ("constrain points.tiles --segments off.csv", "outside the hull"),
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

#[test]
fn an_edit_that_is_killed_at_any_moment_happened_or_not() {
    let scratch = islands();
    let folder = scratch.path();
    let (points, whole) = (run(folder, "digest points.tiles"), run(folder, "digest whole.tiles"));
    let before = fs::read(folder.join("points.tiles")).unwrap();
    let began = Instant::now();
    run(folder, "constrain points.tiles --obstacles islands.geojson");
    let took = began.elapsed();
    let mut seen = [0; 2];
    for kill in 0..25 {
        fs::write(folder.join("points.tiles"), &before).unwrap();
        // Once more after a kill: what that left is in nobody's way.
        for moment in [kill as f64 / 22.0, 0.5] {
            let edit = tiletool(folder, "constrain points.tiles --obstacles islands.geojson --quiet");
            kill_after(edit, took.mul_f64(moment));
            let found = run(folder, "digest points.tiles");
            assert!(
                found == points || found == whole,
                "killed after {moment} of the time: {found}"
            );
            seen[usize::from(found == whole)] += 1;
        }
        run(folder, "verify points.tiles");
    }
    assert!(seen[0] > 0, "{seen:?}");
}
