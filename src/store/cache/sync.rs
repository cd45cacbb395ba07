//! The lock and the tasks of the cache. The test `concurrency` puts a checker's in their place, and tries interleavings.

use std::future::Future;

pub(super) use parking_lot::Mutex;

/// Starts a task that goes on whoever waits for it. Panics without a tokio runtime.
pub(super) fn spawn(task: impl Future<Output = ()> + Send + 'static) {
    tokio::spawn(task);
}
