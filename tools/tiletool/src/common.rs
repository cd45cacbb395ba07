//! Functions that several commands share.

use std::fmt::Display;
use std::future::{Future, pending};
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, mpsc};
use std::thread::available_parallelism;

use anyhow::{Context, anyhow};
use bytesize::ByteSize;
use clap::Args;
use delaunay_tiles::input::Format;
use delaunay_tiles::io::start_thread;
use delaunay_tiles::shown;
use delaunay_tiles::store::{OpenOptions, ReadError, TileReader, pending_transactions};
use delaunay_tiles::{Progress, default_memory};
use serde::Serialize;
use tokio::runtime::Builder;
use tokio::signal::unix::{self, SignalKind, signal};
use tokio::sync::oneshot;

use crate::output::StandardOutput;
use crate::progress::{self, Bar};
use crate::{allocator, flags, limits, quiet};

/// Runs the asynchronous part of a command, with one worker thread per processor, or on this thread
/// if the system refuses threads.
pub fn block_on<T>(future: impl Future<Output = anyhow::Result<T>>) -> anyhow::Result<T> {
    let workers = available_parallelism().map_or(1, usize::from);
    // A runtime panics if it is refused a thread.
    let mut runtime = match limits::can_start(workers) {
        true => Builder::new_multi_thread(),
        false => Builder::new_current_thread(),
    };
    runtime.worker_threads(workers);
    let runtime = runtime.enable_all().build().context("cannot start the runtime")?;
    let done = runtime.block_on(future);
    // Operations that nothing waits for must not delay the end of the process.
    runtime.shutdown_background();
    done
}

/// Runs the asynchronous part of a command, as [`block_on`] does, and shows how long `what` takes, unless it
/// is done within a second.
pub fn wait_for<T>(what: &'static str, future: impl Future<Output = anyhow::Result<T>>) -> anyhow::Result<T> {
    let _bar = Bar::of_waiting(what);
    block_on(future)
}

/// Runs the asynchronous part of a command that prints answers as they come. Shows how long it takes as
/// [`wait_for`] does, unless the answers come on the terminal, where they show the progress.
pub fn answer<T>(future: impl Future<Output = anyhow::Result<T>>) -> anyhow::Result<T> {
    match io::stdout().is_terminal() {
        true => block_on(future),
        false => wait_for("answering", future),
    }
}

/// Runs long work on a thread of its own, or on this one if the system refuses a thread.
pub async fn on_thread<T: Send + 'static>(
    name: &str,
    work: impl FnOnce() -> anyhow::Result<T> + Send + 'static,
) -> anyhow::Result<T> {
    let work = Arc::new(Mutex::new(Some(work)));
    let for_thread = Arc::clone(&work);
    match begin(name, move || take(&for_thread)?()) {
        Ok(done) => done.await,
        Err(_) => take(&work)?(),
    }
}

fn take<F>(work: &Mutex<Option<F>>) -> anyhow::Result<F> {
    let work = work.lock().ok().and_then(|mut work| work.take());
    work.context("the work was taken already")
}

/// Starts long work on a thread of its own. Returns a future of its result.
///
/// # Errors
/// Fails if the system refuses a thread.
pub fn begin<T: Send + 'static>(
    name: &str,
    work: impl FnOnce() -> anyhow::Result<T> + Send + 'static,
) -> anyhow::Result<impl Future<Output = anyhow::Result<T>>> {
    let (reply, answer) = oneshot::channel();
    // The receiver may be gone. Then the result is not needed.
    start_thread(name, move || drop(reply.send(work())))?;
    Ok(async { answer.await.context("a worker thread failed")? })
}

/// The memory that a command may use.
#[derive(Args, Clone, Copy, Debug)]
pub struct MemoryArgs {
    /// Memory limit, such as 512MiB or 2GB [default: a quarter of the available memory]
    ///
    /// The available memory is the smallest of the machine's memory, the limit of the cgroup and
    /// the limits of the process.
    #[arg(long, value_name = "BYTES")]
    memory: Option<ByteSize>,
}

impl MemoryArgs {
    /// Opens a tile file for a command that reads it once or twice and keeps to this memory.
    pub async fn open(self, path: &Path) -> anyhow::Result<TileReader> {
        self.open_beside(path, 0).await
    }

    /// Opens a tile file for a command that needs `others` bytes of this memory for other purposes.
    pub async fn open_beside(self, path: &Path, others: u64) -> anyhow::Result<TileReader> {
        allocator::keep_to(self.bytes());
        let memory = self.bytes().saturating_sub(others);
        open(path, OpenOptions::default().memory(memory)).await
    }

    /// Returns the memory in bytes.
    pub fn bytes(self) -> u64 {
        self.memory.map_or_else(default_memory, |memory| memory.as_u64())
    }
}

/// Returns the URL that stands in the place of a path, if one does.
pub fn url(path: &Path) -> Option<&str> {
    path.to_str().filter(|path| path.contains("://"))
}

/// Opens a tile file, by its path or by a URL of a web server or an object store.
pub async fn open(path: &Path, options: OpenOptions) -> anyhow::Result<TileReader> {
    match url(path) {
        Some(url) => open_url(url, options).await,
        None => {
            let reader = open_file(path, options).await?;
            say_what_is_pending(path, &reader).await;
            Ok(reader)
        }
    }
}

/// Opens a tile file on disk, whatever is in its log.
pub async fn open_file(path: &Path, options: OpenOptions) -> anyhow::Result<TileReader> {
    TileReader::open(path, options).await.map_err(|error| match error {
        ReadError::Invalid { .. } if Format::from_path(path).is_some() => {
            anyhow!("{error}; to make one: tiletool build {} -o FILE.tiles", shown(path))
        }
        error => error.into(),
    })
}

/// Says that there are transactions in the log of a file, which are not in the file.
async fn say_what_is_pending(path: &Path, reader: &TileReader) {
    let file = shown(path);
    match pending_transactions(path, reader).await {
        Ok(0) => {}
        Ok(pending) => note(format_args!(
            "{} of the log of {file} {} not in it yet: tiletool checkpoint {file}",
            counted(pending, "transaction", "transactions"),
            if pending == 1 { "is" } else { "are" },
        )),
        Err(error) => note(format_args!("{:#}", anyhow::Error::new(error))),
    }
}

/// Returns the number of transactions in the log of a tile file that are not in the file yet; `None` if it
/// is not known, as of files elsewhere.
pub async fn pending_in_log(path: &Path, reader: &TileReader) -> Option<u64> {
    match url(path) {
        Some(_) => None,
        None => pending_transactions(path, reader).await.ok(),
    }
}

#[cfg(feature = "object-store")]
async fn open_url(url: &str, options: OpenOptions) -> anyhow::Result<TileReader> {
    Ok(TileReader::open_url(url, options).await?)
}

#[cfg(not(feature = "object-store"))]
async fn open_url(url: &str, _: OpenOptions) -> anyhow::Result<TileReader> {
    anyhow::bail!("{url}: this tiletool reads only local files; build it with `--features object-store` to read URLs")
}

/// Returns a future that is ready when Ctrl-C or SIGTERM has asked the tool to end. Both are caught
/// from the call on, not from the first poll: otherwise a signal that comes early ends the process at
/// once, without removing unfinished files. Must be called within a runtime.
pub fn interrupted() -> impl Future<Output = ()> {
    let [mut asked, mut terminated] = [SignalKind::interrupt(), SignalKind::terminate()].map(|kind| signal(kind).ok());
    async move {
        tokio::select! {
            () = received(&mut asked) => {}
            () = received(&mut terminated) => {}
        }
    }
}

/// Waits for a signal, forever if it cannot be caught.
async fn received(signal: &mut Option<unix::Signal>) {
    match signal {
        Some(signal) => _ = signal.recv().await,
        None => pending().await,
    }
}

/// Waits for a build or a part of it. Ctrl-C or SIGTERM cancels it, and `stop` then wakes it up.
pub async fn until_interrupted<T>(
    building: impl Future<Output = anyhow::Result<T>>,
    progress: &Progress,
    stop: impl Fn(),
) -> anyhow::Result<T> {
    tokio::pin!(building);
    loop {
        tokio::select! {
            built = &mut building => break built,
            // A second one ends the tool without waiting until the work is saved.
            () = interrupted() => if progress.is_cancelled() {
                anyhow::bail!("interrupted");
            } else {
                progress.cancel();
                stop();
            }
        }
    }
}

/// Returns a flag that Ctrl-C or SIGTERM sets. A command that checks it can remove its unfinished
/// files.
pub fn interruption() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    let (ready, caught) = mpsc::channel::<()>();
    // Without a thread or a runtime, Ctrl-C ends the process at once, and the next run cleans up.
    let _ = start_thread("interruption", move || {
        let Ok(runtime) = Builder::new_current_thread().enable_all().build() else {
            return;
        };
        runtime.block_on(async {
            let interrupted = interrupted();
            drop(ready);
            interrupted.await;
        });
        flag.store(true, Ordering::Relaxed);
    });
    // Ends when the other end is dropped: signals are then caught, or never will be.
    _ = caught.recv();
    stop
}

/// Prints a value as JSON on one line. An error says that `what` could not be written.
pub fn print_json(what: &'static str, value: &impl Serialize) -> anyhow::Result<()> {
    let mut text = serde_json::to_string(value)?;
    text.push('\n');
    print_bytes(what, text.as_bytes())
}

/// Prints text for people. Control characters are escaped, so the text cannot control the terminal.
/// An error says that `what` could not be written.
pub fn print(what: &'static str, text: &str) -> anyhow::Result<()> {
    print_bytes(what, shown::message(text).as_bytes())
}

/// Prints a summary of what a command did, as [`print()`] does, unless the tool is quiet.
pub fn print_summary(what: &'static str, text: &str) -> anyhow::Result<()> {
    match quiet::is_set() {
        true => Ok(()),
        false => print(what, text),
    }
}

/// Writes bytes to standard output. An error says that `what` could not be written.
pub fn print_bytes(what: &'static str, bytes: &[u8]) -> anyhow::Result<()> {
    let mut out = StandardOutput::of(what);
    out.write_all(bytes)?;
    Ok(out.flush()?)
}

/// Prints a line for people to standard error, with the tool's flags for the library's options, and
/// with control characters escaped. A closed standard error is not a failure.
pub fn say(line: impl Display) {
    let line = flags::in_message(&line.to_string());
    drop(progress::apart(|| writeln!(io::stderr(), "{}", shown::message(&line))));
}

/// Prints a line to standard error, as [`say`] does, unless the tool is quiet.
pub fn tell(line: impl Display) {
    if !quiet::is_set() {
        say(line);
    }
}

/// Prints a note to standard error, as [`say`] does, unless the tool is quiet.
pub fn note(note: impl Display) {
    tell(format_args!("note: {note}"));
}

/// Returns a path as text on one line, with control characters escaped.
pub fn shown(path: &Path) -> String {
    shown::path(path)
}

/// Returns whether the error says that the reader of the output closed it, which is not a failure.
pub fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let io = error.root_cause().downcast_ref::<io::Error>();
    io.is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}

/// Formats a number with a space between groups of three digits: `1 234 567`.
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

/// Formats a number with its noun: `1 tile`, `2 000 tiles`.
pub fn counted(number: u64, one: &str, many: &str) -> String {
    format!("{} {}", thousands(number), if number == 1 { one } else { many })
}

/// Returns `part / whole`, or 0 if `whole` is 0.
pub fn share(part: u64, whole: u64) -> f64 {
    if whole == 0 { 0.0 } else { part as f64 / whole as f64 }
}

/// Formats a number of bytes for people: `1.5 MiB`.
pub fn bytes(number: u64) -> String {
    bytesize::ByteSize::b(number).display().iec().to_string()
}

/// Formats a cell of a CSV table, in quotes if necessary.
pub fn cell(text: &str) -> String {
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}

/// Returns the name of a file without its folder.
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
    fn thousands_are_separated_by_spaces() {
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
