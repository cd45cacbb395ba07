//! `tiletool export` to PMTiles from the command line: its output, and the files that it leaves.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};
use tempfile::TempDir;

use crate::support::{complaint, fails, json, names, run, tiletool};

/// Returns a folder with `a.tiles`, which has z and a reference system, and `b.tiles`, which has none.
fn scratch() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let points = (0..400).map(|i| format!("{},{},{}\n", i % 20, f64::from(i / 20) + f64::from(i % 7) / 16.0, i % 9));
    fs::write(folder.path().join("p.csv"), points.collect::<String>()).unwrap();
    fs::write(folder.path().join("flat.csv"), "0,0\n4,0\n0,4\n4,4\n2,2\n").unwrap();
    let path = folder.path();
    run(
        path,
        "build p.csv --dims 3 --crs EPSG:3857 -o a.tiles --tile-vertices 100 --quiet",
    );
    run(path, "build flat.csv -o b.tiles --quiet");
    folder
}

#[test]
fn the_summary_says_what_was_written_and_the_bytes_do_not_depend_on_threads_or_memory() {
    let folder = scratch();
    let path = folder.path();
    let summary = json(path, "export a.tiles -o a.pmtiles --zooms 17..20 --json");
    let bytes = fs::read(path.join("a.pmtiles")).unwrap();
    assert!(bytes.starts_with(b"PMTiles\x03"));
    assert_eq!(summary["bytes"], bytes.len() as u64);
    assert_eq!(
        (&summary["layer"], &summary["grid"]),
        (&"shade".into(), &"WebMercatorQuad".into())
    );
    assert_eq!(summary["zooms"], serde_json::json!([17, 20]));
    // The header has the number of tiles.
    assert_eq!(
        summary["map_tiles"],
        u64::from_le_bytes(bytes[72..80].try_into().unwrap())
    );
    for more in ["--at-once 1", "--at-once 9", "--memory 1MiB"] {
        run(path, &format!("export a.tiles -o again.pmtiles --zooms 17..20 {more}"));
        assert!(fs::read(path.join("again.pmtiles")).unwrap() == bytes, "{more}");
    }
}

#[test]
fn a_file_without_a_reference_system_has_the_native_grid_and_a_note() {
    let folder = scratch();
    let path = folder.path();
    let summary = json(path, "export b.tiles -o x.dat --format pmtiles --layer mesh --json");
    assert_eq!(summary["grid"], "native");
    assert!(
        summary["notes"][0]
            .as_str()
            .unwrap()
            .contains("names no coordinate reference system")
    );
    let error = fails(path, 1, "export b.tiles -o y.pmtiles --grid WebMercatorQuad");
    assert!(
        error.contains("b.tiles") && error.contains("names no coordinate reference system"),
        "{error}"
    );
}

#[test]
fn what_cannot_be_exported_is_said_and_leaves_no_file() {
    let folder = scratch();
    let path = folder.path();
    fs::write(path.join("old.pmtiles"), "old").unwrap();
    let before = names(path);
    for (code, args, expected) in [
        (1, "b.tiles --layer terrarium", "no layer terrarium"),
        (1, "a.tiles --zooms 0..26 --max-tiles 1000", "map tiles or more"),
        (
            1,
            "a.tiles --zooms 0..3 --grid native --memory 20KiB",
            "give --memory 1MiB",
        ),
        (
            1,
            "a.tiles --grid native --zooms 0 --max-picture-tiles 1",
            "`--max-picture-tiles`",
        ),
        (1, "a.tiles --zooms 0", "the file has nothing"),
        (2, "a.tiles --layer hills", "shade, terrarium or mesh"),
        (2, "a.tiles --grid mercator", "native or WebMercatorQuad"),
        (2, "a.tiles --zooms 9..3", "give 3..9"),
        (2, "a.tiles --zooms 0..27", "from 0 to 26"),
        (2, "a.tiles --what vertices", "--what is not for pmtiles"),
        (2, "a.tiles --resolution 1", "--resolution is not for pmtiles"),
        (2, "a.tiles --crs EPSG:4326", "--crs is for --clip"),
    ] {
        let error = fails(path, code, &format!("export {args} -o old.pmtiles"));
        assert!(error.contains(expected), "{args}: {error}");
    }
    let error = fails(path, 2, "export a.tiles -o - --format pmtiles");
    assert!(error.contains("standard output"), "{error}");
    let error = fails(path, 2, "export a.tiles -o a.ply --layer mesh");
    assert!(error.contains("--layer is for pmtiles, and not for ply"), "{error}");
    assert_eq!(names(path), before);
    assert_eq!(fs::read(path.join("old.pmtiles")).unwrap(), b"old");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_and_a_pipe_are_errors() {
    let folder = scratch();
    let path = folder.path();
    let args = "export a.tiles --format pmtiles --grid native --zooms 0..2 -o";
    let error = fails(path, 1, &format!("{args} /dev/full"));
    assert!(
        error.contains("/dev/full") && error.contains("No space left"),
        "{error}"
    );
    assert!(
        Command::new("mkfifo")
            .arg(path.join("pipe"))
            .status()
            .unwrap()
            .success()
    );
    let mut reader = Command::new("cat")
        .arg(path.join("pipe"))
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let error = complaint(tiletool(path, &format!("{args} pipe")), 1);
    reader.wait().unwrap();
    assert!(error.contains("pipe") && error.contains("seek"), "{error}");
}

#[test]
fn an_interrupted_export_leaves_no_file() {
    let folder = scratch();
    let path: &Path = folder.path();
    let before = names(path);
    let mut command = tiletool(
        path,
        "export a.tiles -o x.pmtiles --grid native --zooms 0..9 --at-once 1",
    );
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    while !path.join(".x.pmtiles.partial").exists() {
        std::thread::sleep(Duration::from_millis(1));
    }
    kill_process(Pid::from_child(&child), Signal::INT).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(1));
    assert_eq!(names(path), before);
}
