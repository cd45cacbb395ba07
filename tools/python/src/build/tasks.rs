//! Builds whose blocks are conquered by tasks.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use delaunay_tiles::{BlockTasks, InputTasks, TaskOptions, TaskStore};
use pyo3::prelude::*;
use tiletool::task::reading;

use crate::error::{Failure, Outcome};
use crate::reader::url_of;
use crate::runtime::{runtime, work_or_cancel};

/// Conquers a block of the build of a file, or of an address in an object store, with at most `memory`
/// bytes; without it, with the memory that is available. Returns the number of its points, and the bytes
/// that were read and written.
#[pyfunction]
pub fn conquer(
    py: Python<'_>,
    file: PathBuf,
    block: u32,
    memory: Option<u64>,
    threads: usize,
) -> PyResult<(u64, u64, u64)> {
    let runtime = runtime()?;
    let options = TaskOptions {
        memory: memory.unwrap_or(TaskOptions::default().memory),
        threads,
    };
    if let Some(url) = url_of(&file) {
        let store = TaskStore::at(url)?;
        // Until a block is complete, nothing of it is in the store.
        let folder = std::env::temp_dir();
        let conquer = |runtime: &tokio::runtime::Runtime| Ok(runtime.block_on(store.conquer(block, options, &folder))?);
        let done = work_or_cancel(py, conquer, |_| Ok(()), || {})?;
        return Ok((done.points, done.bytes_read, done.bytes_written));
    }
    let tasks = py.detach(|| -> Outcome<BlockTasks> {
        let _inside = runtime.enter();
        Ok(BlockTasks::open(file)?)
    })?;
    let progress = Arc::clone(tasks.progress());
    let conquer = |runtime: &tokio::runtime::Runtime| Ok(runtime.block_on(tasks.conquer(block, options))?);
    let done = work_or_cancel(py, conquer, |_| Ok(()), || progress.cancel())?;
    Ok((done.points, done.bytes_read, done.bytes_written))
}

/// Distributes the points of an input of the build of a file, with at most `memory` bytes; without it, with the
/// memory that is available. Returns their number, and the bytes that were written.
#[pyfunction]
pub fn distribute(
    py: Python<'_>,
    file: PathBuf,
    input: u32,
    memory: Option<u64>,
    threads: usize,
) -> PyResult<(u64, u64)> {
    let memory = memory.unwrap_or(TaskOptions::default().memory);
    let stop = AtomicBool::new(false);
    let distribute = |_: &tokio::runtime::Runtime| {
        let tasks = InputTasks::open(&file)?;
        reading::distribute(&tasks, input, (memory, threads), &stop).map_err(Failure::of_build)
    };
    let done = work_or_cancel(py, distribute, |_| Ok(()), || stop.store(true, Ordering::Relaxed))?;
    Ok((done.points, done.bytes_written))
}
