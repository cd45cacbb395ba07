//! Threads that compute, and that work ahead.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc;
use std::{iter, thread};

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

/// Passes items to `take`. With more than one thread, they are made on another one, called `name`:
/// `room` of them may wait, beside the one that was made last.
pub(crate) fn for_each_ahead<T: Send, E>(
    threads: usize,
    name: &str,
    room: usize,
    items: impl Iterator<Item = T> + Send,
    mut take: impl FnMut(T) -> Result<(), E>,
) -> Result<(), E> {
    let items = Mutex::new(items);
    let next = || items.lock().next();
    thread::scope(|scope| {
        let (ahead, incoming) = mpsc::sync_channel(room);
        let next = &next;
        let make = move || iter::from_fn(next).all(|item| ahead.send(item).is_ok());
        match (threads > 1).then(|| start_scoped(scope, name, make)) {
            Some(Ok(_)) => incoming.iter().try_for_each(&mut take),
            // If the system refuses the thread, this one does its work.
            _ => iter::from_fn(next).try_for_each(&mut take),
        }
    })
}
