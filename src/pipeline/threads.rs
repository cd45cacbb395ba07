//! Threads that compute.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread;

use parking_lot::Mutex;

use crate::io::start_scoped;
use crate::pipeline::error::BuildError;

/// Runs `work` on `threads` threads. A panic in one thread calls `abort`, so that the others do not
/// wait for it.
///
/// Returns an error if a thread panicked.
pub(crate) fn on_threads(threads: usize, work: impl Fn() + Sync, abort: impl Fn() + Sync) -> Result<(), BuildError> {
    let panicked = Mutex::new(None);
    thread::scope(|scope| {
        for number in 0..threads.max(1) {
            let (work, abort, panicked) = (&work, &abort, &panicked);
            let run = move || {
                if let Err(panic) = catch_unwind(AssertUnwindSafe(work)) {
                    let text = panic.downcast_ref::<String>().map(String::as_str);
                    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
                    *panicked.lock() = Some(text.unwrap_or("a thread panicked").to_owned());
                    abort();
                }
            };
            if let Err(error) = start_scoped(scope, &format!("tile-compute-{number}"), run) {
                tracing::info!(%error, "could not start a computing thread");
                if number == 0 {
                    // If no thread can be started, this thread does the work.
                    run();
                }
                break;
            }
        }
    });
    match panicked.into_inner() {
        Some(text) => Err(BuildError::Internal(text)),
        None => Ok(()),
    }
}
