//! `tiletool build --tasks=inputs`, `tiletool task --input`: inputs that several processes distribute, of
//! which some are killed, give the file of one build.

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use crate::resume::{scratch, write_lines};
use crate::support::{fails, json, kill_after, names, run, tiletool};

/// 400 000 points need 8 MB, so with 6 MB there are several blocks.
const BUILD: &str = "build a.f64 b.f64 c.f64 d.f64 --walls walls.csv --obstacles houses.geojson --sites sites.csv \
                     --crossings split -o p.tiles --memory 6MB --tile-vertices 4000 --threads 2";

/// Returns a folder with points in four files, the third of which is empty, and lines.
fn folder() -> tempfile::TempDir {
    let scratch = scratch();
    let folder = scratch.path();
    write_lines(folder);
    let points = fs::read(folder.join("p.f64")).unwrap();
    let (first, rest) = points.split_at(16 * 90_001);
    let (second, last) = rest.split_at(16 * 200_000);
    for (name, points) in [("a", first), ("b", second), ("c", &[]), ("d", last)] {
        fs::write(folder.join(name).with_extension("f64"), points).unwrap();
    }
    fs::remove_file(folder.join("p.f64")).unwrap();
    scratch
}

fn whole(folder: &Path, options: &str) -> serde_json::Value {
    let whole = BUILD.replace("-o p.tiles --memory 6MB", "-o whole.tiles --memory 1GB");
    json(folder, &format!("{whole}{options} --json"))
}

#[test]
fn inputs_that_processes_distribute_some_of_them_killed_give_the_triangles_of_one_build() {
    let scratch = folder();
    let folder = scratch.path();
    // Points are counted over all inputs.
    let build = format!("{BUILD} --every 2");
    let told = run(folder, &format!("{build} --tasks=inputs"));
    assert!(
        told.starts_with("p.tiles: 4 inputs of 400 000 records in all, "),
        "{told}"
    );
    assert!(
        told.contains("4 left: 0-3\n") && told.contains("tiletool task p.tiles --input 0\n"),
        "{told}"
    );
    assert_eq!(run(folder, "task p.tiles"), told);
    for (input, micros) in [(0, 3000), (1, 20_000), (1, 60_000), (0, 40_000)] {
        let task = format!("task p.tiles --input {input}");
        kill_after(tiletool(folder, &task), Duration::from_micros(micros));
    }
    // Each by two processes at the same time.
    for input in [1, 2, 0] {
        let task = format!("task p.tiles --input {input}");
        let twice = [(); 2].map(|()| {
            let mut command = tiletool(folder, &task);
            command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
        });
        twice
            .into_iter()
            .for_each(|mut child| assert!(child.wait().unwrap().success()));
    }
    let list = json(folder, "task p.tiles --json");
    let inputs = list["inputs"].as_array().unwrap();
    let are_done: Vec<bool> = inputs.iter().map(|input| input["is_done"].as_bool().unwrap()).collect();
    assert_eq!(are_done, [true, true, true, false]);
    assert!(inputs[1]["name"].as_str().unwrap().ends_with("b.f64"), "{list}");
    // What is left, the build distributes itself.
    run(folder, &format!("{build} --tasks --resume --quiet"));
    run(folder, "task p.tiles --block 1 --quiet");
    let summary = json(folder, &format!("{build} --resume --json"));
    let at_once = whole(folder, " --every 2");
    for same in [
        "records",
        "filtered",
        "segments",
        "vertices",
        "crossings",
        "sites",
        "notes",
        "hole_triangles",
        "input_bytes",
    ] {
        assert_eq!(summary[same], at_once[same], "{same}");
    }
    let digest = |file: &str| run(folder, &format!("digest --recompute {file}"));
    assert_eq!(digest("p.tiles"), digest("whole.tiles"));
    let sources = |file: &str| json(folder, &format!("inspect {file} --json"))["sources"].clone();
    assert_eq!(sources("p.tiles"), sources("whole.tiles"));
    assert!(!folder.join("p.tiles.partial").exists());
}

/// Without any task, one command after the other gives the file.
#[test]
fn a_build_distributes_the_inputs_that_are_left() {
    let scratch = folder();
    let folder = scratch.path();
    assert_eq!(run(folder, &format!("{BUILD} --tasks=inputs --quiet")), "");
    let text = fails(folder, 1, &format!("{BUILD} --tasks=inputs"));
    assert!(text.contains("holds the work of an interrupted build"), "{text}");
    run(folder, &format!("{BUILD} --tasks=inputs --resume --quiet"));
    let summary = json(folder, &format!("{BUILD} --resume --json"));
    assert_eq!(summary["vertices"], whole(folder, "")["vertices"]);
    let digest = |file: &str| run(folder, &format!("digest --recompute {file}"));
    assert_eq!(digest("p.tiles"), digest("whole.tiles"));
    // Points that fit into memory make no tasks.
    let fits = BUILD.replace("-o p.tiles --memory 6MB", "-o fits.tiles --memory 1GB");
    let built = run(folder, &format!("{fits} --tasks=inputs"));
    assert!(
        built.starts_with("fits.tiles: ") && built.contains(" triangles"),
        "{built}"
    );
    assert!(names(folder).contains(&"fits.tiles".to_owned()));
}

#[test]
fn what_input_tasks_cannot_do_is_refused() {
    let scratch = folder();
    let folder = scratch.path();
    fs::write(folder.join("t.csv"), "0,0\n1,0\n0,1\n").unwrap();
    let text = fails(folder, 1, "build a.f64 t.csv -o p.tiles --memory 6MB --tasks=inputs");
    assert!(text.contains("t.csv does not say how many records it has"), "{text}");
    let text = fails(
        folder,
        1,
        "build a.f64 -o s3://maps/p.tiles.parts --memory 6MB --tasks=inputs",
    );
    assert!(text.contains("share the folder"), "{text}");
    assert!(
        !names(folder).iter().any(|name| name.ends_with(".partial")),
        "{:?}",
        names(folder)
    );
    run(folder, &format!("{BUILD} --tasks=inputs --quiet"));
    let text = fails(folder, 1, "task p.tiles --input 4");
    assert!(
        text.contains("there is no input 4; the build has 4, numbered from 0"),
        "{text}"
    );
    let text = fails(folder, 1, "task p.tiles --input 0 --memory 5MB");
    assert!(text.contains("a task of this build needs"), "{text}");
    let text = fails(folder, 1, "task p.tiles --block 0");
    assert!(text.contains("there are no blocks yet"), "{text}");
    // Changed after it was planned.
    run(folder, "task p.tiles --input 0 --quiet");
    fs::write(folder.join("b.f64"), [0; 160]).unwrap();
    let text = fails(folder, 1, "task p.tiles --input 1");
    assert!(text.contains("has changed since the tasks were planned"), "{text}");
    let text = fails(folder, 1, &format!("{BUILD} --tasks --resume"));
    assert!(text.contains("holds the work of a build with other inputs"), "{text}");
}
