//! The state of a cache behind a lock, and the running loads and writes.
//!
//! Concurrent misses of one key share a load. The load runs in a task of its own, so a caller that
//! is dropped does not cancel the load for others. A task can end with a value, an error, a panic,
//! or because its runtime shuts down. Each of these ends in one place, the drop of its
//! [`RunningTask`], which first changes the state and then notifies the waiting callers; they read
//! the state again. An error is passed to all waiting callers and is not cached. The lock is never
//! held across an await, and not while values are dropped or tasks are spawned.

use std::collections::HashMap;
use std::future::Future;
use std::hash::Hash;
use std::ops::Deref;
use std::sync::Arc;

use futures::future::{FutureExt, Shared};
use tokio::sync::oneshot;

use super::state::{CacheState, Content, Weight};
use super::sync::{Mutex, spawn};

/// A key of a cache.
pub(crate) trait Key: Copy + Eq + Hash + Send + Sync + 'static {}

impl<K: Copy + Eq + Hash + Send + Sync + 'static> Key for K {}

/// A value that a cache can hold and share between threads.
pub(crate) trait Value: Weight + Send + Sync + 'static {}

impl<V: Weight + Send + Sync + 'static> Value for V {}

/// The reason why a value could not be loaded or written. Callers that share a load share its
/// error.
pub(crate) trait Failure: Clone + Send + Sync + 'static {
    /// The error of a task that ended without a result: it panicked, or its runtime shut down.
    const CANCELLED: Self;

    /// Returns whether the error is [`CANCELLED`](Self::CANCELLED).
    fn is_cancelled(&self) -> bool;
}

/// The kind of a task or edit that callers can wait for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum TaskKind {
    Load,
    Write,
    Edit,
}

/// Resolves when a task or edit ends, to its result, or to an error if it has none.
pub(super) type Completion<E> = Shared<oneshot::Receiver<Result<(), E>>>;

/// Sends the result to the waiting callers. Dropping it without sending means that there is no
/// result.
pub(super) type Notifier<E> = oneshot::Sender<Result<(), E>>;

/// A cache. Clones share it.
pub(crate) struct Shelf<K, V, E> {
    inner: Arc<Mutex<ShelfInner<K, V, E>>>,
}

pub(super) struct ShelfInner<K, V, E> {
    pub(super) state: CacheState<K, V>,
    running: HashMap<(TaskKind, K), Completion<E>>,
}

impl<K, V, E> Clone for Shelf<K, V, E> {
    fn clone(&self) -> Self {
        Self {
            inner: Arc::clone(&self.inner),
        }
    }
}

impl<K: Key, V: Value, E: Failure> ShelfInner<K, V, E> {
    /// Registers a task or edit, so that others can wait for it.
    pub(super) fn begin(&mut self, kind: TaskKind, key: K) -> (Notifier<E>, Completion<E>) {
        let (notifier, completion) = oneshot::channel();
        let completion = completion.shared();
        self.running.insert((kind, key), completion.clone());
        (notifier, completion)
    }

    /// Returns what to wait for, if the task or edit is running.
    pub(super) fn completion(&self, kind: TaskKind, key: K) -> Option<Completion<E>> {
        self.running.get(&(kind, key)).cloned()
    }

    /// Returns the next step to get a pinned value. If the value is absent and `can_load` is true,
    /// its load begins.
    fn next_step(&mut self, key: K, can_load: bool) -> PinStep<V, E> {
        match self.state.peek(&key) {
            Content::Here(value) => PinStep::Take(value),
            Content::Lent => PinStep::Wait(self.completion(TaskKind::Edit, key)),
            Content::Loading => PinStep::Wait(self.completion(TaskKind::Load, key)),
            Content::Absent if can_load => {
                self.state.begin_load(key);
                let (notifier, completion) = self.begin(TaskKind::Load, key);
                PinStep::Load(notifier, completion)
            }
            Content::Absent => PinStep::Wait(None),
        }
    }

    pub(super) fn end(&mut self, kind: TaskKind, key: K) {
        self.running.remove(&(kind, key));
    }
}

/// The next step to get a value.
enum PinStep<V, E> {
    Take(Arc<V>),
    Wait(Option<Completion<E>>),
    Load(Notifier<E>, Completion<E>),
}

impl<K: Key, V: Value, E: Failure> Shelf<K, V, E> {
    pub(crate) fn new(capacity: usize) -> Self {
        Self {
            inner: Arc::new(Mutex::new(ShelfInner {
                state: CacheState::new(capacity),
                running: HashMap::new(),
            })),
        }
    }

    /// Calls `change` with the locked state. Values that it evicts are dropped after the lock is
    /// released.
    pub(super) fn with<R>(&self, change: impl FnOnce(&mut ShelfInner<K, V, E>) -> R) -> R {
        let mut inner = self.inner.lock();
        let result = change(&mut inner);
        let gone = inner.state.take_gone();
        drop(inner);
        drop(gone);
        result
    }

    /// Returns the value from the cache, or loads it with `load`. Must be awaited within a runtime.
    pub(crate) async fn get_or_load<F>(&self, key: K, load: impl FnOnce() -> F) -> Result<Arc<V>, E>
    where
        F: Future<Output = Result<Arc<V>, E>> + Send + 'static,
    {
        if let Some(value) = self.with(|inner| inner.state.get(&key)) {
            return Ok(value);
        }
        // Boxed: loads are rare, and their state would move with every future that gets a value.
        let loaded = Box::pin(self.pin_or_load(key, load)).await?;
        Ok(Arc::clone(&loaded.value))
    }

    /// Returns the value like [`get_or_load`](Self::get_or_load), and pins it.
    pub(crate) async fn pin_or_load<F>(&self, key: K, load: impl FnOnce() -> F) -> Result<Pinned<K, V, E>, E>
    where
        F: Future<Output = Result<Arc<V>, E>> + Send + 'static,
    {
        let mut load = Some(load);
        // From here on the value stays in the cache, or its load stays awaited.
        let mut step = self.with(|inner| {
            inner.state.pin(key);
            inner.next_step(key, true)
        });
        let pin = Pin(self.clone(), key);
        loop {
            match (step, load.take()) {
                (PinStep::Take(value), _) => return Ok(Pinned { value, pin }),
                (PinStep::Load(notifier, completion), Some(load)) => {
                    let running = RunningTask::new(self, key, Outcome::Load(None), notifier);
                    spawn(running.load(load()));
                    completion.await.map_err(|_| E::CANCELLED)??;
                }
                (PinStep::Wait(Some(completion)), unused) => {
                    // The caller that began the load may be gone with its runtime while ours is
                    // alive: then we load the value ourselves.
                    if let Ok(result) = completion.await {
                        result?;
                    }
                    load = unused;
                }
                (PinStep::Load(..) | PinStep::Wait(None), _) => return Err(E::CANCELLED),
            }
            step = self.with(|inner| inner.next_step(key, load.is_some()));
        }
    }

    /// Writes a dirty value in a task of its own and waits for it. `leaving` is true if the value
    /// is written to make room. Does nothing if the value is already being written or is no longer
    /// dirty.
    pub(super) async fn write<F>(&self, key: K, leaving: bool, write: impl FnOnce(Arc<V>) -> F) -> Result<(), E>
    where
        F: Future<Output = Result<(), E>> + Send + 'static,
    {
        let begun = self.with(|inner| {
            let value = inner.state.begin_write(key, leaving)?;
            Some((value, inner.begin(TaskKind::Write, key)))
        });
        let Some((value, (notifier, completion))) = begun else {
            return Ok(());
        };
        let running = RunningTask::new(self, key, Outcome::Write { saved: false }, notifier);
        spawn(running.write(write(value)));
        completion.await.map_err(|_| E::CANCELLED)?
    }
}

/// Keeps a value pinned, in the cache or being loaded, until it is dropped.
pub(super) struct Pin<K: Key, V: Value, E: Failure>(Shelf<K, V, E>, K);

impl<K: Key, V: Value, E: Failure> Drop for Pin<K, V, E> {
    fn drop(&mut self) {
        self.0.with(|inner| inner.state.unpin(self.1));
    }
}

/// A value that stays in the cache until this is dropped.
pub(crate) struct Pinned<K: Key, V: Value, E: Failure> {
    value: Arc<V>,
    pin: Pin<K, V, E>,
}

impl<K: Key, V: Value, E: Failure> Pinned<K, V, E> {
    pub(super) fn into_pin(self) -> Pin<K, V, E> {
        self.pin
    }
}

impl<K: Key, V: Value, E: Failure> Deref for Pinned<K, V, E> {
    type Target = Arc<V>;

    fn deref(&self) -> &Arc<V> {
        &self.value
    }
}

/// The outcome of a task so far.
enum Outcome<V> {
    Load(Option<Arc<V>>),
    Write { saved: bool },
}

/// A load or write-back in its task. Dropping it ends it, whatever the reason.
struct RunningTask<K: Key, V: Value, E: Failure> {
    shelf: Shelf<K, V, E>,
    key: K,
    outcome: Outcome<V>,
    result: Option<Result<(), E>>,
    notifier: Option<Notifier<E>>,
}

impl<K: Key, V: Value, E: Failure> RunningTask<K, V, E> {
    fn new(shelf: &Shelf<K, V, E>, key: K, outcome: Outcome<V>, notifier: Notifier<E>) -> Self {
        Self {
            shelf: shelf.clone(),
            key,
            outcome,
            result: None,
            notifier: Some(notifier),
        }
    }

    async fn load(mut self, load: impl Future<Output = Result<Arc<V>, E>>) {
        let result = load.await.map(|value| self.outcome = Outcome::Load(Some(value)));
        self.set_result(result);
    }

    async fn write(mut self, write: impl Future<Output = Result<(), E>>) {
        let result = write.await;
        self.outcome = Outcome::Write { saved: result.is_ok() };
        self.set_result(result);
    }

    /// Sets the result that waiting callers receive. If the runtime ended, they receive none.
    fn set_result(&mut self, result: Result<(), E>) {
        let cancelled = result.as_ref().is_err_and(Failure::is_cancelled);
        self.result = (!cancelled).then_some(result);
    }
}

impl<K: Key, V: Value, E: Failure> Drop for RunningTask<K, V, E> {
    fn drop(&mut self) {
        let key = self.key;
        self.shelf.with(|inner| match &mut self.outcome {
            Outcome::Load(value) => {
                inner.end(TaskKind::Load, key);
                inner.state.end_load(key, value.take());
            }
            Outcome::Write { saved } => {
                inner.end(TaskKind::Write, key);
                inner.state.end_write(key, *saved);
            }
        });
        if let (Some(notifier), Some(result)) = (self.notifier.take(), self.result.take()) {
            // There may be no waiting callers left.
            let _ = notifier.send(result);
        }
    }
}
