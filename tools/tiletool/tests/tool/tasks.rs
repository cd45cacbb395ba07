//! `tiletool build --tasks`, `tiletool task`: blocks that several processes conquer, of which some are
//! killed, give the triangles of one build.

use std::fs;
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::Duration;

use crate::resume::{scratch, write_lines};
use crate::support::cases::cases;
use crate::support::{errors, fails, json, kill_after, names, run, tiletool};

/// 400 000 points need 8 MB, so with 6 MB there are several blocks.
const BUILD: &str = "build p.f64 --walls walls.csv --obstacles houses.geojson --sites sites.csv --crossings split \
                     -o p.tiles --memory 6MB --tile-vertices 4000 --threads 2";

fn planned() -> tempfile::TempDir {
    let scratch = scratch();
    write_lines(scratch.path());
    run(scratch.path(), &format!("{BUILD} --tasks --quiet"));
    scratch
}

fn blocks(folder: &Path) -> usize {
    json(folder, "task p.tiles --json")["blocks"].as_array().unwrap().len()
}

fn start(folder: &Path, args: &str) -> Child {
    let mut command = tiletool(folder, args);
    command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

#[test]
fn blocks_that_processes_conquer_some_of_them_killed_give_the_triangles_of_one_build() {
    let scratch = planned();
    let folder = scratch.path();
    let count = blocks(folder);
    assert!(count > 3, "{count}");
    let mut random = 9u64;
    let mut up_to = |most: u64| {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) % most
    };
    for _ in 0..cases(100) {
        let block = up_to(count as u64 - 1);
        let task = format!("task p.tiles --block {block} --threads 2");
        kill_after(tiletool(folder, &task), Duration::from_micros(up_to(200_000)));
    }
    // All but the last, from the end, each by two processes at the same time.
    for block in (0..count - 1).rev() {
        let task = format!("task p.tiles --block {block} --threads 2");
        let twice = [start(folder, &task), start(folder, &task)];
        twice
            .into_iter()
            .for_each(|mut child| assert!(child.wait().unwrap().success()));
    }
    let list = run(folder, "task p.tiles");
    assert!(list.contains(&format!("--block {}", count - 1)), "{list}");
    let again = json(folder, "task p.tiles --block 0 --json");
    assert_eq!(again["blocks"][0]["was_done"], true, "{again}");
    let summary = json(folder, &format!("{BUILD} --resume --json"));
    assert_eq!(summary["resumed_blocks"], count);
    assert!(!folder.join("p.tiles.partial").exists());
    run(folder, "verify --deep p.tiles");
    let whole = BUILD.replace("-o p.tiles --memory 6MB", "-o whole.tiles --memory 1GB");
    let whole = json(folder, &format!("{whole} --json"));
    for same in [
        "records",
        "segments",
        "vertices",
        "crossings",
        "sites",
        "notes",
        "hole_triangles",
    ] {
        assert_eq!(summary[same], whole[same], "{same}");
    }
    let digest = |file: &str| run(folder, &format!("digest --recompute {file}"));
    assert_eq!(digest("p.tiles"), digest("whole.tiles"));
}

#[test]
fn a_build_that_leaves_tasks_says_what_comes_next() {
    let scratch = scratch();
    let folder = scratch.path();
    let build = "build p.f64 -o p.tiles --memory 6MB --tile-vertices 4000 --threads 2";
    let told = run(folder, &format!("{build} --tasks"));
    let count = blocks(folder);
    assert!(told.starts_with(&format!("p.tiles: {count} blocks of ")), "{told}");
    assert!(told.contains(" points in all, each conquered with 5.7 MiB\n"), "{told}");
    assert!(told.contains(&format!("{count} left: 0-{}\n", count - 1)), "{told}");
    assert!(told.contains("tiletool task p.tiles --block 0\n"), "{told}");
    assert_eq!(run(folder, "task p.tiles"), told);
    // It may be asked for once more, and is not begun anew unless that is wanted.
    assert_eq!(run(folder, &format!("{build} --tasks --resume")), told);
    let text = fails(folder, 1, &format!("{build} --tasks"));
    assert!(text.contains("holds the work of an interrupted build"), "{text}");
    let done = run(folder, "task p.tiles --block 1 --block 2");
    assert!(done.starts_with("block 1: ") && done.lines().count() == 2, "{done}");
    assert!(run(folder, "task p.tiles").contains(&format!("{} left: 0, 3", count - 2)));
    assert_eq!(run(folder, "task p.tiles --block 1 --quiet"), "");
    // As on a machine with other processors.
    let elsewhere = build.replace("--threads 2", "--threads 1");
    run(folder, &format!("{elsewhere} --resume --quiet"));
    assert_eq!(names(folder), ["p.f64", "p.tiles"]);
    let in_memory = json(folder, "build p.f64 -o q.tiles --memory 1GB --tasks --json");
    assert_eq!(
        (&in_memory["blocks"], &in_memory["points"]),
        (&1.into(), &400_000.into()),
        "{in_memory}"
    );
}

#[test]
fn a_task_that_cannot_be_done_says_why() {
    let scratch = planned();
    let folder = scratch.path();
    let refused = |args: &str| fails(folder, 1, args);
    let count = blocks(folder);
    let text = refused(&format!("task p.tiles --block {count}"));
    assert!(
        text.contains(&format!(
            "p.tiles: there is no block {count}; the build has {count}, numbered from 0"
        )),
        "{text}"
    );
    let text = refused("task p.tiles --block 0 --memory 5MB");
    assert!(
        text.contains("needs 6 MiB of memory, and may take 4; do it where there is more"),
        "{text}"
    );
    let text = refused("task q.tiles");
    assert!(
        text.contains("q.tiles.partial: there are no tasks; plan them first"),
        "{text}"
    );
    let text = refused("build - -o q.tiles --tasks --dims 2 --format f64");
    assert!(text.contains("standard input cannot"), "{text}");
    // Points that are lost do not give a file.
    let run_of_points = names(&folder.join("p.tiles.partial"))
        .into_iter()
        .find(|name| name.starts_with("run-"));
    let path = folder.join("p.tiles.partial").join(run_of_points.unwrap());
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let failed: Vec<String> = (0..count)
        .map(|block| {
            tiletool(folder, &format!("task p.tiles --block {block}"))
                .output()
                .unwrap()
        })
        .filter(|output| !output.status.success())
        .map(|output| errors(&output))
        .collect();
    assert!(matches!(&failed[..], [text] if text.contains("run-")), "{failed:?}");
}

#[test]
fn a_file_in_parts_is_read_as_one_file_and_not_edited() {
    let scratch = planned();
    let folder = scratch.path();
    let build = BUILD.replace("-o p.tiles ", "-o p.tiles.parts ");
    run(folder, &format!("{build} --tasks --quiet"));
    for file in ["p.tiles", "p.tiles.parts"] {
        for block in 0..blocks(folder) {
            run(folder, &format!("task {file} --block {block} --quiet"));
        }
    }
    run(folder, &format!("{BUILD} --resume --quiet"));
    run(folder, &format!("{build} --resume --quiet"));
    let digest = |file: &str| run(folder, &format!("digest --recompute {file}"));
    assert_eq!(digest("p.tiles.parts"), digest("p.tiles"));
    run(folder, "verify --deep p.tiles.parts");
    let path = "query path --from 0.1,0.1 --to 0.9,0.8";
    let of = |file: &str| run(folder, &format!("{path} {file}")).replace(file, "FILE");
    assert_eq!(of("p.tiles.parts"), of("p.tiles"));
    let text = fails(folder, 1, "insert p.tiles.parts p.f64");
    assert!(
        text.contains("a file in parts is not edited; write it into one file first"),
        "{text}"
    );
    let text = fails(folder, 1, "compact p.tiles.parts");
    assert!(text.contains("this makes one file"), "{text}");
    let text = fails(folder, 1, "build p.f64 -o q.tiles.parts --overviews");
    assert!(text.contains("a file in parts has no overviews"), "{text}");
    let text = fails(folder, 1, "build p.f64 -o s3://maps/q.tiles");
    assert!(text.contains("its name ends with .parts"), "{text}");
    run(folder, "compact p.tiles.parts -o one.tiles");
    assert_eq!(digest("one.tiles"), digest("p.tiles"));
}
