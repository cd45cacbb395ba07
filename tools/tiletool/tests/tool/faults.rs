//! Each I/O call of the tool fails once in each way. The result must be the old file, the new file,
//! or an error.
//!
//! The calls are those of the C library, which `tools/faults` intercepts. Calls directly to the
//! kernel (advice, io_uring) are not among them.

#![cfg(target_os = "linux")]

use std::fs;
use std::path::Path;
use std::process::Output;

use delaunay_tiles::Point;

use crate::log::log_points;
use crate::support::cases::cases;
use crate::support::{errors, faults, run, tiletool};

/// Maximum number of runs for each kind of fault. If there are more calls, they are sampled at
/// equal steps, for each kind from another one on.
fn max_runs() -> u64 {
    cases(80) as u64
}

const WAYS: [&str; 6] = ["eio", "enospc", "eintr", "short", "torn", "delay"];

/// A command of the tool in a folder, with counts of its runs.
struct Trial {
    folder: tempfile::TempDir,
    args: &'static str,
    tried: u64,
    failed: u64,
}

impl Trial {
    fn new(args: &'static str, prepare: impl FnOnce(&Path)) -> Self {
        let folder = tempfile::tempdir().unwrap();
        prepare(folder.path());
        Self {
            folder,
            args,
            tried: 0,
            failed: 0,
        }
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Runs the command with a fault at call number `at`. Returns its output, the number of calls,
    /// and whether the fault happened.
    fn once(&self, at: u64, way: &str) -> (Output, u64, bool) {
        let report = self.path().join("report");
        let mut command = tiletool(self.path(), self.args);
        let output = command
            .env("LD_PRELOAD", faults())
            .env("FAULTS_AT", at.to_string())
            .env("FAULTS_WAY", way)
            .env("FAULTS_REPORT", &report)
            .env("DELAUNAY_TILES_IO", "threads")
            .output()
            .unwrap();
        let report_text = fs::read_to_string(report).unwrap();
        let (calls, is_done) = report_text.trim().split_once(' ').unwrap();
        (output, calls.parse().unwrap(), is_done == "1")
    }

    /// Runs the command with a fault at each call, in each way. `prepare` restores the folder
    /// before each run. `check` gets the output of the run, and whether it succeeded.
    fn all(&mut self, prepare: impl Fn(&Path), check: impl Fn(&Path, &Output, bool, &str)) {
        prepare(self.path());
        let (output, calls, _) = self.once(0, "eio");
        assert!(output.status.success(), "{}", errors(&output));
        assert!(calls > 5, "{}: {calls} calls", self.args);
        for (way, first) in WAYS.into_iter().zip(0..) {
            let step = calls.div_ceil(max_runs()).max(1) as usize;
            // The last calls matter most, so sampling starts there.
            for at in (1..=calls).rev().skip(first % step).step_by(step) {
                prepare(self.path());
                let (output, _, is_done) = self.once(at, way);
                let context = format!("{}, call {at} of {calls}, {way}: {}", self.args, errors(&output));
                assert!(
                    !context.contains("panicked") && !context.contains("internal error"),
                    "{context}"
                );
                let succeeded = match output.status.code() {
                    Some(0) => true,
                    Some(1) => false,
                    _ => panic!("{context}: {}", output.status),
                };
                assert!(succeeded || !errors(&output).trim().is_empty(), "{context}");
                // An interrupted call is repeated, a short one is continued, and a slow one is
                // waited for.
                assert!(
                    succeeded || is_done && ["eio", "enospc", "torn"].contains(&way),
                    "{context}"
                );
                check(self.path(), &output, succeeded, &context);
                self.tried += u64::from(is_done);
                self.failed += u64::from(!succeeded);
            }
        }
        println!(
            "{}: {} calls, {} went wrong, {} runs failed",
            self.args, calls, self.tried, self.failed
        );
        assert!(self.failed > 5 && self.tried > self.failed);
    }
}

/// Writes points, walls between them, and sites.
fn write_town(folder: &Path) {
    let points = (0..1600).map(|i| format!("{},{}\n", i % 40, f64::from(i / 40) + f64::from(i % 7) / 16.0));
    fs::write(folder.join("points.csv"), points.collect::<String>()).unwrap();
    // Rows of points that are exactly collinear.
    let walls = (1..5).map(|i| format!("0,{0},35,{0}\n", 7 * i));
    fs::write(folder.join("walls.csv"), walls.collect::<String>()).unwrap();
    fs::write(folder.join("sites.csv"), "3,30,baker\n20,20,miller\n").unwrap();
}

fn renew_now(folder: &Path) {
    fs::copy(folder.join("old.tiles"), folder.join("now.tiles")).unwrap();
}

/// Returns whether two files have the same digest.
fn is_like(folder: &Path, file: &str, other: &str) -> bool {
    run(folder, &format!("digest --recompute {file}")) == run(folder, &format!("digest --recompute {other}"))
}

/// Writes a file in place of an old one. Afterwards, either the old file or the new one must exist
/// completely.
fn test_output(args: &'static str, file: &'static str, prepare: impl FnOnce(&Path)) {
    let mut trial = Trial::new(args, prepare);
    let new = trial.path().join(file);
    fs::write(&new, "").unwrap();
    run(trial.path(), args);
    let expected = fs::read(&new).unwrap();
    let renew = |folder: &Path| {
        let _ = fs::remove_dir_all(folder.join("new.tiles.partial"));
        fs::write(folder.join(file), "what was there before").unwrap();
    };
    trial.all(renew, |folder, _, succeeded, context| {
        let found = fs::read(folder.join(file)).unwrap();
        let is_old = found == b"what was there before";
        // After the file got its name, writing its folder to the disk may still fail.
        assert!(found == expected || !succeeded && is_old, "{context}");
    });
}

#[test]
fn io_faults_in_a_build_leave_the_old_or_the_new_file() {
    test_output(
        "build points.csv --walls walls.csv --sites sites.csv -o new.tiles --force --tile-vertices 300 --threads 2 --quiet",
        "new.tiles",
        write_town,
    );
}

#[test]
fn io_faults_in_a_spilling_build_leave_the_old_or_the_new_file() {
    test_output(
        "build points.csv --walls walls.csv -o new.tiles --force --tile-vertices 60 --threads 1 --memory 100KiB --quiet",
        "new.tiles",
        write_town,
    );
}

#[test]
fn io_faults_in_an_archive_leave_the_old_or_the_new_file() {
    let args = "export town.tiles -o new.pmtiles --layer mesh --zooms 0..2 --at-once 1";
    test_output(args, "new.pmtiles", |folder| {
        write_town(folder);
        run(
            folder,
            "build points.csv --walls walls.csv -o town.tiles --tile-vertices 200 --quiet",
        );
    });
}

#[test]
fn io_faults_in_an_edit_leave_the_old_or_the_new_file() {
    let mut trial = Trial::new("constrain now.tiles --walls walls.csv --quiet", |folder| {
        write_town(folder);
        run(folder, "build points.csv -o old.tiles --tile-vertices 200 --quiet");
        run(
            folder,
            "build points.csv --walls walls.csv -o new.tiles --tile-vertices 200 --quiet",
        );
    });
    trial.all(renew_now, |folder, _, succeeded, context| {
        let is_new = is_like(folder, "now.tiles", "new.tiles");
        assert!(
            is_new || !succeeded && is_like(folder, "now.tiles", "old.tiles"),
            "{context}"
        );
    });
}

/// Runs an edit with faults. `old` and `new` are the commands that make the file before and after it.
fn test_edit(args: &'static str, old: &[&str], new: &[&str]) {
    let mut trial = Trial::new(args, |folder| {
        write_town(folder);
        fs::write(folder.join("none.csv"), "").unwrap();
        fs::write(folder.join("row.csv"), "0,0\n1,0\n2,0\n3,0\n").unwrap();
        fs::write(folder.join("apex.csv"), "1,5\n").unwrap();
        fs::write(folder.join("street.csv"), "0,0,2,0\n").unwrap();
        for command in old.iter().chain(new) {
            run(folder, command);
        }
    });
    let renew = |folder: &Path| {
        let _ = fs::remove_dir_all(folder.join("now.tiles.partial"));
        renew_now(folder);
    };
    trial.all(renew, |folder, _, succeeded, context| {
        let is_new = is_like(folder, "now.tiles", "new.tiles");
        let is_old = is_like(folder, "now.tiles", "old.tiles");
        assert!(is_new || !succeeded && is_old, "{context}");
        run(folder, "verify --deep now.tiles");
    });
}

#[test]
fn io_faults_in_changes_of_points_leave_the_old_or_the_new_file() {
    test_edit(
        "delete now.tiles apex.csv --quiet",
        &["build points.csv row.csv apex.csv -o old.tiles --tile-vertices 200 --quiet"],
        &["build points.csv row.csv -o new.tiles --tile-vertices 200 --quiet"],
    );
}

#[test]
fn io_faults_in_an_edit_of_a_file_without_triangles_leave_the_old_or_the_new_file() {
    test_edit(
        "insert now.tiles apex.csv --quiet",
        &["build row.csv --segments street.csv -o old.tiles --quiet"],
        &["build row.csv apex.csv --segments street.csv -o new.tiles --quiet"],
    );
}

#[test]
fn io_faults_in_an_edit_that_leaves_no_triangles_leave_the_old_or_the_new_file() {
    test_edit(
        "delete now.tiles apex.csv --quiet",
        &["build row.csv apex.csv --segments street.csv -o old.tiles --quiet"],
        &["build row.csv --segments street.csv -o new.tiles --quiet"],
    );
}

/// What was acknowledged is in the log until it is in the file.
#[test]
fn io_faults_in_a_checkpoint_leave_the_log_or_the_new_file() {
    let logged = [Point::new(1.5, 5.25), Point::new(70.0, -3.0)];
    let mut trial = Trial::new("checkpoint now.tiles", |folder| {
        write_town(folder);
        fs::write(folder.join("more.csv"), "1.5,5.25\n70,-3\n").unwrap();
        run(folder, "build points.csv -o old.tiles --tile-vertices 200 --quiet");
        run(
            folder,
            "build points.csv more.csv -o new.tiles --tile-vertices 200 --quiet",
        );
        log_points(&folder.join("old.tiles"), &logged);
    });
    let renew = |folder: &Path| {
        renew_now(folder);
        fs::copy(folder.join("old.tiles.log"), folder.join("now.tiles.log")).unwrap();
    };
    trial.all(renew, |folder, _, succeeded, context| {
        let is_new = is_like(folder, "now.tiles", "new.tiles");
        let is_old = is_like(folder, "now.tiles", "old.tiles");
        assert!(is_new || !succeeded && is_old, "{context}");
        run(folder, "checkpoint now.tiles");
        assert!(is_like(folder, "now.tiles", "new.tiles"), "{context}");
        assert!(!folder.join("now.tiles.log").exists(), "{context}");
        run(folder, "verify --deep now.tiles");
    });
}

#[test]
fn io_faults_in_compacting_leave_the_old_or_the_new_file() {
    let mut trial = Trial::new("compact now.tiles", |folder| {
        write_town(folder);
        run(folder, "build points.csv -o old.tiles --tile-vertices 200 --quiet");
        run(folder, "constrain old.tiles --walls walls.csv --quiet");
        fs::copy(folder.join("old.tiles"), folder.join("new.tiles")).unwrap();
        run(folder, "compact new.tiles");
    });
    trial.all(renew_now, |folder, _, succeeded, context| {
        let found = fs::read(folder.join("now.tiles")).unwrap();
        let is_new = found == fs::read(folder.join("new.tiles")).unwrap();
        let is_old = found == fs::read(folder.join("old.tiles")).unwrap();
        assert!(is_new || !succeeded && is_old, "{context}");
    });
}

#[test]
fn io_faults_in_overviews_leave_a_file_with_all_or_none() {
    let mut trial = Trial::new("overviews now.tiles --quiet --threads 1", |folder| {
        write_town(folder);
        run(folder, "build points.csv -o old.tiles --tile-vertices 500 --quiet");
        fs::copy(folder.join("old.tiles"), folder.join("new.tiles")).unwrap();
        run(folder, "overviews new.tiles --quiet");
    });
    let renew = |folder: &Path| {
        let _ = fs::remove_dir_all(folder.join("now.tiles.overviews.partial"));
        renew_now(folder);
    };
    let overviews = |folder: &Path, file: &str| {
        let inspected = run(folder, &format!("inspect {file} --json"));
        serde_json::from_str::<serde_json::Value>(&inspected).unwrap()["overview_list"].clone()
    };
    trial.all(renew, |folder, _, succeeded, context| {
        let found = overviews(folder, "now.tiles");
        let is_new = found == overviews(folder, "new.tiles");
        let is_old = found == overviews(folder, "old.tiles");
        assert!(is_new || !succeeded && is_old, "{context}");
        run(folder, "verify now.tiles");
    });
}

#[test]
fn io_faults_in_queries_give_the_same_answer_or_an_error() {
    for args in [
        "query knn town.tiles --at 3.5,29.25 -k 2 --csv",
        "query path town.tiles --from 1.5,1.5 --to 1.5,34 --certify --csv",
        "verify --deep town.tiles",
    ] {
        let mut trial = Trial::new(args, |folder| {
            write_town(folder);
            run(
                folder,
                "build points.csv --walls walls.csv --sites sites.csv -o town.tiles --tile-vertices 60 --quiet",
            );
        });
        let expected = run(trial.path(), args);
        trial.all(
            |_| (),
            |_, output, succeeded, context| {
                let found = String::from_utf8_lossy(&output.stdout);
                assert!(!succeeded || found == expected, "{context}: {found}");
            },
        );
    }
}
