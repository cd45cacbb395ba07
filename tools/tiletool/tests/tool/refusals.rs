//! Commands when the system refuses threads, open files, memory or longer files. Each command gives
//! its usual result, or ends with exit code 1 and one line.
//!
//! With a limit of three threads in a container, commands once hung for ever after a panic, because
//! the runtime queued work for threads that were never started. With two, four or five threads they
//! panicked. With 6 to 9 open files they panicked, and with 15 they did not fall back from an
//! io_uring to threads. With a small address space they aborted.

#![cfg(target_os = "linux")]

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::support::{after, errors, faults, names, run, tiletool, within_a_minute};

/// The commands to run. The first one writes no files in the folder.
const COMMANDS: [&str; 6] = [
    "digest --recompute t.tiles",
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

/// Runs all commands with each limit. Returns for each limit how many commands ended with an error.
fn all_or_nothing<L: Copy + std::fmt::Debug>(limits: &[L], limited: impl Fn(Command, L) -> Command) -> Vec<usize> {
    all_or_nothing_but(None, limits, limited)
}

/// Does the same, and accepts one line of the C library, with this beginning, before that of the tool.
fn all_or_nothing_but<L: Copy + std::fmt::Debug>(
    foreign: Option<&str>,
    limits: &[L],
    limited: impl Fn(Command, L) -> Command,
) -> Vec<usize> {
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
            let context = format!("{args}, limit {limit:?}: {}: {}", output.status, errors(&output));
            match output.status.code() {
                Some(0) => assert_eq!(String::from_utf8_lossy(&output.stdout), expected, "{context}"),
                Some(1) => {
                    let errors = errors(&output);
                    let (of_c_library, of_tool): (Vec<&str>, Vec<&str>) = errors
                        .lines()
                        .partition(|line| foreign.is_some_and(|beginning| line.starts_with(beginning)));
                    assert!(of_c_library.len() <= 1, "{context}");
                    assert!(
                        matches!(of_tool[..], [line] if line.starts_with("error: ")),
                        "{context}"
                    );
                    assert!(!errors.contains("internal error"), "{context}");
                    assert!(!path.join("out.ply").exists(), "{context}");
                    *refused += 1;
                }
                _ => panic!("{context}"),
            }
        }
        run(path, args);
        assert_eq!(names(path), good, "{args}: files are left");
    }
    refused
}

#[test]
fn with_few_threads_commands_succeed_or_end_with_an_error() {
    let limits: Vec<u64> = (0..=14).collect();
    let refused = all_or_nothing(&limits, |mut tool, threads| {
        tool.env("LD_PRELOAD", faults())
            .env("FAULTS_THREADS", threads.to_string());
        tool
    });
    assert_eq!(refused[0], COMMANDS.len(), "every command needs a thread");
    assert_eq!(refused[5..], [0; 10], "five threads are enough");
}

#[test]
fn with_few_open_files_commands_succeed_or_end_with_an_error() {
    let limits: Vec<u64> = (4..=40).collect();
    let refused = all_or_nothing(&limits, |tool, files| after(&format!("ulimit -n {files}"), &tool));
    assert_eq!(refused[..3], [COMMANDS.len(); 3]);
    let at_15 = limits.iter().position(|&files| files == 15).unwrap();
    assert_eq!(refused[at_15..], vec![0; limits.len() - at_15]);
}

#[test]
fn refused_memory_is_an_error_and_not_an_abort() {
    for option in ["v", "d"] {
        let limited = |tool: Command, mebibytes: u64| after(&format!("ulimit -{option} {}", mebibytes << 10), &tool);
        // With less, the program cannot be loaded.
        let loads = |&mebibytes: &u64| {
            let version = limited(tiletool(Path::new("."), "--version"), mebibytes).output();
            version.unwrap().status.success()
        };
        let least = (1..100).find(loads).unwrap();
        let limits: Vec<u64> = (least..least + 32).step_by(3).chain([80, 120, 200]).collect();
        // The C library, which has no memory for a thread's variables, says so before it aborts.
        all_or_nothing_but(Some("Fatal glibc error: "), &limits, limited);
    }
}

#[test]
fn a_limit_on_file_size_is_an_error_and_not_a_signal() {
    let refused = all_or_nothing(&[0, 1, 8, 30, 100_000], |tool, blocks| {
        after(&format!("ulimit -f {blocks}"), &tool)
    });
    assert!(refused[0] >= 3 && refused[4] == 0, "{refused:?}");
}

#[test]
fn a_limit_on_processor_time_is_an_error_and_not_a_signal() {
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
