//! Standard output that cannot be written: the error says what is missing there.

#![cfg(target_os = "linux")]

use std::fs::{self, File};
use std::process::Stdio;

use crate::support::{complaint, errors, json, run, tiletool};

#[test]
fn a_full_standard_output_is_an_error_that_names_what_is_lost() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let points = (0..400).map(|i| format!("{},{}\n", i % 20, f64::from(i / 20) + f64::from(i % 7) / 16.0));
    fs::write(folder.join("p.csv"), points.collect::<String>()).unwrap();
    fs::write(folder.join("w.csv"), "3.5,3.5,4.5,3.6\n").unwrap();
    fs::write(folder.join("at.csv"), "3,3\n4,4\n").unwrap();
    run(folder, "build p.csv -o t.tiles --quiet --tile-vertices 100");
    run(folder, "build p.csv -o e.tiles --quiet");
    for (args, what) in [
        ("build p.csv -o b.tiles", "the summary"),
        ("build p.csv -o b.tiles --force --json", "the summary"),
        ("constrain e.tiles --walls w.csv", "the summary"),
        ("compact e.tiles", "the summary"),
        ("inspect t.tiles", "the report"),
        ("inspect t.tiles --json --tiles", "the report"),
        ("verify t.tiles", "the result"),
        ("verify t.tiles --json", "the result"),
        ("digest t.tiles", "the digest"),
        ("export t.tiles -o t.ply", "the summary"),
        ("export t.tiles -o - --format obj", "the triangulation"),
        ("generate uniform -n 10 -o g.f64 --json", "the summary"),
        ("generate uniform -n 10 -o -", "the points"),
        ("query locate t.tiles --at 3.5,3.5", "the answers"),
        ("query knn t.tiles --at 3,3 --json", "the answers"),
        ("query matrix t.tiles --batch at.csv", "the answers"),
        ("bench read t.tiles --rounds 1 --backends threads", "the report"),
        ("--help", "the help"),
        ("build --help", "the help"),
    ] {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let mut command = tiletool(folder, args);
        command.stdout(full);
        // `output` would replace standard output.
        let output = command
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
            .wait_with_output()
            .unwrap();
        let error = errors(&output);
        assert_eq!(output.status.code(), Some(1), "{args}: {error}");
        let expected = format!("cannot write {what} to standard output: No space left on device");
        assert!(
            error
                .lines()
                .last()
                .is_some_and(|line| line.starts_with("error: ") && line.contains(&expected)),
            "{args}: {error}"
        );
        assert_eq!(error.matches("No space left").count(), 1, "{args}: {error}");
    }
    // The files were complete before their summaries could not be printed.
    run(folder, "verify --deep b.tiles");
    run(folder, "verify --deep e.tiles");
}

#[test]
fn a_reader_that_has_read_enough_is_no_error() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    run(folder, "generate uniform -n 1000 -o p.f64");
    run(folder, "build p.f64 -o t.tiles --quiet --tile-vertices 100");
    for args in [
        "inspect t.tiles",
        "digest t.tiles --json",
        "export t.tiles -o - --format obj",
        "--help",
    ] {
        let mut command = tiletool(folder, args);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success(), "{args}: {}", errors(&output));
    }
}

#[test]
fn a_build_without_points_says_so() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    fs::write(folder.join("none.csv"), "x,y\n").unwrap();
    fs::write(folder.join("bad.csv"), "x,y\n1,a\n").unwrap();
    let output = tiletool(folder, "build none.csv -o t.tiles").output().unwrap();
    assert!(output.status.success());
    assert!(
        errors(&output).contains("note: the input has no points"),
        "{}",
        errors(&output)
    );
    let built = json(folder, "build none.csv -o t.tiles --force --json");
    assert_eq!(built["notes"][0], "the input has no points");
    let built = json(folder, "build bad.csv -o t.tiles --force --json --skip-invalid");
    assert!(
        built["notes"]
            .as_array()
            .unwrap()
            .iter()
            .any(|note| note == "no point of the input was taken, of 1 record"),
        "{built}"
    );
    // Lines alone are no input of points.
    fs::write(folder.join("w.csv"), "0,0,1,1\n1,1,2,0\n").unwrap();
    let built = json(folder, "build --walls w.csv -o t.tiles --force --json");
    assert_eq!(built["notes"].as_array().map(Vec::len), Some(0), "{built}");
    assert!(!complaint(tiletool(folder, "build none.csv -o t.tiles"), 1).contains("no points"));
}

/// Without `--quiet`, each of these commands says something that it was not asked for.
#[test]
fn a_quiet_command_prints_answers_and_errors_alone() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    fs::write(folder.join("w.csv"), "0.1,0.1,0.2,0.9\n").unwrap();
    fs::write(folder.join("at.csv"), "0.5,0.6\n").unwrap();
    fs::write(folder.join("none.csv"), "").unwrap();
    for args in [
        "generate uniform -n 500 -o p.f64",
        "build p.f64 -o t.tiles",
        "constrain t.tiles --walls w.csv",
        "insert t.tiles at.csv",
        "checkpoint t.tiles",
        "compact t.tiles",
        "export t.tiles -o t.ply",
        "verify --deep t.tiles",
        "query knn t.tiles --batch none.csv --csv",
    ] {
        let loud = tiletool(folder, args).output().unwrap();
        assert!(loud.status.success(), "{args}: {}", errors(&loud));
        assert!(
            !loud.stdout.is_empty() || !loud.stderr.is_empty(),
            "{args} says nothing"
        );
        for made in ["t.tiles", "t.ply"]
            .iter()
            .filter(|made| args.contains(&format!("-o {made}")))
        {
            fs::remove_file(folder.join(made)).unwrap();
        }
        let quiet = tiletool(folder, &format!("{args} -q")).output().unwrap();
        assert!(
            quiet.status.success() && quiet.stderr.is_empty(),
            "{args}: {}",
            errors(&quiet)
        );
        let rows = String::from_utf8(quiet.stdout).unwrap();
        assert_eq!(
            rows.lines().count(),
            usize::from(args.contains("--csv")),
            "{args}: {rows}"
        );
    }
    let digest = tiletool(folder, "--quiet digest t.tiles").output().unwrap();
    assert!(
        digest.stderr.is_empty() && !digest.stdout.is_empty(),
        "the digest is what was asked for"
    );
    let wrong = tiletool(folder, "verify -q none.csv").output().unwrap();
    assert!(!wrong.status.success() && errors(&wrong).starts_with("error: "));
}
