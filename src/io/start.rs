//! Starting of threads, which the system may refuse.

use std::io;
use std::thread::{Builder, JoinHandle, Scope, ScopedJoinHandle};

/// Starts a thread with this name.
///
/// # Errors
/// Fails if the system refuses a thread. The error says which limits to raise.
pub fn start_thread<T: Send + 'static>(
    name: &str,
    work: impl FnOnce() -> T + Send + 'static,
) -> io::Result<JoinHandle<T>> {
    Builder::new().name(name.to_owned()).spawn(work).map_err(refused)
}

/// Starts a thread with this name within a scope. Fails as [`start_thread`] does.
pub(crate) fn start_scoped<'scope, T: Send + 'scope>(
    scope: &'scope Scope<'scope, '_>,
    name: &str,
    work: impl FnOnce() -> T + Send + 'scope,
) -> io::Result<ScopedJoinHandle<'scope, T>> {
    let started = Builder::new().name(name.to_owned()).spawn_scoped(scope, work);
    started.map_err(refused)
}

fn refused(error: io::Error) -> io::Error {
    let message = format!(
        "the system refuses a thread: {error}; raise the limit on threads (ulimit -u, pids of the container) or on \
         memory (ulimit -v)"
    );
    io::Error::new(error.kind(), message)
}
