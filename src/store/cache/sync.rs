//! The lock and the task spawner of the cache.
//!
//! The `concurrency` tests replace this file by the primitives of a model checker, which tries
//! interleavings.

use std::future::Future;

pub(super) use parking_lot::Mutex;

/// Spawns a task that runs to its end even if nobody waits for it.
///
/// # Panics
///
/// Panics outside a tokio runtime.
pub(super) fn spawn(task: impl Future<Output = ()> + Send + 'static) {
    tokio::spawn(task);
}
