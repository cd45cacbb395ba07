//! `tiletool build --keep-edges`: existing triangulations come in with their edges.

use crate::support::{fails, json, run};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

fn formats(name: &str) -> String {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/formats");
    root.join(name).display().to_string()
}

/// Builds and verifies `out.tiles` from inputs with edges. Returns its digest.
fn built(folder: &Path, inputs: &str) -> Value {
    run(
        folder,
        &format!("build {inputs} --keep-edges -o out.tiles --force --quiet"),
    );
    run(
        folder,
        &format!(
            "verify --deep out.tiles --against {} --keep-edges",
            inputs.replace(' ', " --against ")
        ),
    );
    json(folder, "digest out.tiles --json")
}

/// Returns the parts of a digest with these names.
fn parts<'a>(digest: &'a Value, names: &[&str]) -> Vec<&'a Value> {
    names.iter().map(|name| &digest[name]).collect()
}

/// The triangles of the file are not those of Delaunay.
#[test]
fn the_triangles_of_a_mesh_stay_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let digests = ["tin.ply", "tin_ascii.ply", "tin.obj"].map(|name| built(folder, &formats(name)));
    let names = [
        "triangles_digest",
        "vertices_with_z_digest",
        "constraint_edges_digest",
        "edge_sources_digest",
    ];
    assert_eq!(digests[0]["constraint_edges"], 120);
    assert_eq!(digests[0]["edge_sources"], 120, "each edge comes once");
    assert_eq!(parts(&digests[0], &names), parts(&digests[1], &names));
    assert_eq!(parts(&digests[0], &names), parts(&digests[2], &names));
    run(folder, &format!("build {} -o free.tiles --quiet", formats("tin.ply")));
    let free = json(folder, "digest free.tiles --json");
    assert_ne!(free["triangles_digest"], digests[0]["triangles_digest"]);
    assert_eq!(free["vertices_with_z_digest"], digests[0]["vertices_with_z_digest"]);
}

/// The triangulation has lines, so that its edges are needed to find its triangles again.
#[test]
fn an_export_comes_back_with_the_same_triangles() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut points = String::new();
    (0..3000u64).for_each(|n| points += &format!("{} {} {}\n", n * 7919 % 1009, n * 104_729 % 1013, n % 17));
    fs::write(folder.join("a.xyz"), points).unwrap();
    fs::write(
        folder.join("lines.csv"),
        "10.5,7.5,990.5,1000.5\n3.5,900.5,1000.5,800.5\n",
    )
    .unwrap();
    run(
        folder,
        "build a.xyz --segments lines.csv --crossings split --missing-z zero -o a.tiles --tile-vertices 200 --quiet",
    );
    let before = json(folder, "digest a.tiles --json");
    let without = {
        run(folder, "export a.tiles -o x.obj");
        run(folder, "build x.obj -o x.tiles --quiet");
        json(folder, "digest x.tiles --json")
    };
    assert_ne!(without["triangles_digest"], before["triangles_digest"]);
    for name in ["b.ply", "b.obj", "b.node"] {
        run(folder, &format!("export a.tiles -o {name}"));
        let after = built(folder, name);
        let names = ["triangles", "triangles_digest", "vertices", "vertices_digest"];
        assert_eq!(parts(&after, &names), parts(&before, &names), "{name}");
        // Euler: V - E + F = 1 without the outer face.
        let edges = before["vertices"].as_u64().unwrap() + before["triangles"].as_u64().unwrap() - 1;
        assert_eq!(after["constraint_edges"], edges, "{name}");
    }
}

#[test]
fn several_meshes_keep_their_edges_apart() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("a.obj"), "v 0 0 1\nv 4 0 1\nv 0 4 1\nf 1 2 3\n").unwrap();
    fs::write(folder.join("b.node"), "4 3 0 0\n1 9 9 2\n2 9 5 2\n3 5 9 2\n4 5 5 2\n").unwrap();
    fs::write(folder.join("b.ele"), "2 3 0\n1 1 2 3\n2 2 3 4\n").unwrap();
    fs::write(folder.join("c.f64"), [7f64, 1.0, 3.0].map(f64::to_le_bytes).concat()).unwrap();
    let digest = built(folder, "a.obj b.node");
    assert_eq!(
        (&digest["vertices"], &digest["constraint_edges"]),
        (&7.into(), &8.into())
    );
    run(
        folder,
        "build b.node a.obj c.f64 --dims 3 --keep-edges -o out.tiles --force --quiet",
    );
    let digest = json(folder, "digest out.tiles --json");
    assert_eq!(
        (&digest["vertices"], &digest["constraint_edges"]),
        (&8.into(), &8.into())
    );
    let refused = |args: &str, part: &str| {
        let message = fails(folder, 1, &format!("build {args} -o x.tiles"));
        assert!(message.contains(part), "{message}");
    };
    refused(
        "c.f64 a.obj --keep-edges --dims 3",
        "a.obj: give .poly files, and those whose edges are kept, before",
    );
    refused("c.f64 --dims 3 --keep-edges", "--keep-edges: no input has edges");
    fs::remove_file(folder.join("b.ele")).unwrap();
    refused(
        "b.node --keep-edges",
        "b.node: its triangles would be in b.ele, which does not exist",
    );
    fs::write(
        folder.join("d.obj"),
        "v 0 0 1\nv 4 4 1\nv 0 4 1\nv 4 0 1\nf 1 2 3\nf 3 4 1\n",
    )
    .unwrap();
    refused("d.obj --keep-edges", "d.obj: face 0 (counted from 0)");
}
