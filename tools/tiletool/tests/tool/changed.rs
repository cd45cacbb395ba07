//! Inputs that change while the tool reads them, inputs that take long to read, and inputs that are
//! not regular files.

use std::fs::{self, File};
use std::io::Write;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::support::run;

fn mkfifo(path: &Path) {
    let made = Command::new("mkfifo").arg(path).status();
    assert!(made.is_ok_and(|status| status.success()));
}

fn start(folder: &Path, args: &str) -> Child {
    let mut command = crate::support::tiletool(folder, args);
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits for a process, which must end within ten seconds. Returns its output.
fn output_within_ten_seconds(mut child: Child) -> Output {
    let began = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if began.elapsed() > Duration::from_secs(10) {
            child.kill().unwrap();
            panic!("it does not end");
        }
        thread::sleep(Duration::from_millis(10));
    }
    child.wait_with_output().unwrap()
}

fn refused(output: &Output, parts: &[&str]) {
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{text}");
    for part in parts {
        assert!(text.contains(part), "`{part}` is not in: {text}");
    }
    assert!(!text.contains("panicked"), "{text}");
}

fn raw(count: u32) -> Vec<u8> {
    (0..2 * count)
        .flat_map(|n| ((u64::from(n) * u64::from(n) % 10_007) as f64).to_le_bytes())
        .collect()
}

/// A file that was truncated while it was read once gave a tile file of the rest, and exit code 0.
/// When the tool waits for the FIFO, it has opened this file but not read it.
#[test]
fn an_input_that_shrinks_while_it_is_read_is_an_error_and_nothing_is_published() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let points = folder.join("points.f64");
    let shrink_behind = |child| {
        let mut fifo = File::options().write(true).open(folder.join("more.csv")).unwrap();
        File::options()
            .write(true)
            .open(&points)
            .unwrap()
            .set_len(16 * 50_000)
            .unwrap();
        fifo.write_all(b"x,y\n0.5,0.5\n").unwrap();
        drop(fifo);
        output_within_ten_seconds(child)
    };
    fs::write(&points, raw(100_000)).unwrap();
    mkfifo(&folder.join("more.csv"));
    let built = shrink_behind(start(folder, "build points.f64 more.csv -o out.tiles"));
    refused(
        &built,
        &[
            "points.f64",
            "changed while it was read",
            "it had 1600000 bytes, and has 800000",
        ],
    );
    let mut left: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    left.sort();
    assert_eq!(left, ["more.csv", "points.f64"]);

    fs::write(&points, raw(100_000)).unwrap();
    run(folder, "build points.f64 -o out.tiles");
    let verified = shrink_behind(start(folder, "verify out.tiles --against points.f64 more.csv"));
    refused(&verified, &["points.f64", "changed while it was read"]);
}

#[test]
fn a_tile_path_that_is_not_a_regular_file_is_an_error_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    mkfifo(&folder.join("fifo.tiles"));
    fs::write(folder.join("lines.csv"), "0,0,1,1\n").unwrap();
    for args in [
        "inspect fifo.tiles",
        "verify fifo.tiles",
        "digest fifo.tiles",
        "export fifo.tiles -o out.ply",
        "query locate fifo.tiles --at 0,0",
        "compact fifo.tiles",
        "constrain fifo.tiles --segments lines.csv",
        "bench read fifo.tiles",
    ] {
        refused(
            &output_within_ten_seconds(start(folder, args)),
            &["fifo.tiles", "it is a FIFO"],
        );
    }
    refused(
        &output_within_ten_seconds(start(folder, "inspect /dev/zero")),
        &["/dev/zero", "it is a device"],
    );
    refused(
        &output_within_ten_seconds(start(folder, "inspect .")),
        &["it is a folder"],
    );
}

/// The input has 1.5 GB of blank lines in a small gzip file. Ctrl-C once had no effect before the
/// next row.
#[test]
fn a_long_run_of_blank_lines_can_be_interrupted() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let file = File::create(folder.join("blank.csv.gz")).unwrap();
    let mut encoder = flate2::write::GzEncoder::new(file, flate2::Compression::fast());
    // The detection of the format, at the beginning of the file, reads none of the blank lines.
    encoder.write_all(&b"1,2,3,4\n5,6,8,9\n".repeat(6_000)).unwrap();
    let blank = vec![b'\n'; 16 << 20];
    for _ in 0..100 {
        encoder.write_all(&blank).unwrap();
    }
    encoder.finish().unwrap();
    for (option, name) in [("", "points"), ("--segments ", "lines"), ("--sites ", "sites")] {
        let child = start(folder, &format!("build -o {name}.tiles {option}blank.csv.gz"));
        // The work folder exists before anything is read.
        let partial = folder.join(format!("{name}.tiles.partial"));
        while !partial.exists() {
            thread::sleep(Duration::from_millis(5));
        }
        thread::sleep(Duration::from_millis(500));
        let pid = rustix::process::Pid::from_child(&child);
        rustix::process::kill_process(pid, rustix::process::Signal::INT).unwrap();
        refused(&output_within_ten_seconds(child), &["interrupted"]);
        assert!(!folder.join(format!("{name}.tiles")).exists());
    }
}

/// Control characters of site ids and file names once reached the terminal unchanged.
#[test]
fn control_characters_of_names_and_ids_are_escaped_in_text() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let name = "\u{1b}[2J\nerror: sites.csv";
    fs::write(
        folder.join(name),
        "x,y,id\n0,0,\"a\u{1b}]0;owned\u{7}\nb\"\n1,0,c\n0,1,d\n",
    )
    .unwrap();
    let assert_escaped = |text: &str| {
        let is_command = |c: char| c.is_control() && c != '\n';
        assert!(
            !text.contains(is_command) && !text.contains("\nerror: sites"),
            "{text:?}"
        );
    };
    let built = crate::support::printed(crate::support::command(
        folder,
        &["build", "--sites", name, "-o", "town\u{1b}.tiles"],
    ));
    assert_escaped(&built);
    let at = ["query", "nearest", "town\u{1b}.tiles", "--at", "0,0", "-k", "1"];
    let found = crate::support::printed(crate::support::command(folder, &at));
    assert_escaped(&found);
    assert!(found.contains(r"site a\u{1b}]0;owned\u{7}\nb at"), "{found}");
    assert_escaped(&crate::support::printed(crate::support::command(
        folder,
        &["inspect", "town\u{1b}.tiles"],
    )));
    // The output for programs has the original characters.
    let csv = crate::support::printed(crate::support::command(folder, &[&at[..], &["--csv"]].concat()));
    assert!(csv.contains("\"a\u{1b}]0;owned\u{7}\nb\""), "{csv:?}");
    fs::write(folder.join(name), "x,y\n1,\u{1b}[2J\n").unwrap();
    let refused = crate::support::complaint(
        crate::support::command(folder, &["build", "--sites", name, "-o", "b.tiles"]),
        1,
    );
    assert_escaped(&refused);
    assert_escaped(&crate::support::complaint(
        crate::support::command(folder, &["build", "--\u{1b}[2J"]),
        2,
    ));
}

/// A row of 1 GB once took 2 GB of memory and was printed whole.
#[test]
fn an_overlong_row_is_a_short_error() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("p.f64"), raw(100)).unwrap();
    run(folder, "build p.f64 -o p.tiles");
    fs::write(folder.join("long.csv"), "1,2\n".to_owned() + &"9".repeat(3 << 20)).unwrap();
    fs::write(
        folder.join("wide.csv"),
        "1,2\n".to_owned() + &"9,".repeat(100_000) + "\u{1b}[2J",
    )
    .unwrap();
    let long = crate::support::fails(folder, 1, "query locate p.tiles --batch long.csv");
    assert!(
        long.contains("long.csv: line 2: a row of more than 1048576 bytes"),
        "{long}"
    );
    let wide = crate::support::fails(folder, 1, "query locate p.tiles --batch wide.csv");
    assert!(wide.contains("wide.csv: line 2: `9,9,9") && wide.len() < 300, "{wide}");
}

/// Ends of break lines without z once became pits, with a note at most.
#[test]
fn lines_without_z_in_terrain_are_an_error_on_request_that_names_file_and_option() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("ground.csv"), "x,y,z\n0,0,800\n9,0,800\n9,9,800\n0,9,801\n").unwrap();
    fs::write(folder.join("lakes.csv"), "0,0,9,9\n2,1,8,1\n").unwrap();
    fs::write(folder.join("shops.csv"), "9,9\n3,7\n").unwrap();
    let lakes = crate::support::fails(
        folder,
        1,
        "build ground.csv --segments lakes.csv --missing-z error -o a.tiles",
    );
    for part in [
        "lakes.csv: row 1 (counted from 0) has no z at (2, 1)",
        "2 vertices",
        "--missing-z zero",
    ] {
        assert!(lakes.contains(part), "{lakes}");
    }
    let shops = crate::support::fails(
        folder,
        1,
        "build ground.csv --sites shops.csv --missing-z error -o a.tiles",
    );
    assert!(
        shops.contains("shops.csv: site 1 (counted from 0) has no z at (3, 7)"),
        "{shops}"
    );
    assert!(!folder.join("a.tiles").exists());
    run(folder, "build ground.csv -o a.tiles");
    let later = crate::support::fails(folder, 1, "constrain a.tiles --segments lakes.csv --missing-z error");
    for part in ["lakes.csv: row 1", "(2, 1) has no z", "--missing-z zero"] {
        assert!(later.contains(part), "{later}");
    }
    run(folder, "constrain a.tiles --segments lakes.csv --missing-z zero");
    run(
        folder,
        "verify --deep a.tiles --against ground.csv --segments lakes.csv",
    );
    let built = crate::support::json(
        folder,
        "build ground.csv --segments lakes.csv --sites shops.csv --missing-z zero -o b.tiles --json",
    );
    assert_eq!(built["notes"].to_string(), r#"["3 vertices without z got z = 0"]"#);
    run(
        folder,
        "verify --deep b.tiles --against ground.csv --segments lakes.csv --sites shops.csv",
    );
}
