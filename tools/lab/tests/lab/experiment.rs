//! `lab`: small experiments succeed, write what they promise, and nothing else.

use std::collections::HashMap;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Stdio;
use std::thread;
use std::time::Duration;

use crate::support::{errors, fails, names, printed, run, tiletool};
use rustix::process::{Pid, Signal, kill_process};

/// Returns the rows of a CSV file whose fields have no commas, by column.
fn rows(path: &Path) -> Vec<HashMap<String, String>> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text
        .lines()
        .map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let columns = lines.next().unwrap();
    lines
        .map(|fields| {
            assert_eq!(fields.len(), columns.len());
            columns.iter().cloned().zip(fields).collect()
        })
        .collect()
}

/// Checks that every picture that a page shows exists, and has the format of its suffix. Returns
/// their number.
fn check_pictures(folder: &Path) -> usize {
    let page = fs::read_to_string(folder.join("README.md")).unwrap();
    let shown: Vec<_> = page
        .split("](")
        .skip(1)
        .map(|rest| rest.split(')').next().unwrap())
        .collect();
    let pictures: Vec<_> = shown
        .iter()
        .filter(|name| name.ends_with("svg") || name.ends_with("png"))
        .collect();
    for name in &pictures {
        let bytes = fs::read(folder.join(name)).unwrap();
        match name.ends_with("svg") {
            true => assert!(bytes.starts_with(b"<svg") && bytes.ends_with(b"</svg>\n"), "{name}"),
            false => assert!(bytes.starts_with(b"\x89PNG"), "{name}"),
        }
    }
    pictures.len()
}

#[test]
fn builds_and_a_peer_are_measured() {
    let scratch = tempfile::tempdir().unwrap();
    let printed = run(
        scratch.path(),
        "build -o new/results --sizes 3k,300,3000 --alphas 0.5,1 --alpha-size 600 --memory 32MiB \
         --limit 1GiB --tile-vertices 500 --threads 2 --rounds 2 --peers spade",
    );
    let folder = scratch.path().join("new/results");
    let there = names(&folder);
    let mut told: Vec<_> = printed.lines().map(|line| line.rsplit('/').next().unwrap()).collect();
    told.sort_unstable();
    assert_eq!(told, there);
    assert_eq!(check_pictures(&folder), 13);

    let rows = rows(&folder.join("builds.csv"));
    // Three distributions, two sizes with and without segments and two shares; the peer on the uniform
    // ones only. Under the limit, both on the four uniform sets again. All in two rounds.
    assert_eq!(rows.len(), ((3 + 1) * (2 * 2 + 2) + 2 * 4) * 2);
    for row in &rows {
        let number = |column: &str| {
            row[column]
                .parse::<f64>()
                .unwrap_or_else(|_| panic!("{column}: {row:?}"))
        };
        assert_eq!(row["ended"], "done", "{row:?}");
        assert!(number("seconds") > 0.0 && number("peak_memory_bytes") > 1e6);
        assert_eq!(number("vertices"), number("points"));
        let ours = row["engine"] == "tiletool";
        assert_eq!(row["seam_share"].is_empty(), !ours);
        if ours {
            // The input is read at least once, and goes into the tiles.
            assert!(number("bytes_read") >= 16.0 * number("points"));
            assert!(number("bytes_written") >= 16.0 * number("points"));
            for share in ["seam_share", "border_share", "held_share"] {
                assert!((0.0..=1.0).contains(&number(share)), "{share}: {row:?}");
            }
            assert_eq!(number("segments") > 0.0, !row["alpha"].is_empty());
        }
    }
    let of = |engine: &str| {
        let rows = rows
            .iter()
            .filter(move |row| row["engine"] == engine && row["distribution"] == "uniform");
        rows.map(|row| row["triangles"].clone()).collect::<Vec<_>>()
    };
    assert_eq!(of("tiletool"), of("spade"));

    let page = fs::read_to_string(folder.join("README.md")).unwrap();
    for part in [
        "`lab build -o new/results",
        "| uniform | 3 000 |",
        "| kuzmin | 0.5 |",
        "Under a hard limit",
        "Isenburg",
        "count the same triangles",
    ] {
        assert!(page.contains(part), "{part} is missing: {page}");
    }
}

#[test]
fn builds_are_measured_without_peers() {
    let scratch = tempfile::tempdir().unwrap();
    run(
        scratch.path(),
        "build -o results --distributions kuzmin --sizes 300 --alphas 0 --peers",
    );
    let rows = rows(&scratch.path().join("results/builds.csv"));
    // Without segments, with 0.5 segments per point and with a share of 0; the first two again
    // under the limit.
    assert_eq!(rows.len(), 3 + 2);
    for row in rows {
        assert_eq!(
            (row["engine"].as_str(), row["distribution"].as_str()),
            ("tiletool", "kuzmin")
        );
    }
}

/// A stand-in checks the input that the program triangle would get.
#[test]
fn an_installed_program_triangle_is_a_peer() {
    let scratch = tempfile::tempdir().unwrap();
    let program = scratch.path().join("bin/triangle");
    fs::create_dir(scratch.path().join("bin")).unwrap();
    let script = "#!/bin/sh\n[ \"$(head -1 $2)\" = '300 2 0 0' ] || exit 9\n\
                  case $1,$2 in -Q,*.node) [ $(wc -l < $2) -eq 301 ];; -pcQ,*.poly) [ $(tail -1 $2) = 0 ];; *) exit 9;; esac\n";
    fs::write(&program, script).unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    let mut folders = vec![scratch.path().join("bin")];
    folders.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap()));
    let args = "build -o results --distributions uniform --sizes 300 --alphas 0.5 --peers triangle";
    let mut command = tiletool(scratch.path(), args);
    command.env("PATH", std::env::join_paths(folders).unwrap());
    printed(command);
    let rows = rows(&scratch.path().join("results/builds.csv"));
    let ended: Vec<_> = rows
        .iter()
        .filter(|row| row["engine"] == "triangle")
        .map(|row| row["ended"].as_str())
        .collect();
    assert_eq!(ended, ["done"; 4]);
}

#[test]
fn a_peer_above_the_memory_limit_is_killed_and_a_build_completes() {
    let scratch = tempfile::tempdir().unwrap();
    // Half a million points take spade more than 70 MB. A build takes the memory that it may use,
    // and what any process takes.
    run(
        scratch.path(),
        "build -o results --distributions uniform --sizes 500k --alphas 0.5 --alpha-size 300 --memory 24MiB \
         --limit 55MiB --tile-vertices 5000 --threads 1 --peers spade --pictures png",
    );
    let folder = scratch.path().join("results");
    assert_eq!(check_pictures(&folder), 13);
    let rows = rows(&folder.join("builds.csv"));
    for row in rows.iter().filter(|row| !row["limit_bytes"].is_empty()) {
        assert_eq!(row["ended"] == "done", row["engine"] == "tiletool", "{row:?}");
    }
    let page = fs::read_to_string(folder.join("README.md")).unwrap();
    assert!(page.contains("**killed** (signal"), "{page}");
}

/// The work folder is removed, and the measurements so far are not written.
#[test]
fn an_interrupted_experiment_leaves_no_files() {
    let scratch = tempfile::tempdir().unwrap();
    let results = scratch.path().join("results");
    let mut child = tiletool(scratch.path(), "build -o results --peers spade")
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // When it works, it has a scratch folder.
    while !results.exists() || names(&results).is_empty() {
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        thread::sleep(Duration::from_millis(5));
    }
    // The signal handler may be installed slightly later; until then the signal ends the process at
    // once, as it does any other.
    thread::sleep(Duration::from_millis(300));
    kill_process(Pid::from_child(&child), Signal::INT).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", errors(&output));
    assert!(errors(&output).contains("interrupted"), "{}", errors(&output));
    assert!(names(&results).is_empty());
}

/// Islands in a row, with a strait between each two, and one far away.
const ISLANDS: &str = r#"{"type": "FeatureCollection", "features": [
    {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [[[0,0],[2,0.5],[3,0],[3,4],[1,5],[0,0]]]}},
    {"type": "Feature", "properties": {}, "geometry": {"type": "MultiPolygon", "coordinates": [
        [[[4,-1],[5,-1],[5,3],[4.5,2],[4,3],[4,-1]]],
        [[[6,0],[9,0],[9,6],[8,1],[7,6],[6,0]]]]}},
    {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [[[90,90],[91,90],[90,91],[90,90]]]}}]}"#;

#[test]
fn pairs_depend_on_the_seed_and_not_on_threads_or_tiles() {
    let scratch = tempfile::tempdir().unwrap();
    fs::write(scratch.path().join("islands.geojson"), ISLANDS).unwrap();
    let args = "stretch islands.geojson --pairs 300 --seed 3 --within -1,-1,10,10 -o";
    run(scratch.path(), &format!("{args} all --threads 2"));
    let folder = scratch.path().join("all");
    // Histogram, islands, visibility graph, triangulation, two trees, and the worst pair.
    assert_eq!(check_pictures(&folder), 7);
    let rows = rows(&folder.join("pairs.csv"));
    assert_eq!(rows.len(), 300);
    let mut largest = 1.0f64;
    for row in &rows {
        let number = |column: &str| row[column].parse::<f64>().unwrap();
        let (geodesic, ratio) = (number("geodesic"), number("ratio"));
        assert!(number("from_x") < 10.0, "the far island was not chosen");
        assert!(number("straight") <= geodesic * (1.0 + 1e-12));
        assert!((1.0..=2.42).contains(&ratio));
        assert!((ratio * geodesic - number("cdt")).abs() < 1e-9 * geodesic);
        largest = largest.max(ratio);
    }
    assert!(largest > 1.01, "no way along edges is longer than the shortest path");
    let page = fs::read_to_string(folder.join("README.md")).unwrap();
    assert!(
        page.contains(&format!("The largest ratio is **{largest:.6}**")),
        "{page}"
    );

    // The pairs are the same with any number of threads, and from tiles; other seeds give other
    // pairs.
    let pairs = |name: &str| fs::read_to_string(scratch.path().join(name).join("pairs.csv")).unwrap();
    run(
        scratch.path(),
        &format!("{args} again --threads 1 --graph-vertices 5 --pictures png"),
    );
    assert_eq!(pairs("again"), pairs("all"));
    assert_eq!(check_pictures(&scratch.path().join("again")), 6);
    run(
        scratch.path(),
        "tool build --obstacles islands.geojson -o islands.tiles --quiet",
    );
    run(scratch.path(), "stretch islands.tiles --pairs 20 -o tiles");
    run(scratch.path(), "stretch islands.geojson --pairs 20 -o other");
    assert_eq!(pairs("tiles"), pairs("other"));
    run(scratch.path(), "stretch islands.geojson --pairs 20 --seed 4 -o other");
    assert_ne!(pairs("tiles"), pairs("other"));
}

#[test]
fn the_visibility_graph_of_a_square_has_its_four_edges() {
    let scratch = tempfile::tempdir().unwrap();
    let square = r#"{"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {}, "geometry":
        {"type": "Polygon", "coordinates": [[[0,0],[1,0],[1,1],[0,1],[0,0]]]}}]}"#;
    fs::write(scratch.path().join("square.geojson"), square).unwrap();
    run(scratch.path(), "stretch square.geojson --pairs 50 -o results");
    let picture = |name: &str| fs::read_to_string(scratch.path().join("results").join(name)).unwrap();
    // Along the edges, and not across.
    assert!(picture("visibility.svg").contains(">4 pairs of vertices see each other<"));
    assert!(picture("tree-geodesic.svg").contains(", 3 edges<"));
    assert!(picture("tree-cdt.svg").contains(", 3 edges<"));
    // Outside of obstacles there are only walls.
    assert!(picture("triangulation.svg").contains(", 0 edges that are no walls<"));
}

/// Four houses around a point: no free area touches it. An experiment once ended with "lies in an
/// obstacle", since it asked what every vertex sees (found on a map of buildings that share walls).
#[test]
fn a_vertex_that_touching_obstacles_enclose_sees_nothing() {
    let scratch = tempfile::tempdir().unwrap();
    let houses = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| {
        let (right, top) = (x + 1, y + 1);
        format!("[[[{x},{y}],[{right},{y}],[{right},{top}],[{x},{top}],[{x},{y}]]]")
    });
    let houses = format!(r#"{{"type": "MultiPolygon", "coordinates": [{}]}}"#, houses.join(","));
    fs::write(scratch.path().join("houses.geojson"), houses).unwrap();
    run(scratch.path(), "stretch houses.geojson --pairs 20 -o results");
    let picture = fs::read_to_string(scratch.path().join("results/visibility.svg")).unwrap();
    // Eight vertices are around the block; each sees its neighbours, and these hide the others.
    assert!(picture.contains(">8 pairs of vertices see each other<"), "{picture}");
}

#[test]
fn impossible_arguments_are_refused_before_anything_is_measured() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    fs::write(folder.join("file"), "mine").unwrap();
    for (args, complaint) in [
        ("build -o file", "is not a folder"),
        ("build -o file/below", "cannot make the folder"),
        ("build -o huge --sizes 4G", "of disk"),
        (
            "build -o small --sizes 100k --alphas 0.5 --memory 1MiB --peers spade",
            "the build failed",
        ),
        ("stretch none.geojson -o small", "none.geojson"),
        ("stretch file -o small", "file cannot be triangulated"),
        ("stretch file -o small --within 0,0,1,1", "file is no GeoJSON"),
    ] {
        let error = fails(folder, 1, args);
        assert!(error.contains(complaint), "{args}: {error}");
    }
    assert_eq!(fs::read(folder.join("file")).unwrap(), b"mine");
    for made in ["huge", "small"] {
        assert!(names(&folder.join(made)).is_empty());
    }
    for args in [
        "queries",
        "bild -o x",
        "build",
        "build -o x --sizes 2",
        "build -o x --sizes many",
        "build -o x --alphas 1.5",
        "build -o x --rounds 0",
        "build -o x --peers qhull",
        "build -o x --distributions grid",
        "build -o x --distributions none",
        "stretch -o x",
        "stretch p.geojson -o x --pairs 0",
        "stretch p.geojson -o x --within 1,2,0,3",
        "build -o x --pictures gif",
    ] {
        fails(folder, 2, args);
        assert!(!folder.join("x").exists());
    }
}
