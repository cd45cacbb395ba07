//! Commands where the system refuses threads, open files, memory or longer files. Each does what it would do otherwise, or ends with
//! exit code 1 and one line.
//!
//! With a limit of three threads in a container commands hung for ever after a panic, since the runtime queued work for threads that were
//! never started. With two, four or five they panicked. With 6 to 9 open files they panicked, with 15 they did not fall back from a ring
//! to threads, and with little address space they aborted.

#![cfg(target_os = "linux")]

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::support::{after, errors, faults, names, run, tiletool, within_a_minute};

/// Of the commands the first one writes nothing in the folder.
const COMMANDS: [&str; 6] = [
    "digest t.tiles",
    "query knn t.tiles --at 3,3 --at 7,2 -k 3 --csv",
    "verify --deep t.tiles",
    "export t.tiles -o out.ply",
    "build p.csv --segments s.csv -o out.tiles --force --quiet --tile-vertices 60 --threads 2",
    "build p.csv -o out.tiles --force --quiet --tile-vertices 60 --memory 100KiB",
];

fn prepare(folder: &Path) {
    let points = (0..1600).map(|i| format!("{},{}\n", i % 40, f64::from(i / 40) + f64::from(i % 7) / 16.0));
    fs::write(folder.join("p.csv"), points.collect::<String>()).unwrap();
    fs::write(folder.join("s.csv"), "0,7,35,7\n0,14,35,14\n").unwrap();
    run(folder, "build p.csv -o t.tiles --quiet --tile-vertices 100");
}

/// Runs all commands with each limit. Returns how often each limit was heeded with an error.
fn all_or_nothing<L: Copy + std::fmt::Debug>(limits: &[L], limited: impl Fn(Command, L) -> Command) -> Vec<usize> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    prepare(path);
    let mut refused = vec![0; limits.len()];
    for args in COMMANDS {
        let _ = fs::remove_file(path.join("out.ply"));
        let expected = run(path, args);
        let good = names(path);
        for (&limit, refused) in limits.iter().zip(&mut refused) {
            let _ = fs::remove_file(path.join("out.ply"));
            let output = within_a_minute(limited(tiletool(path, args), limit));
            let story = format!("{args}, limit {limit:?}: {}: {}", output.status, errors(&output));
            match output.status.code() {
                Some(0) => assert_eq!(String::from_utf8_lossy(&output.stdout), expected, "{story}"),
                Some(1) => {
                    let errors = errors(&output);
                    assert!(errors.starts_with("error: ") && errors.lines().count() == 1, "{story}");
                    assert!(!errors.contains("internal error"), "{story}");
                    assert!(!path.join("out.ply").exists(), "{story}");
                    *refused += 1;
                }
                _ => panic!("{story}"),
            }
        }
        run(path, args);
        assert_eq!(names(path), good, "{args}: files stay behind");
    }
    refused
}

#[test]
fn without_enough_threads_commands_do_with_those_they_get_or_say_so() {
    let limits: Vec<u64> = (0..=14).collect();
    let refused = all_or_nothing(&limits, |mut tool, threads| {
        tool.env("LD_PRELOAD", faults())
            .env("FAULTS_THREADS", threads.to_string());
        tool
    });
    assert_eq!(refused[0], COMMANDS.len(), "no command does without a thread");
    assert_eq!(refused[5..], [0; 10], "five threads are enough");
}

#[test]
fn with_few_open_files_commands_read_by_threads_or_say_so() {
    let limits: Vec<u64> = (4..=40).collect();
    let refused = all_or_nothing(&limits, |tool, files| after(&format!("ulimit -n {files}"), &tool));
    assert_eq!(refused[..3], [COMMANDS.len(); 3]);
    let at_15 = limits.iter().position(|&files| files == 15).unwrap();
    assert_eq!(refused[at_15..], vec![0; limits.len() - at_15]);
}

#[test]
fn refused_memory_is_an_error_and_no_abort() {
    // In kibibytes. With less than the first the program is not loaded.
    let limits: Vec<u64> = (28..60).step_by(3).chain([80, 120, 200]).map(|mib| mib << 10).collect();
    for option in ["v", "d"] {
        all_or_nothing(&limits, |tool, kib| after(&format!("ulimit -{option} {kib}"), &tool));
    }
}

#[test]
fn a_file_that_may_not_grow_is_an_error_and_no_signal() {
    let refused = all_or_nothing(&[0, 1, 8, 30, 100_000], |tool, blocks| {
        after(&format!("ulimit -f {blocks}"), &tool)
    });
    assert!(refused[0] >= 3 && refused[4] == 0, "{refused:?}");
}

#[test]
fn processor_time_that_is_over_is_an_error_and_no_signal() {
    let folder = tempfile::tempdir().unwrap();
    let mut generate = tiletool(folder.path(), "generate uniform -n 1G -o out.f64");
    let mut child = generate.stderr(std::process::Stdio::piped()).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(300));
    let kill = format!("kill -s XCPU {}", child.id());
    assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(1));
    assert!(!folder.path().join("out.f64").exists());
    run(folder.path(), "generate uniform -n 10 -o out.f64");
    assert_eq!(names(folder.path()), ["out.f64"]);
}
