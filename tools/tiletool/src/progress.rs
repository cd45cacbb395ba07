//! The progress bar of a build: phase, tiles, points per second, time left. It is shown only on a
//! terminal.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use delaunay_tiles::io::start_thread;
use delaunay_tiles::{Phase, Progress};
use indicatif::{ProgressBar, ProgressStyle};

use crate::common::bytes;

/// A progress bar that follows a build until it is dropped.
pub struct BuildBar {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// Returns the bytes of the input that were read so far, and the total if it is known.
pub type InputProgress = Arc<dyn Fn() -> (u64, Option<u64>) + Send + Sync>;

impl BuildBar {
    /// Shows a bar on standard error, if that is a terminal.
    pub fn show(progress: Arc<Progress>, input: InputProgress) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let thread = std::io::stderr().is_terminal().then(|| {
            let stop = Arc::clone(&stop);
            start_thread("progress", move || follow(&progress, &input, &stop))
        });
        // Without a thread, no bar is shown.
        let thread = thread.and_then(Result::ok);
        Self { stop, thread }
    }
}

impl Drop for BuildBar {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A failure of the bar does not fail the build.
            let _ = thread.join();
        }
    }
}

fn follow(progress: &Progress, input: &InputProgress, stop: &AtomicBool) {
    let bar = ProgressBar::no_length();
    let style = "{prefix:8} {wide_bar} {percent:>3}%  {msg}  {eta} left";
    bar.set_style(ProgressStyle::with_template(style).unwrap_or_else(|_| ProgressStyle::default_bar()));
    let mut phase: Option<(Phase, Instant)> = None;
    while !stop.load(Ordering::Relaxed) {
        let (now, done, total) = progress.state();
        let began = match phase {
            Some((before, began)) if before == now => began,
            _ => {
                bar.reset();
                phase = Some((now, Instant::now()));
                Instant::now()
            }
        };
        bar.set_prefix(now.name());
        let (done, total) = match now {
            // The beginnings of files are read twice, so more than the total may be read.
            Phase::Read => match input() {
                (done, Some(total)) => (done.min(total), Some(total)),
                unknown => unknown,
            },
            _ => (done, Some(total)),
        };
        match total {
            Some(total) if total > 0 => bar.set_length(total),
            _ => bar.unset_length(),
        }
        bar.set_position(done);
        let rate = progress.points() as f64 / began.elapsed().as_secs_f64().max(1e-3);
        let detail = match now {
            Phase::Read => format!("{} read, ", bytes(done)),
            Phase::Borders => format!("{done} of {} tiles, ", total.unwrap_or(0)),
            _ => String::new(),
        };
        bar.set_message(format!("{detail}{:.2} M points/s", rate / 1e6));
        thread::sleep(Duration::from_millis(100));
    }
    bar.finish_and_clear();
}
