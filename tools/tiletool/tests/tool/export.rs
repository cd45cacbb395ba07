//! `tiletool export` from the command line: its output, and the files that it leaves.

use std::fs;
use std::path::Path;

use crate::support::{json, names, run};
use tempfile::TempDir;

fn fails(folder: &Path, args: &str, expected: &str) {
    ends(folder, args, 1, expected);
}

fn ends(folder: &Path, args: &str, code: i32, expected: &str) {
    let error = crate::support::fails(folder, code, args);
    assert!(error.contains(expected), "{args}: {error}");
}

/// Returns a folder with `a.tiles`: a square and its centre.
fn scratch() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.xyz"), "0 0\n4 0\n0 4\n4 4\n2 2\n").unwrap();
    run(folder.path(), "build a.xyz -o a.tiles --tile-vertices 4 --quiet");
    folder
}

#[test]
fn an_export_replaces_its_outputs() {
    let folder = scratch();
    let folder = folder.path();
    fs::write(folder.join("out.ply"), "old").unwrap();
    let printed = run(folder, "export a.tiles -o out.ply");
    assert!(printed.starts_with("out.ply: 5 vertices, 4 triangles; "), "{printed}");
    assert!(fs::read(folder.join("out.ply")).unwrap().starts_with(b"ply\n"));
    for (output, node, ele) in [
        ("b.node", "b.node", "b.ele"),
        ("c.ele", "c.node", "c.ele"),
        ("d.v2 --format node", "d.v2.node", "d.v2.ele"),
    ] {
        run(folder, &format!("export a.tiles -o {output}"));
        assert!(fs::read_to_string(folder.join(node)).unwrap().contains("\n5 2 0 0\n"));
        assert!(fs::read_to_string(folder.join(ele)).unwrap().contains("\n4 3 0\n"));
    }
    let expected = [
        "a.tiles",
        "a.xyz",
        "b.ele",
        "b.node",
        "c.ele",
        "c.node",
        "d.v2.ele",
        "d.v2.node",
        "out.ply",
    ];
    assert_eq!(names(folder), expected);
}

#[test]
fn the_json_summary_has_counts_files_and_bytes() {
    let folder = scratch();
    let mut summary = json(folder.path(), "export a.tiles -o b.node --json");
    let peak = summary.as_object_mut().unwrap().remove("peak_memory_bytes").unwrap();
    assert!(peak.as_u64().is_none_or(|peak| peak > 0));
    let length = |name| fs::metadata(folder.path().join(name)).unwrap().len();
    let bytes = length("b.node") + length("b.ele");
    let expected = serde_json::json!({"vertices": 5, "triangles": 4, "edges": 0, "files": ["b.node", "b.ele"], "bytes": bytes, "notes": []});
    assert_eq!(summary, expected);
}

#[test]
fn an_export_to_standard_output_equals_the_file() {
    let folder = scratch();
    let folder = folder.path();
    for format in ["ply", "obj", "geojson"] {
        run(folder, &format!("export a.tiles -o b.{format}"));
        let printed = run(folder, &format!("export a.tiles -o - --format {format}"));
        let written = fs::read_to_string(folder.join(format!("b.{format}"))).unwrap();
        assert!(printed == written, "{format}");
    }
    ends(folder, "export a.tiles -o -", 2, "choose a --format");
    ends(folder, "export a.tiles -o - --format node", 2, "2 files");
}

#[test]
fn a_failed_export_leaves_all_files_unchanged() {
    let folder = scratch();
    let folder = folder.path();
    fs::create_dir(folder.join("folder.ply")).unwrap();
    let before = names(folder);
    ends(
        folder,
        "export a.tiles -o b.stl",
        2,
        "b.stl: formats are ply, node (with ele), obj, glb, geojson",
    );
    ends(folder, "export a.tiles -o b.ply --format stl", 2, "formats are ply");
    fails(folder, "export none.tiles -o b.ply", "none.tiles");
    fails(folder, "export a.xyz -o b.ply", "a.xyz");
    fails(folder, "export a.tiles -o none/b.ply", "cannot create none/b.ply");
    fails(folder, "export a.tiles -o a.xyz/b.ply", "cannot create a.xyz/b.ply");
    fails(folder, "export a.tiles -o folder.ply", "folder.ply: it is a folder");
    fails(folder, "export a.tiles -o a.tiles --format ply", "the tile file itself");
    fails(folder, "export a.tiles -o ../ --format ply", "is a folder");
    assert_eq!(names(folder), before);
    // With a damaged tile, the existing output stays unchanged.
    let mut bytes = fs::read(folder.join("a.tiles")).unwrap();
    bytes[12_288 + 60] ^= 1;
    fs::write(folder.join("a.tiles"), bytes).unwrap();
    fs::write(folder.join("b.ply"), "old").unwrap();
    let before = names(folder);
    fails(folder, "export a.tiles -o b.ply", "tile 0 at byte 12288 is damaged");
    fails(
        folder,
        "export a.tiles -o c --format node",
        "tile 0 at byte 12288 is damaged",
    );
    assert_eq!(names(folder), before);
    assert_eq!(fs::read(folder.join("b.ply")).unwrap(), b"old");
}

#[cfg(target_os = "linux")]
#[test]
fn an_export_follows_links_and_writes_to_devices() {
    let folder = scratch();
    let folder = folder.path();
    fails(folder, "export a.tiles -o /dev/full --format ply", "No space left");
    run(folder, "export a.tiles -o /dev/null --format obj");
    fs::create_dir(folder.join("there")).unwrap();
    fs::write(folder.join("there/b.obj"), "old").unwrap();
    std::os::unix::fs::symlink("there/b.obj", folder.join("link.obj")).unwrap();
    run(folder, "export a.tiles -o link.obj");
    assert!(fs::symlink_metadata(folder.join("link.obj")).unwrap().is_symlink());
    assert!(fs::read_to_string(folder.join("there/b.obj")).unwrap().ends_with('\n'));
    assert_eq!(names(&folder.join("there")), ["b.obj"]);
}
