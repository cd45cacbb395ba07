//! The tool from the command line: build, verify and digest with files and pipes, mistakes, and
//! interruptions.

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::support::{complaint, data, errors, names, printed};
use serde_json::Value;
use tempfile::TempDir;

/// A temporary folder in which the tool runs.
struct Scratch(TempDir);

impl Scratch {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).unwrap();
    }

    fn command(&self, args: &[&str]) -> Command {
        crate::support::command(self.0.path(), args)
    }

    /// Runs a command that must succeed. Returns its standard output.
    #[track_caller]
    fn ok(&self, args: &[&str]) -> String {
        printed(self.command(args))
    }

    #[track_caller]
    fn json(&self, args: &[&str]) -> Value {
        serde_json::from_str(&self.ok(args)).unwrap()
    }

    /// Runs a command that must fail with this exit code. Returns its standard error.
    #[track_caller]
    fn fails(&self, code: i32, args: &[&str]) -> String {
        complaint(self.command(args), code)
    }

    fn names(&self) -> Vec<String> {
        names(self.0.path())
    }
}

#[test]
fn indonesia_is_built_from_geojson_and_verified() {
    let scratch = Scratch::new();
    let coast = data("indonesia/indonesia_ne10m.geojson");
    let summary = scratch.json(&["build", &coast, "-o", "i.tiles", "--tile-vertices", "1000", "--json"]);
    assert_eq!(summary["records"], 23_880);
    assert_eq!(summary["points"], 23_880);
    assert_eq!(summary["duplicates"], 339);
    assert_eq!(summary["vertices"], 23_541);
    assert_eq!(summary["triangles"], 47_034);
    assert_eq!(summary["hull_edges"], 46);
    assert_eq!(summary["tiles"], 24);
    assert!(summary["notes"][0].as_str().unwrap().contains("339 polygons"));
    let levels = summary["levels"].as_array().unwrap();
    assert_eq!(levels.last().unwrap()["seam_vertices"], 0, "the root passes nothing up");
    for key in ["seconds", "peak_memory_bytes", "bytes_per_vertex", "file_bytes"] {
        assert!(summary[key].as_f64().unwrap() > 0.0, "{key}");
    }
    let report = scratch.json(&["verify", "i.tiles", "--deep", "--against", &coast, "--json"]);
    assert_eq!(report["ok"], true);
    assert_eq!(report["edges"], 70_574);
    assert_eq!(report["input_points"], 23_880);

    let digest = scratch.ok(&["digest", "--recompute", "i.tiles"]);
    scratch.ok(&[
        "build",
        &coast,
        "-o",
        "one.tiles",
        "--engine",
        "spade",
        "--threads",
        "3",
        "--quiet",
    ]);
    assert_eq!(scratch.ok(&["digest", "--recompute", "one.tiles"]), digest);
    assert_eq!(digest.lines().count(), 7);
    assert_eq!(scratch.names(), ["i.tiles", "one.tiles"]);
}

#[test]
fn segments_become_chains_of_edges() {
    let scratch = Scratch::new();
    let coast = data("indonesia/indonesia_ne10m.geojson");
    let build = ["build", "--segments", &coast, "--json"];
    let summary = scratch.json(&[&build[..], &["-o", "i.tiles", "--tile-vertices", "500"]].concat());
    assert_eq!(summary["segments"], 23_541);
    assert_eq!(summary["constraint_edges"], 23_541);
    assert_eq!(summary["points"], 0);
    assert_eq!(summary["added_vertices"], 23_541);
    assert_eq!(summary["vertices"], 23_541);
    scratch.json(&[&build[..], &[&coast, "-o", "one.tiles"]].concat());
    assert_eq!(
        scratch.ok(&["digest", "--recompute", "i.tiles"]),
        scratch.ok(&["digest", "--recompute", "one.tiles"])
    );
    let report = scratch.json(&["verify", "--deep", "i.tiles", "--segments", &coast, "--json"]);
    assert_eq!(report["constraint_edges"], 23_541);
    assert_eq!(report["input_points"], 2 * 23_541);
    let text = scratch.ok(&[
        "verify",
        "--deep",
        "one.tiles",
        "--against",
        &coast,
        "--segments",
        &coast,
    ]);
    assert!(text.contains("constrained Delaunay triangulation"), "{text}");
    assert!(scratch.ok(&["inspect", "one.tiles"]).contains("23 541 edges"));

    // Pairs of record numbers give the same result as rows of ends.
    scratch.write("p.csv", "x,y\n0,0\n4,0\n4,4\n0,4\n1,2\n");
    scratch.write("s.csv", "x1,y1,x2,y2\n0,0,4,4\n4,0,4,4\n");
    scratch.write("s.u32", [0u32, 2, 1, 2].map(u32::to_le_bytes).concat());
    scratch.write("s.u64", [2u64, 0, 2, 1].map(u64::to_le_bytes).concat());
    let digests = ["s.csv", "s.u32", "s.u64"].map(|segments| {
        scratch.ok(&[
            "build",
            "p.csv",
            "--segments",
            segments,
            "-o",
            "s.tiles",
            "--force",
            "--quiet",
        ]);
        scratch.ok(&["digest", "--recompute", "s.tiles"])
    });
    assert!(digests[0].contains("constraint-edges            2"), "{}", digests[0]);
    assert_eq!(digests[0], digests[1]);
    assert_eq!(digests[0], digests[2]);

    scratch.write("far.u32", [0u32, 9].map(u32::to_le_bytes).concat());
    scratch.write("short.u32", [1, 2, 3]);
    scratch.write("cross.csv", "0,0,4,4\n4,0,0,4\n");
    scratch.write("word.csv", "0,0,4,4\n4,0,x,4\n");
    scratch.write("segments.bin", "");
    for (segments, expected) in [
        ("far.u32", "record 9, but no point has that record number"),
        ("short.u32", "left over"),
        (
            "cross.csv",
            "cross.csv: row 0 (counted from 0) and cross.csv: row 1 (counted from 0) at (2, 2)",
        ),
        ("word.csv", "segment 1 (line 2)"),
        ("segments.bin", "tells how segments are written"),
        ("none.csv", "cannot be opened"),
    ] {
        let error = scratch.fails(1, &["build", "p.csv", "--segments", segments, "-o", "no.tiles"]);
        assert!(error.contains(expected), "{error}");
        assert!(!scratch.path("no.tiles").exists() && !scratch.path("no.tiles.partial").exists());
    }
}

#[test]
fn lidar_is_built_with_z_and_filters() {
    let scratch = Scratch::new();
    for file in ["autzen.las", "autzen.laz", "autzen.copc.laz"] {
        let survey = data(&format!("las/{file}"));
        scratch.ok(&["build", &survey, "-o", "a.tiles", "--force", "--quiet"]);
        scratch.ok(&["verify", "--deep", "a.tiles", "--against", &survey]);
    }
    let survey = data("las/autzen.las");
    let all = scratch.json(&["build", &survey, "-o", "all.tiles", "--json"]);
    let ground = scratch.json(&["build", &survey, "-o", "ground.tiles", "--class", "2", "--json"]);
    assert_eq!(ground["records"], all["records"]);
    assert!(ground["points"].as_u64() < all["points"].as_u64());
    assert_eq!(
        ground["points"].as_u64().unwrap() + ground["filtered"].as_u64().unwrap(),
        all["points"].as_u64().unwrap()
    );
    // With the same filter, the file agrees with its input. Without the filter, it does not.
    scratch.ok(&["verify", "ground.tiles", "--against", &survey, "--class", "2"]);
    let error = scratch.fails(1, &["verify", "ground.tiles", "--against", &survey]);
    assert!(error.contains("is not in the file"), "{error}");
}

#[test]
fn copc_is_built_by_level_and_resolution() {
    let scratch = Scratch::new();
    // This file has only the root of an octree.
    let copc = data("las/autzen.copc.laz");
    for choice in [["--level", "0"], ["--resolution", "0.25"]] {
        let args = [&["build", &copc, "-o", "a.tiles", "--force", "--json"], &choice[..]].concat();
        assert_eq!(scratch.json(&args)["points"], 107);
        scratch.ok(&["verify", "a.tiles", "--against", &copc, choice[0], choice[1]]);
        let laz = data("las/autzen.laz");
        let error = scratch.fails(1, &["build", &laz, "-o", "no.tiles", choice[0], choice[1]]);
        assert!(error.contains("autzen.laz: this is not a COPC file"), "{error}");
        assert!(!scratch.path("no.tiles").exists());
    }
    for wrong in [
        ["--level", "-1"],
        ["--level", "256"],
        ["--resolution", "0"],
        ["--resolution", "inf"],
    ] {
        scratch.fails(2, &["build", &copc, "-o", "no.tiles", wrong[0], wrong[1]]);
    }
}

#[test]
fn points_are_read_from_a_pipe() {
    let scratch = Scratch::new();
    let mut child = scratch
        .command(&["build", "-", "--format", "text", "-o", "p.tiles", "--json"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let rows: String = (0..1000).map(|i| format!("{} {} {}\n", i % 40, i / 40, i)).collect();
    child.stdin.take().unwrap().write_all(rows.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["triangles"], 2 * 39 * 24);
    scratch.write("rows.txt", &rows);
    scratch.ok(&["verify", "--deep", "p.tiles", "--against", "rows.txt"]);
}

#[test]
fn the_digest_does_not_depend_on_the_tile_size() {
    let scratch = Scratch::new();
    scratch.ok(&["generate", "kuzmin", "-n", "5000", "--seed", "3", "-o", "k.f64"]);
    let mut digests = Vec::new();
    for tile_vertices in ["8", "64", "1000", "65536"] {
        scratch.ok(&[
            "build",
            "k.f64",
            "-o",
            "k.tiles",
            "--force",
            "--tile-vertices",
            tile_vertices,
            "--quiet",
        ]);
        digests.push(scratch.ok(&["digest", "--recompute", "k.tiles"]));
    }
    assert!(digests.iter().all(|digest| *digest == digests[0]), "{digests:#?}");
}

#[test]
fn several_inputs_make_one_set_and_duplicates_follow_the_rule() {
    let scratch = Scratch::new();
    scratch.write("a.csv", "x,y,z\n0,0,5\n1,0,5\n0,1,5\n");
    scratch.write("b.xyz", "0 0 3\n1 1 3\n0 0 9\n");
    let build = |rule: &str| {
        scratch.ok(&[
            "build",
            "a.csv",
            "b.xyz",
            "-o",
            "d.tiles",
            "--force",
            "--quiet",
            "--duplicates",
            rule,
        ]);
        scratch.ok(&["verify", "--deep", "d.tiles", "--against", "a.csv", "b.xyz"]);
        scratch.json(&["inspect", "d.tiles", "--tile", "0", "--json"])
    };
    for (rule, z) in [("first", "5"), ("lowest", "3"), ("highest", "9")] {
        let tile = build(rule).to_string();
        assert!(tile.contains(&format!("{z}.0")), "{rule}: {tile}");
    }
    let error = scratch.fails(
        1,
        &["build", "a.csv", "b.xyz", "-o", "e.tiles", "--duplicates", "error"],
    );
    assert!(error.contains("records 0 and 3"), "{error}");
    assert!(!scratch.names().contains(&"e.tiles".to_owned()));
}

#[test]
fn every_command_accepts_files_without_triangles() {
    let scratch = Scratch::new();
    for (name, rows, vertices) in [
        ("none", "", 0),
        ("one", "1,2\n", 1),
        ("two", "1,2\n3,4\n", 2),
        ("line", "1,1\n3,3\n2,2\n9,9\n", 4),
        ("same", "1,1\n1,1\n1,1\n1,1\n1,1\n1,1\n", 1),
    ] {
        scratch.write("in.csv", rows);
        let tiles = format!("{name}.tiles");
        let summary = scratch.json(&["build", "in.csv", "-o", &tiles, "--tile-vertices", "4", "--json"]);
        assert_eq!(summary["vertices"], vertices, "{name}");
        assert_eq!(summary["triangles"], 0, "{name}");
        scratch.ok(&["verify", "--deep", &tiles, "--against", "in.csv"]);
        scratch.ok(&["digest", "--recompute", &tiles]);
        scratch.ok(&["inspect", &tiles, "--tiles"]);
        scratch.ok(&["inspect", &tiles, "--plot", "p.svg"]);
        for output in ["o.ply", "o.node", "o.obj", "o.geojson"] {
            scratch.ok(&["export", &tiles, "-o", output]);
        }
    }
}

#[test]
fn a_build_draws_the_finished_file() {
    let scratch = Scratch::new();
    scratch.write("in.csv", "1,1\n3,3\n2,9\n9,4\n");
    let summary = scratch.json(&["build", "in.csv", "-o", "a.tiles", "--plot", "a.svg", "--json"]);
    assert_eq!(summary["plot"]["triangles"], summary["triangles"]);
    scratch.ok(&["inspect", "a.tiles", "--plot", "b.svg"]);
    let [a, b] = ["a.svg", "b.svg"].map(|name| fs::read_to_string(scratch.path(name)).unwrap());
    assert_eq!(a, b);
    let text = scratch.ok(&["build", "in.csv", "-o", "c.tiles", "--plot", "c.png"]);
    assert!(text.contains("c.png: 1600 x "), "{text}");
    scratch.fails(2, &["build", "in.csv", "-o", "d.tiles", "--plot", "d.pdf"]);
    assert!(!scratch.path("d.tiles").exists());
}

#[test]
fn a_mistake_is_an_error_that_names_its_cause() {
    let scratch = Scratch::new();
    scratch.write("good.csv", "x,y\n1,2\n3,5\n2,9\n");
    scratch.write("bad.csv", "x,y\n1,2\n3,NaN\n5,oops\n");
    for (code, args, says) in [
        (2, &["bild"][..], "similar subcommand"),
        (2, &["build", "good.csv"][..], "--output"),
        (
            2,
            &["build", "good.csv", "-o", "x.tiles", "--memory", "lots"][..],
            "--memory",
        ),
        (
            2,
            &["build", "good.csv", "-o", "x.tiles", "--engine", "v8"][..],
            "native",
        ),
        (1, &["build", "absent.csv", "-o", "x.tiles"][..], "absent.csv"),
        (
            1,
            &["build", "good.csv", "-o", "no/such/folder/x.tiles"][..],
            "no/such/folder",
        ),
        (1, &["build", "bad.csv", "-o", "x.tiles"][..], "record 1 (line 3)"),
        (
            1,
            &["build", "good.csv", "-o", "x.tiles", "--tile-vertices", "1"][..],
            "from 4 to",
        ),
        (1, &["build", "good.csv", "-o", "good.csv"][..], "exists already"),
        (
            1,
            &["build", "good.csv", "-o", "x.tiles", "--tmp", "no/such"][..],
            "no/such",
        ),
        (1, &["verify", "good.csv"][..], "good.csv"),
        (1, &["inspect", "good.csv"][..], "tiletool build good.csv -o"),
        (
            1,
            &["build", "good.csv", "-o", "good.csv"][..],
            "or give --force to replace it",
        ),
        (1, &["build", "bad.csv", "-o", "x.tiles"][..], "option `--skip-invalid`"),
        (1, &["digest", "absent.tiles"][..], "absent.tiles"),
    ] {
        let error = scratch.fails(code, args);
        assert!(error.contains(says), "{args:?}: {error}");
        assert!(!error.contains("panicked"), "{error}");
        assert!(!error.contains("good.csv: good.csv"), "{error}");
    }
    assert_eq!(scratch.names(), ["bad.csv", "good.csv"]);
    let summary = scratch.json(&["build", "bad.csv", "-o", "x.tiles", "--skip-invalid", "--json"]);
    assert_eq!((&summary["points"], &summary["invalid"]), (&1.into(), &2.into()));
    assert_eq!(
        fs::read(scratch.path("good.csv")).unwrap().len(),
        16,
        "the input changed"
    );
}

#[test]
fn a_closed_standard_error_does_not_change_the_exit_code() {
    let scratch = Scratch::new();
    for (args, code) in [("generate uniform -n 9 -o points.f64", 0), ("inspect none.tiles", 1)] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut command = scratch.command(&args.split(' ').collect::<Vec<_>>());
        assert_eq!(command.stderr(writer).status().unwrap().code(), Some(code), "{args}");
    }
    assert_eq!(fs::metadata(scratch.path("points.f64")).unwrap().len(), 9 * 16);
}

#[test]
fn a_damaged_tile_is_named() {
    let scratch = Scratch::new();
    scratch.ok(&["generate", "grid", "-n", "400", "-o", "g.f64"]);
    scratch.ok(&["build", "g.f64", "-o", "g.tiles", "--tile-vertices", "64", "--quiet"]);
    let mut bytes = fs::read(scratch.path("g.tiles")).unwrap();
    // The first core follows the superblocks and 4096 bytes for the root, and the next core starts
    // at least 4096 bytes later.
    bytes[12_288 + 300] ^= 16;
    scratch.write("broken.tiles", &bytes);
    let error = scratch.fails(1, &["verify", "broken.tiles"]);
    assert!(error.contains("tile 0 at byte 12288"), "{error}");
    let output = scratch.command(&["verify", "broken.tiles", "--json"]).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["ok"], false);
    assert!(report["error"].as_str().unwrap().contains("tile 0"));
}

#[test]
fn an_interrupted_build_leaves_no_files() {
    let scratch = Scratch::new();
    let mut child = scratch
        .command(&["build", "-", "--format", "text", "-o", "i.tiles"])
        .stdin(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The build has started when its work folder exists. Then it waits for more input, which never
    // comes.
    let mut stdin = child.stdin.take().unwrap();
    let row: Vec<u8> = (0..100_000)
        .flat_map(|i| format!("{i} {}\n", i * 7 % 1000).into_bytes())
        .collect();
    stdin.write_all(&row).unwrap();
    let began = Instant::now();
    while !scratch.path("i.tiles.partial").exists() && began.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(10));
    }
    // The handler of Ctrl-C is installed when the build is first polled, right after the folder was
    // created.
    std::thread::sleep(Duration::from_millis(300));
    let kill = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(kill.success());
    let output = child.wait_with_output().unwrap();
    drop(stdin);
    assert_eq!(output.status.code(), Some(1), "{}", errors(&output));
    assert!(errors(&output).contains("interrupted"), "{}", errors(&output));
    assert_eq!(scratch.names(), [""; 0]);
}
