//! The I/O backend that reads a file, and what the tool says about it.

use std::path::Path;
use std::process::Command;

use crate::support::{complaint, printed};
use serde_json::Value;
use tempfile::TempDir;

/// Returns a command that runs the tool with a backend.
fn tiletool(folder: &Path, backend: &str, args: &str) -> Command {
    let mut command = crate::support::tiletool(folder, args);
    command.env("DELAUNAY_TILES_IO", backend);
    command
}

/// Returns what `inspect --json` says about the backend and why it was chosen.
fn inspect(folder: &Path, backend: &str) -> (String, Option<String>) {
    let json: Value = serde_json::from_str(&printed(tiletool(folder, backend, "inspect p.tiles --json"))).unwrap();
    let note = json["backend_note"].as_str().map(str::to_owned);
    (json["backend"].as_str().unwrap().to_owned(), note)
}

fn scratch() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    printed(tiletool(
        folder.path(),
        "",
        "generate uniform -n 1000 --seed 1 -o p.f64",
    ));
    printed(tiletool(folder.path(), "", "build p.f64 -o p.tiles"));
    folder
}

#[test]
fn the_environment_variable_chooses_the_backend() {
    let scratch = scratch();
    let folder = scratch.path();
    assert_eq!(inspect(folder, "threads"), ("threads".to_owned(), None));
    assert_eq!(inspect(folder, ""), inspect(folder, "auto"));
    let digest = |backend| printed(tiletool(folder, backend, "digest --recompute p.tiles"));
    assert_eq!(digest("threads"), digest("auto"));
    let error = complaint(tiletool(folder, "Threads", "inspect p.tiles"), 1);
    for part in ["p.tiles", "DELAUNAY_TILES_IO", "`Threads`", "auto, uring or threads"] {
        assert!(error.contains(part), "{part} is missing: {error}");
    }
}

/// A filter on system calls applies to the thread that sets it and to the programs that it starts.
/// So the test runs in a thread of its own.
#[cfg(target_os = "linux")]
#[test]
fn inspect_says_why_there_is_no_io_uring() {
    std::thread::spawn(without_a_ring).join().unwrap();
}

#[cfg(target_os = "linux")]
fn without_a_ring() {
    use std::collections::BTreeMap;

    use seccompiler::{BpfProgram, SeccompAction, SeccompFilter};

    const IO_URING_SETUP: i64 = 425;
    let scratch = scratch();
    let folder = scratch.path();
    let filter: BpfProgram = SeccompFilter::new(
        BTreeMap::from([(IO_URING_SETUP, Vec::new())]),
        SeccompAction::Allow,
        SeccompAction::Errno(1),
        std::env::consts::ARCH.try_into().unwrap(),
    )
    .and_then(BpfProgram::try_from)
    .unwrap();
    seccompiler::apply_filter(&filter).unwrap();

    let (backend, note) = inspect(folder, "auto");
    assert_eq!(backend, "threads");
    assert!(note.unwrap().contains("refuses an io_uring: Operation not permitted"));
    let summary = printed(tiletool(folder, "auto", "inspect p.tiles"));
    assert!(summary.contains("threads: the system refuses an io_uring"), "{summary}");
    printed(tiletool(folder, "auto", "verify --deep p.tiles"));

    let error = complaint(tiletool(folder, "uring", "inspect p.tiles"), 1);
    assert!(
        error.contains("p.tiles") && error.contains("the backends threads and auto need none"),
        "{error}"
    );
}
