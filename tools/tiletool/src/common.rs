//! What several commands need.

use std::fmt::Display;
use std::future::Future;
use std::io::{self, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::available_parallelism;

use anyhow::Context;
use bytesize::ByteSize;
use clap::Args;
use delaunay_tiles::default_memory;
use delaunay_tiles::io::start_thread;
use delaunay_tiles::shown;
use delaunay_tiles::store::{OpenOptions, TileReader};
use serde::Serialize;
use tokio::runtime::Builder;
use tokio::sync::oneshot;

use crate::{allocator, limits};

/// Runs a command's asynchronous part: on a thread for each processor, or on this one where the system refuses others.
pub fn block_on<T>(future: impl Future<Output = anyhow::Result<T>>) -> anyhow::Result<T> {
    let workers = available_parallelism().map_or(1, usize::from);
    // A runtime panics where it is refused a thread.
    let mut runtime = match limits::can_start(workers) {
        true => Builder::new_multi_thread(),
        false => Builder::new_current_thread(),
    };
    runtime.worker_threads(workers);
    let runtime = runtime.enable_all().build().context("cannot start the runtime")?;
    let done = runtime.block_on(future);
    // Operations nobody waits for any more must not hold up the end.
    runtime.shutdown_background();
    done
}

/// Does what takes long on a thread of its own, or here if the system refuses one.
pub async fn on_thread<T: Send + 'static>(
    name: &str,
    work: impl FnOnce() -> anyhow::Result<T> + Send + 'static,
) -> anyhow::Result<T> {
    let work = Arc::new(Mutex::new(Some(work)));
    let theirs = Arc::clone(&work);
    match begin(name, move || take(&theirs)?()) {
        Ok(done) => done.await,
        Err(_) => take(&work)?(),
    }
}

fn take<F>(work: &Mutex<Option<F>>) -> anyhow::Result<F> {
    let work = work.lock().ok().and_then(|mut work| work.take());
    work.context("the work is done already")
}

/// Begins what takes long on a thread of its own.
pub fn begin<T: Send + 'static>(
    name: &str,
    work: impl FnOnce() -> anyhow::Result<T> + Send + 'static,
) -> anyhow::Result<impl Future<Output = anyhow::Result<T>>> {
    let (reply, answer) = oneshot::channel();
    // Whoever asked may have gone away; then nobody needs the answer.
    start_thread(name, move || drop(reply.send(work())))?;
    Ok(async { answer.await.context("a thread broke down")? })
}

/// How much memory a command may use.
#[derive(Args, Clone, Copy, Debug)]
pub struct MemoryArgs {
    /// Memory to use, as 512MiB or 2GB; by default a quarter of what there is
    #[arg(long, value_name = "SIZE")]
    memory: Option<ByteSize>,
}

impl MemoryArgs {
    /// Opens a tile file for a command that passes over it once or twice, and keeps to this memory.
    pub async fn open(self, path: &Path) -> anyhow::Result<TileReader> {
        self.open_beside(path, 0).await
    }

    /// Opens a tile file for a command that needs so many bytes of this memory for other things.
    pub async fn open_beside(self, path: &Path, others: u64) -> anyhow::Result<TileReader> {
        allocator::keep_to(self.bytes());
        let memory = self.bytes().saturating_sub(others);
        open(path, OpenOptions::default().memory(memory)).await
    }

    /// How many bytes it is.
    pub fn bytes(self) -> u64 {
        self.memory.map_or_else(default_memory, |memory| memory.as_u64())
    }
}

/// Opens a tile file, which may lie on a web server or in an object store.
pub async fn open(path: &Path, options: OpenOptions) -> anyhow::Result<TileReader> {
    match path.to_str().filter(|path| path.contains("://")) {
        Some(url) => open_url(url, options).await,
        None => Ok(TileReader::open(path, options).await?),
    }
}

#[cfg(feature = "object-store")]
async fn open_url(url: &str, options: OpenOptions) -> anyhow::Result<TileReader> {
    Ok(TileReader::open_url(url, options).await?)
}

#[cfg(not(feature = "object-store"))]
async fn open_url(url: &str, _: OpenOptions) -> anyhow::Result<TileReader> {
    anyhow::bail!("{url}: this tiletool reads files only; build it with `--features object-store`")
}

/// A flag that Ctrl-C sets, so that no half-written file is left behind.
pub fn interruption() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    // Without a thread or a runtime Ctrl-C ends the process at once, and the next run cleans up.
    let _ = start_thread("interruption", move || {
        let Ok(runtime) = Builder::new_current_thread().enable_all().build() else {
            return;
        };
        if runtime.block_on(tokio::signal::ctrl_c()).is_ok() {
            flag.store(true, Ordering::Relaxed);
        }
    });
    stop
}

/// Prints an object as JSON, on one line.
pub fn print_json(value: &impl Serialize) -> anyhow::Result<()> {
    let mut text = serde_json::to_string(value)?;
    text.push('\n');
    Ok(io::stdout().write_all(text.as_bytes())?)
}

/// Prints lines for people. Nothing in them commands a terminal, wherever it comes from.
pub fn print(text: &str) -> anyhow::Result<()> {
    Ok(io::stdout().write_all(shown::message(text).as_bytes())?)
}

/// Says something on standard error; nothing in it commands a terminal. Whoever has closed that
/// wants to hear nothing, which is no failure.
pub fn say(line: impl Display) {
    drop(writeln!(io::stderr(), "{}", shown::message(&line.to_string())));
}

/// A path, to be shown on one line.
pub fn shown(path: &Path) -> String {
    shown::path(path)
}

/// Whether whoever read our output has gone away, which is no failure.
pub fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let io = error.root_cause().downcast_ref::<io::Error>();
    io.is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}

/// A number with its thousands apart: `1 234 567`.
pub fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let first = digits.len() % 3;
    let mut groups: Vec<&str> = Vec::new();
    if first > 0 {
        groups.push(&digits[..first]);
    }
    groups.extend((first..digits.len()).step_by(3).map(|at| &digits[at..at + 3]));
    groups.join(" ")
}

/// A quotient that is 0 where there is nothing to divide by.
pub fn share(part: u64, whole: u64) -> f64 {
    if whole == 0 { 0.0 } else { part as f64 / whole as f64 }
}

/// Bytes for people: `1.5 MiB`.
pub fn bytes(number: u64) -> String {
    bytesize::ByteSize::b(number).display().iec().to_string()
}

/// A cell of a table of comma-separated values, in quotes where it must be.
pub fn cell(text: &str) -> String {
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}

/// The name of a file without its folder.
pub fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_are_apart() {
        for (number, text) in [
            (0, "0"),
            (12, "12"),
            (999, "999"),
            (1000, "1 000"),
            (1_234_567, "1 234 567"),
        ] {
            assert_eq!(thousands(number), text);
        }
    }
}
