//! Where the system refuses io_uring, as many containers do, files are read nevertheless, and the
//! reader reports why.
//!
//! A filter on system calls applies to the thread that sets it, and to all threads and programs
//! that this thread starts. So each test runs in a thread of its own.
#![cfg(target_os = "linux")]

#[path = "../support/errors.rs"]
mod errors;

use std::collections::BTreeMap;
use std::path::Path;
use std::thread;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::PointBatch;
use delaunay_tiles::io::Backend;
use delaunay_tiles::store::{OpenOptions, ReadError, TileReader};
use delaunay_tiles::{BuildOptions, Builder};
use errors::whole;
use seccompiler::{BpfProgram, SeccompAction, SeccompFilter, TargetArch};

const IO_URING_SETUP: i64 = 425;
const IO_URING_ENTER: i64 = 426;
const EPERM: u32 = 1;

/// Runs `test` in a thread in which the system call `call` fails with EPERM.
fn without(call: i64, test: impl FnOnce() + Send + 'static) {
    let refused = thread::spawn(move || {
        let filter: BpfProgram = SeccompFilter::new(
            BTreeMap::from([(call, Vec::new())]),
            SeccompAction::Allow,
            SeccompAction::Errno(EPERM),
            TargetArch::try_from(std::env::consts::ARCH).unwrap(),
        )
        .and_then(BpfProgram::try_from)
        .unwrap();
        seccompiler::apply_filter(&filter).unwrap();
        test();
    });
    refused.join().unwrap();
}

fn wait<T>(future: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_multi_thread().build().unwrap();
    runtime.block_on(future)
}

fn build(path: &Path) {
    let points: Vec<Point> = (0..400)
        .map(|i| Point::new(f64::from(i % 20), f64::from(i / 20)))
        .collect();
    let records = (0..400).collect();
    let z = Vec::new();
    wait(async {
        let mut builder = Builder::new(path, BuildOptions::default()).unwrap();
        builder.push(&PointBatch { records, points, z }).await.unwrap();
        builder.finish().await.unwrap();
    });
}

/// Opens a file with `backend`, and counts its triangles.
fn triangles(path: &Path, backend: Backend) -> Result<(u64, &'static str, Option<String>), ReadError> {
    wait(async {
        let reader = TileReader::open(path, OpenOptions::default().backend(backend)).await?;
        let digest = reader.recompute_digest().await?;
        Ok((
            digest.triangles.count,
            reader.backend(),
            reader.backend_note().map(str::to_owned),
        ))
    })
}

/// A single test, since the second refusal is remembered for the whole process.
#[test]
fn files_are_read_without_a_ring_and_the_reason_is_reported() {
    a_refused_ring_is_replaced_by_threads_unless_it_was_requested_by_name();
    a_ring_that_never_answers_is_replaced_by_threads();
}

fn a_refused_ring_is_replaced_by_threads_unless_it_was_requested_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("grid.tiles");
    without(IO_URING_SETUP, move || {
        build(&path);
        let (count, backend, note) = triangles(&path, Backend::Auto).unwrap();
        assert_eq!((count, backend), (2 * 19 * 19, "threads"));
        let note = note.unwrap();
        assert!(note.contains("io_uring") && note.contains("not permitted"), "{note}");

        let error = whole(&triangles(&path, Backend::Uring).unwrap_err());
        for part in [
            "grid.tiles",
            "refuses an io_uring",
            "not permitted",
            "threads and auto need none",
        ] {
            assert!(error.contains(part), "{part} is missing: {error}");
        }
        let (count, backend, note) = triangles(&path, Backend::Threads).unwrap();
        assert_eq!((count, backend, note), (2 * 19 * 19, "threads", None));
    });
}

fn a_ring_that_never_answers_is_replaced_by_threads() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("grid.tiles");
    without(IO_URING_ENTER, move || {
        build(&path);
        for _ in 0..2 {
            let (count, backend, note) = triangles(&path, Backend::Auto).unwrap();
            assert_eq!((count, backend), (2 * 19 * 19, "threads"));
            assert!(note.unwrap().contains("did nothing"));
        }
    });
}
