//! `--memory` of the commands that read tile files: the results do not depend on it, and the peak
//! stays near it.

use std::fs;
use std::path::Path;

use crate::support::{fails, tiletool};
use serde_json::Value;
use tempfile::TempDir;

const MEBIBYTE: u64 = 1 << 20;

/// Returns the JSON output of a command.
fn json(folder: &Path, args: &str) -> Value {
    crate::support::json(folder, &format!("{args} --json"))
}

/// Returns a folder with `p.f64`, which has points with z, and `p.tiles`, whose tiles have this
/// many vertices.
fn scratch(points: u32, tile_vertices: u32) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    json(
        folder.path(),
        &format!("generate lidar -n {points} --dims 3 --seed 5 -o p.f64"),
    );
    json(
        folder.path(),
        &format!("build p.f64 --dims 3 -o p.tiles --tile-vertices {tile_vertices}"),
    );
    folder
}

/// Returns the result without the values that may differ.
fn result(mut value: Value) -> Value {
    let object = value.as_object_mut().unwrap();
    object.remove("peak_memory_bytes");
    if let Some(plot) = object.get_mut("plot") {
        plot.as_object_mut().unwrap().remove("peak_memory_bytes");
    }
    value
}

#[test]
fn results_do_not_depend_on_the_memory() {
    let scratch = scratch(60_000, 2000);
    let folder = scratch.path();
    for args in [
        "digest --recompute p.tiles",
        "verify --deep p.tiles --against p.f64 --dims 3",
    ] {
        let plenty = result(json(folder, args));
        for memory in ["8MiB", "30MiB", "1GiB"] {
            assert_eq!(
                result(json(folder, &format!("{args} --memory {memory}"))),
                plenty,
                "{args}"
            );
        }
    }
    for (command, output) in [
        ("export p.tiles -o o.ply", "o.ply"),
        ("export p.tiles -o o.node", "o.ele"),
        ("export p.tiles -o o.obj", "o.obj"),
        ("export p.tiles -o o.geojson", "o.geojson"),
        ("inspect p.tiles --plot o.svg", "o.svg"),
    ] {
        let plenty = result(json(folder, command));
        let bytes = fs::read(folder.join(output)).unwrap();
        fs::remove_file(folder.join(output)).unwrap();
        for memory in ["24MiB", "100MiB"] {
            assert_eq!(result(json(folder, &format!("{command} --memory {memory}"))), plenty);
            assert!(
                fs::read(folder.join(output)).unwrap() == bytes,
                "{command} with {memory}"
            );
        }
    }
}

#[test]
fn the_first_missing_point_does_not_depend_on_the_memory() {
    let scratch = scratch(150_000, 1000);
    let folder = scratch.path();
    let mut points = fs::read(folder.join("p.f64")).unwrap();
    for record in [149_000, 140_003, 140_001] {
        points[24 * record..24 * record + 8].copy_from_slice(&(-7.0 - record as f64).to_le_bytes());
    }
    fs::write(folder.join("q.f64"), points).unwrap();
    for memory in ["6MiB", "8MiB", "1GiB"] {
        let args = format!("verify p.tiles --against q.f64 --dims 3 --memory {memory}");
        let error = fails(folder, 1, &args);
        assert!(error.contains("record 140001 at (-140008, "), "{memory}: {error}");
    }
}

/// The file is larger than the memory of each command. Its tiles have the default size.
#[test]
fn peak_memory_stays_near_the_limit() {
    const MEMORY: u64 = 32 * MEBIBYTE;
    let scratch = scratch(1_200_000, 32_768);
    let folder = scratch.path();
    assert!(fs::metadata(folder.join("p.tiles")).unwrap().len() > 64 * MEBIBYTE);
    for args in [
        "digest --recompute p.tiles",
        "verify --deep p.tiles",
        "verify p.tiles --against p.f64 --dims 3",
        "export p.tiles -o o.ply",
        "export p.tiles -o o.geojson",
        "inspect p.tiles --plot o.png",
    ] {
        let output = json(folder, &format!("{args} --memory 32MiB"));
        let peak = output.get("plot").unwrap_or(&output)["peak_memory_bytes"].as_u64();
        // Unknown on systems without /proc.
        if let Some(peak) = peak {
            assert!(peak <= MEMORY + 32 * MEBIBYTE, "{args}: {} MiB", peak / MEBIBYTE);
        }
    }
}

#[test]
fn too_little_memory_is_an_error_that_names_the_need() {
    let scratch = scratch(60_000, 30_000);
    let folder = scratch.path();
    let before: Vec<_> = fs::read_dir(folder).unwrap().collect();
    for args in [
        "digest --recompute p.tiles",
        "verify --deep p.tiles",
        "verify p.tiles --against p.f64 --dims 3",
        "export p.tiles -o o.ply",
        "export p.tiles -o o.geojson",
        "inspect p.tiles --plot o.svg",
    ] {
        let error = fails(folder, 1, &format!("{args} --memory 1MiB"));
        assert!(
            error.contains("MiB of memory, but only 1 MiB are allowed"),
            "{args}: {error}"
        );
        assert!(error.contains("p.tiles: this needs at least "), "{args}: {error}");
    }
    assert_eq!(fs::read_dir(folder).unwrap().count(), before.len());
}

#[test]
fn verbose_prints_how_memory_is_divided() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    json(folder, "generate uniform -n 200000 --seed 1 -o p.f64");
    let log = |flags: &str, memory: &str| {
        let args = format!("build p.f64 -o {memory}.tiles --force --threads 1 --memory {memory} {flags}");
        let output = tiletool(folder, args.trim_end()).output().unwrap();
        assert!(output.status.success(), "{args}");
        String::from_utf8(output.stderr).unwrap()
    };
    for (memory, of_runs) in [("64MiB", " 8 for runs"), ("256MiB", " 32 for runs")] {
        let text = log("-v", memory);
        let line = text
            .lines()
            .find(|line| line.contains("MiB in total"))
            .unwrap_or_default();
        assert!(
            line.contains(&memory.replace("MiB", " MiB in total"))
                && line.contains(of_runs)
                && line.contains("1 threads"),
            "{text}"
        );
    }
    assert!(!log("", "64MiB").contains("MiB in total"));
}

#[test]
fn warnings_are_lines_and_the_environment_asks_for_more() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    json(folder, "generate uniform -n 200000 --seed 1 -o p.f64");
    let log = |flags: &str, choice: &str| {
        let args = format!("build p.f64 -o p.tiles --quiet --threads 1 --memory 3MiB --tile-vertices 500 {flags}");
        let output = tiletool(folder, &args).env("RUST_LOG", choice).output().unwrap();
        assert!(output.status.success(), "{choice}");
        String::from_utf8(output.stderr).unwrap()
    };
    // Plans tasks, and removes a file that a resumed build needs.
    let lose_a_run = || {
        assert_eq!(log("--force --tasks", ""), "");
        let found = fs::read_dir(folder.join("p.tiles.partial")).unwrap();
        let mut names = found.map(|entry| entry.unwrap().path());
        let run = names.find(|path| path.to_str().unwrap().contains("/run-")).unwrap();
        fs::remove_file(&run).unwrap();
        run.file_name().unwrap().to_str().unwrap().to_owned()
    };
    let is_warning = |line: &str, run: &str| {
        let named = line.strip_prefix("warning: lost or cut short, so the build cannot be resumed; path: ");
        named.is_some_and(|path| path.ends_with(&format!("p.tiles.partial/{run}")))
    };
    let run = lose_a_run();
    let text = log("--resume", "");
    assert!(is_warning(text.trim_end(), &run), "{text}");
    lose_a_run();
    assert_eq!(log("--resume --force", "error"), "");
    let run = lose_a_run();
    let text = log("--resume --force", "delaunay_tiles=loud");
    let (ignored, warning) = text.trim_end().split_once('\n').unwrap_or_default();
    assert!(
        ignored.starts_with("warning: RUST_LOG=delaunay_tiles=loud is ignored: "),
        "{text}"
    );
    assert!(is_warning(warning, &run), "{text}");

    let asked = log("--force", "delaunay_tiles::pipeline=info");
    assert!(asked.contains("MiB in total"), "{asked}");
    let asked = log("--force -v", "error");
    assert!(asked.contains("MiB in total"), "{asked}");
}
