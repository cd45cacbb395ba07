//! `tiletool build --compress`: what it prints, and that every other command reads such files.

use std::fs;
use std::process::Stdio;

use crate::support::{data, fails, json, run, tiletool, wait_for_a_block};

/// Fields of the reports, as numbers.
fn number(report: &serde_json::Value, key: &str) -> u64 {
    report[key].as_u64().unwrap_or_else(|| panic!("{key} in {report}"))
}

#[test]
fn a_compressed_file_is_smaller_and_every_command_answers_alike() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let points = data("las/32-1-472-150-76.laz");
    run(folder, &format!("build {points} -o raw.tiles --tile-vertices 500"));
    let text = run(
        folder,
        &format!("build {points} -o c.tiles --tile-vertices 500 --compress"),
    );
    assert!(text.contains("of tiles before compression"), "{text}");
    let summary = json(
        folder,
        &format!("build {points} -o c.tiles --compress --tile-vertices 500 --force --json"),
    );
    let [raw, compressed] = ["raw", "c"].map(|name| json(folder, &format!("inspect {name}.tiles --json --tiles")));
    let parts = |report: &serde_json::Value| number(report, "core_bytes") + number(report, "border_bytes");
    let raw_parts = |report: &serde_json::Value| number(report, "raw_core_bytes") + number(report, "raw_border_bytes");
    assert_eq!([parts(&raw), raw_parts(&raw)], [number(&summary, "raw_tile_bytes"); 2]);
    assert_eq!(raw_parts(&compressed), parts(&raw));
    assert!(2 * parts(&compressed) < parts(&raw), "{compressed}");
    let tile = &compressed["tile_list"][0];
    assert_eq!(
        (&tile["core_codec"], &tile["border_codec"]),
        (&"zstd".into(), &"zstd".into())
    );
    assert_eq!(
        number(tile, "core_raw_bytes"),
        number(&raw["tile_list"][0], "core_bytes")
    );
    assert!(run(folder, "inspect c.tiles").contains("tiles are compressed to "));
    assert!(!run(folder, "inspect raw.tiles").contains("compressed"));
    assert!(run(folder, "inspect c.tiles --tiles").contains("raw bytes"));
    assert!(run(folder, "inspect c.tiles --tile 0").contains(" raw) at "));

    for command in ["digest", "export", "locate"] {
        let [raw, compressed] = ["raw", "c"].map(|name| match command {
            "export" => {
                run(folder, &format!("export {name}.tiles -o {name}.obj"));
                fs::read_to_string(folder.join(format!("{name}.obj"))).unwrap()
            }
            "digest" => run(folder, &format!("digest {name}.tiles")),
            _ => run(folder, &format!("inspect {name}.tiles --tile 1 --json"))
                .split("vertex_list")
                .nth(1)
                .unwrap()
                .to_owned(),
        });
        assert!(raw == compressed, "{command}");
    }
    run(folder, &format!("verify --deep c.tiles --against {points}"));
    for name in ["raw", "c"] {
        let decoded = json(folder, &format!("bench decode {name}.tiles --rounds 1 --json"));
        assert_eq!(number(&decoded, "raw_bytes"), parts(&raw));
        assert!(decoded["gb_per_s"].as_f64().unwrap() > 0.0);
    }
}

#[test]
fn an_interrupted_compressed_build_resumes_to_the_same_bytes_and_as_no_other() {
    const BUILD: &str = "build p.f64 -o p.tiles --memory 8MB --tile-vertices 4000 --threads 2";
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    run(folder, "generate kuzmin -n 400000 --seed 7 -o p.f64");
    run(
        folder,
        "build p.f64 -o whole.tiles --memory 8MB --tile-vertices 4000 --threads 1 --compress",
    );
    let mut child = tiletool(folder, &format!("{BUILD} --compress"));
    let mut child = child.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    wait_for_a_block(folder, &mut child);
    let _ = child.kill();
    child.wait().unwrap();
    if folder.join("p.tiles").exists() {
        println!("the build ended before it could be interrupted");
        return;
    }
    let other = fails(folder, 1, &format!("{BUILD} --resume"));
    assert!(other.contains("compress: true"), "{other}");
    let summary = json(folder, &format!("{BUILD} --compress --resume --json"));
    assert!(number(&summary, "resumed_blocks") > 0);
    let [resumed, whole] = ["p.tiles", "whole.tiles"].map(|name| fs::read(folder.join(name)).unwrap());
    assert!(resumed == whole, "the bytes differ");
}
