//! `tiletool build --resume`: builds that are killed, interrupted or out of disk space can be
//! resumed, and give the same triangles.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::support::cases::cases;
use crate::support::{errors, fails, json, kill_after, names, run, tiletool, wait_for_a_block};
use serde_json::Value;

fn start(folder: &Path, args: &str) -> Child {
    let mut command = tiletool(folder, args);
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// 400 000 points need 8 MB, so with 6 MB they are spilled.
const BUILD: &str = "build p.f64 -o p.tiles --memory 6MB --tile-vertices 4000 --threads 2";

pub fn scratch() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), "generate kuzmin -n 400000 --seed 7 -o p.f64");
    folder
}

/// Writes walls across all blocks, obstacles and sites beside the points of [`scratch`].
pub fn write_lines(folder: &Path) {
    let spiral = |i: u32| {
        let (angle, radius) = (0.07 * f64::from(i), 0.001 * f64::from(i + 1));
        format!("{},{}", radius * angle.cos(), radius * angle.sin())
    };
    let walls: String = (0..900).map(|i| format!("{},{}\n", spiral(i), spiral(i + 1))).collect();
    fs::write(folder.join("walls.csv"), walls).unwrap();
    let corners = |i: u32| (0.05 * f64::from(i % 20) - 0.5123, 0.05 * f64::from(i / 20) - 0.5078);
    let house = |i: u32| {
        let (x, y) = corners(i);
        let (right, top) = (x + 0.0003, y + 0.0002);
        format!(
            r#"{{"type":"Feature","properties":null,"geometry":{{"type":"Polygon","coordinates":[[[{x},{y}],[{right},{y}],[{right},{top}],[{x},{top}],[{x},{y}]]]}}}}"#
        )
    };
    let houses: Vec<String> = (0..400).map(house).collect();
    let houses = format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, houses.join(","));
    fs::write(folder.join("houses.geojson"), houses).unwrap();
    let site = |i: u32| {
        let (x, y) = corners(i);
        format!("{},{},shop {i}\n", x + 0.0001, y + 0.0001)
    };
    fs::write(folder.join("sites.csv"), (0..400).map(site).collect::<String>()).unwrap();
}

#[test]
fn a_build_killed_at_any_moment_resumes_to_the_same_bytes() {
    killed_at_any_moment("build p.f64");
}

/// Walls and houses cross, and are split.
#[test]
fn a_build_with_lines_and_sites_killed_at_any_moment_resumes_to_the_same_bytes() {
    killed_at_any_moment(
        "build p.f64 --walls walls.csv --obstacles houses.geojson --sites sites.csv --crossings split",
    );
}

/// Builds from the points of [`scratch`] and the lines beside them, kills the build at many
/// moments, and compares what a resumed build makes with what one does that was not killed.
fn killed_at_any_moment(command: &str) {
    let scratch = scratch();
    let folder = scratch.path();
    write_lines(folder);
    run(
        folder,
        &format!("{command} -o whole.tiles --memory 1GB --tile-vertices 4000"),
    );
    let digest = run(folder, "digest --recompute whole.tiles");
    let build = format!("{command} -o p.tiles --memory 6MB --tile-vertices 4000 --threads 2");
    let began = Instant::now();
    let undisturbed = json(folder, &format!("{build} --json"));
    let whole = began.elapsed();
    assert_eq!(run(folder, "digest --recompute p.tiles"), digest);
    let bytes = fs::read(folder.join("p.tiles")).unwrap();

    let mut random = 9u64;
    let mut moment = || {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        whole.mul_f64((random >> 33) as f64 / (1u64 << 31) as f64)
    };
    // Random moments may all come before the first block is done or after the last.
    killed_after_a_block(folder, &build);
    assert!(fs::read(folder.join("p.tiles")).unwrap() == bytes);
    let mut kills = 0;
    while kills < cases(200) {
        fs::remove_file(folder.join("p.tiles")).unwrap();
        // The build is killed up to three times before it may finish.
        for _ in 0..3 {
            kill_after(tiletool(folder, &format!("{build} --resume --quiet")), moment());
            kills += 1;
            if folder.join("p.tiles").exists() {
                break;
            }
        }
        if !folder.join("p.tiles").exists() {
            let summary = json(folder, &format!("{build} --resume --json"));
            for same in [
                "points",
                "records",
                "segments",
                "vertices",
                "crossings",
                "sites",
                "notes",
            ] {
                assert_eq!(summary[same], undisturbed[same], "{same}");
            }
            assert!(!folder.join("p.tiles.partial").exists());
        }
        assert!(
            fs::read(folder.join("p.tiles")).unwrap() == bytes,
            "the file differs after {kills} kills"
        );
    }
    assert_eq!(run(folder, "digest --recompute p.tiles"), digest);
}

/// Replaces `p.tiles` by what a resumed build makes that was killed with a block done, and asserts that
/// it goes on from that block. The build may end before it is killed, but not each time.
fn killed_after_a_block(folder: &Path, build: &str) {
    for _ in 0..20 {
        fs::remove_file(folder.join("p.tiles")).unwrap();
        let mut child = start(folder, &format!("{build} --resume --quiet"));
        let is_there = wait_for_a_block(folder, &mut child);
        let _ = child.kill();
        child.wait().unwrap();
        if is_there && !folder.join("p.tiles").exists() {
            let summary = json(folder, &format!("{build} --resume --json"));
            assert!(summary["resumed_blocks"].as_u64().unwrap() > 0, "{summary}");
            return;
        }
    }
    panic!("the build could not be killed before its end");
}

/// A build goes on only with the lines and sites that it had.
#[test]
fn other_lines_are_another_build() {
    let scratch = scratch();
    let folder = scratch.path();
    write_lines(folder);
    let build =
        |lines: &str| format!("build p.f64{lines} -o p.tiles --memory 6MB --tile-vertices 4000 --crossings split");
    let lines = " --walls walls.csv --obstacles houses.geojson --sites sites.csv";
    let mut child = start(folder, &build(lines));
    if !wait_for_a_block(folder, &mut child) {
        println!("the build ended before it could be interrupted");
        return;
    }
    child.kill().unwrap();
    child.wait().unwrap();
    fs::write(folder.join("others.csv"), "0,0,1,1\n").unwrap();
    for (others, what) in [
        ("", "walls"),
        (
            " --walls others.csv --obstacles houses.geojson --sites sites.csv",
            "walls",
        ),
        (
            " --segments walls.csv --obstacles houses.geojson --sites sites.csv",
            "walls",
        ),
        (" --walls walls.csv --obstacles houses.geojson", "sites"),
    ] {
        let error = fails(folder, 1, &format!("{} --resume", build(others)));
        assert!(
            error.contains("other inputs or options") && error.contains(what),
            "{error}"
        );
    }
    // Changed meanwhile.
    let sites = fs::read(folder.join("sites.csv")).unwrap();
    fs::write(folder.join("sites.csv"), [&sites[..], b"0.1,0.1,new\n"].concat()).unwrap();
    let error = fails(folder, 1, &format!("{} --resume", build(lines)));
    assert!(
        error.contains("other inputs or options") && error.contains("sites.csv"),
        "{error}"
    );
    run(folder, &format!("{} --force", build(lines)));
}

#[test]
fn ctrl_c_keeps_the_work_and_says_how_to_resume() {
    keeps_the_work("-INT");
}

#[test]
fn sigterm_keeps_the_work_and_says_how_to_resume() {
    keeps_the_work("-TERM");
}

fn keeps_the_work(signal: &str) {
    let scratch = scratch();
    let folder = scratch.path();
    let mut child = start(folder, BUILD);
    if wait_for_a_block(folder, &mut child) {
        let pid = child.id().to_string();
        assert!(Command::new("kill").args([signal, &pid]).status().unwrap().success());
    }
    let output = child.wait_with_output().unwrap();
    if output.status.success() {
        println!("the build ended before it could be interrupted");
        return;
    }
    assert_eq!(output.status.code(), Some(1));
    let message = errors(&output);
    assert!(
        message.contains("p.tiles.partial") && message.contains("--resume"),
        "{message}"
    );
    assert!(!folder.join("p.tiles").exists());

    // Other options or another input are rejected.
    let other = fails(
        folder,
        1,
        "build p.f64 -o p.tiles --resume --tile-vertices 5000 --memory 6MB",
    );
    assert!(other.contains("tile vertices: 4000"), "{other}");
    let modified = fs::metadata(folder.join("p.f64")).unwrap().modified().unwrap();
    let file = fs::File::options().append(true).open(folder.join("p.f64")).unwrap();
    file.set_modified(modified + Duration::from_secs(5)).unwrap();
    let other = fails(folder, 1, &format!("{BUILD} --resume"));
    assert!(other.contains("p.f64"), "{other}");
    file.set_modified(modified).unwrap();

    // Work that could be resumed is not removed by accident.
    let work = names(&folder.join("p.tiles.partial"));
    for rerun in [BUILD, "build p.f64 -o p.tiles", "build p.f64 --walls w.csv -o p.tiles"] {
        fs::write(folder.join("w.csv"), "0,0,1,1\n").unwrap();
        let kept = fails(folder, 1, rerun);
        for part in [
            "p.tiles.partial holds the work of an interrupted build, ",
            "--resume",
            "--force",
        ] {
            assert!(kept.contains(part), "{rerun}: {kept}");
        }
        assert_eq!(names(&folder.join("p.tiles.partial")), work, "{rerun}");
    }

    run(folder, &format!("{BUILD} --resume"));
    run(folder, "verify --deep p.tiles --against p.f64");
    assert!(!folder.join("p.tiles.partial").exists());
}

#[test]
fn force_discards_the_work_of_an_interrupted_build_and_says_so() {
    let scratch = scratch();
    let folder = scratch.path();
    let mut child = start(folder, BUILD);
    if !wait_for_a_block(folder, &mut child) {
        println!("the build ended before it could be interrupted");
        return;
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(folder.join("p.tiles.partial/plan").exists());
    let output = tiletool(folder, &format!("{BUILD} --force")).output().unwrap();
    let message = errors(&output);
    assert!(output.status.success(), "{message}");
    assert!(
        message.contains("note: the work of an interrupted build is discarded"),
        "{message}"
    );
    assert_eq!(names(folder), ["p.f64", "p.tiles"]);
    let output = tiletool(folder, &format!("{BUILD} --force")).output().unwrap();
    assert!(errors(&output).is_empty(), "{}", errors(&output));
}

#[test]
fn standard_input_cannot_be_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let error = fails(folder.path(), 1, "build - -o p.tiles --resume");
    assert!(error.contains("standard input cannot"), "{error}");
    assert_eq!(names(folder.path()), [""; 0]);
}

/// The disk fills up while blocks are triangulated, if this process may mount one.
#[test]
fn a_build_that_ran_out_of_disk_space_can_be_resumed() {
    let scratch = scratch();
    let folder = scratch.path();
    let disk = folder.join("disk");
    fs::create_dir(&disk).unwrap();
    let mount = |args: &[&str]| {
        Command::new(args[0])
            .args(&args[1..])
            .arg(&disk)
            .output()
            .is_ok_and(|o| o.status.success())
    };
    if !mount(&["mount", "-t", "tmpfs", "-o", "size=40m", "tmpfs"]) {
        println!("skipped: no tmpfs can be mounted here");
        return;
    }
    let build = BUILD.replace("-o p.tiles", "-o disk/p.tiles");
    let mut child = start(folder, &build);
    wait_for_a_block(&disk, &mut child);
    // This acts as another program that fills the disk.
    let fill = fs::write(disk.join("other"), vec![1u8; 40 << 20]);
    let output = child.wait_with_output().unwrap();
    let message = errors(&output);
    let kept = disk.join("p.tiles.partial").exists();
    fs::remove_file(disk.join("other")).unwrap();
    let resumed = tiletool(folder, &format!("{build} --resume --json")).output().unwrap();
    let verified = tiletool(folder, "verify --deep disk/p.tiles --against p.f64")
        .output()
        .unwrap();
    assert!(mount(&["umount"]));
    assert!(fill.is_err(), "the disk was not full");
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(kept && message.contains("--resume"), "{message}");
    assert!(message.contains("No space left"), "{message}");
    assert!(resumed.status.success(), "{}", errors(&resumed));
    let summary: Value = serde_json::from_slice(&resumed.stdout).unwrap();
    assert!(summary["resumed_blocks"].as_u64().unwrap() > 0);
    assert!(verified.status.success(), "{}", errors(&verified));
}
