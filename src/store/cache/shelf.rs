//! The state of a cache behind a lock, and the loads under way.
//!
//! Concurrent misses of one key share a load. It runs in a task of its own, so that a caller who goes away cancels nobody
//! else's. Whatever comes of it, a value, an error, a panic, a runtime that is shut down, it ends in one place, the drop of its
//! [`UnderWay`], which changes the state first and then tells those who wait; they look at the state again. Errors are handed
//! to all who wait, and not kept. The lock is never held across an await, nor while values are dropped or tasks are started.

use std::collections::HashMap;
use std::future::Future;
use std::hash::Hash;
use std::ops::Deref;
use std::sync::Arc;

use futures::future::{FutureExt, Shared};
use tokio::sync::oneshot;

use super::state::{Content, State, Weight};
use super::sync::{Mutex, spawn};

/// What values go by.
pub(crate) trait Key: Copy + Eq + Hash + Send + Sync + 'static {}

impl<K: Copy + Eq + Hash + Send + Sync + 'static> Key for K {}

/// What a cache can hold, and share between threads.
pub(crate) trait Value: Weight + Send + Sync + 'static {}

impl<V: Weight + Send + Sync + 'static> Value for V {}

/// Why a value could not be loaded or written. Callers who share a load share its error.
pub(crate) trait Failure: Clone + Send + Sync + 'static {
    /// The task ended without a result: it panicked, or its runtime was shut down.
    const CANCELLED: Self;

    /// Whether it is that.
    fn is_cancelled(&self) -> bool;
}

/// What others wait for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Work {
    Load,
    Write,
    Edit,
}

/// The end of what is under way: an error in place of a result if there is none.
pub(super) type Waiting<E> = Shared<oneshot::Receiver<Result<(), E>>>;

/// Tells those who wait; dropped without a word, that there is no result.
pub(super) type Telling<E> = oneshot::Sender<Result<(), E>>;

/// A cache; clones share it.
pub(crate) struct Shelf<K, V, E> {
    inner: Arc<Mutex<Inner<K, V, E>>>,
}

pub(super) struct Inner<K, V, E> {
    pub(super) state: State<K, V>,
    under_way: HashMap<(Work, K), Waiting<E>>,
}

impl<K, V, E> Clone for Shelf<K, V, E> {
    fn clone(&self) -> Self {
        Self {
            inner: Arc::clone(&self.inner),
        }
    }
}

impl<K: Key, V: Value, E: Failure> Inner<K, V, E> {
    /// Says that others can wait for this.
    pub(super) fn begin(&mut self, work: Work, key: K) -> (Telling<E>, Waiting<E>) {
        let (telling, waiting) = oneshot::channel();
        let waiting = waiting.shared();
        self.under_way.insert((work, key), waiting.clone());
        (telling, waiting)
    }

    /// What to wait for, if it is under way.
    pub(super) fn waiting(&self, work: Work, key: K) -> Option<Waiting<E>> {
        self.under_way.get(&(work, key)).cloned()
    }

    /// What to do about a value that is pinned; if it is nowhere, a caller who can load it begins.
    fn step(&mut self, key: K, can_load: bool) -> Step<V, E> {
        match self.state.peek(&key) {
            Content::Here(value) => Step::Take(value),
            Content::Lent => Step::Wait(self.waiting(Work::Edit, key)),
            Content::Loading => Step::Wait(self.waiting(Work::Load, key)),
            Content::Absent if can_load => {
                self.state.begin_load(key);
                let (telling, waiting) = self.begin(Work::Load, key);
                Step::Load(telling, waiting)
            }
            Content::Absent => Step::Wait(None),
        }
    }

    pub(super) fn end(&mut self, work: Work, key: K) {
        self.under_way.remove(&(work, key));
    }
}

/// What to do about a value.
enum Step<V, E> {
    Take(Arc<V>),
    Wait(Option<Waiting<E>>),
    Load(Telling<E>, Waiting<E>),
}

impl<K: Key, V: Value, E: Failure> Shelf<K, V, E> {
    pub(crate) fn new(capacity: usize) -> Self {
        Self {
            inner: Arc::new(Mutex::new(Inner {
                state: State::new(capacity),
                under_way: HashMap::new(),
            })),
        }
    }

    /// Looks at the state or changes it. What goes from the cache is dropped when the lock is released.
    pub(super) fn with<R>(&self, change: impl FnOnce(&mut Inner<K, V, E>) -> R) -> R {
        let mut inner = self.inner.lock();
        let result = change(&mut inner);
        let gone = inner.state.take_gone();
        drop(inner);
        drop(gone);
        result
    }

    /// The value, from the cache or by `load`. Must be awaited within a runtime.
    pub(crate) async fn get_or_load<F>(&self, key: K, load: impl FnOnce() -> F) -> Result<Arc<V>, E>
    where
        F: Future<Output = Result<Arc<V>, E>> + Send + 'static,
    {
        if let Some(value) = self.with(|inner| inner.state.get(&key)) {
            return Ok(value);
        }
        Ok(Arc::clone(&self.pin_or_load(key, load).await?.value))
    }

    /// The same, pinned.
    pub(crate) async fn pin_or_load<F>(&self, key: K, load: impl FnOnce() -> F) -> Result<Pinned<K, V, E>, E>
    where
        F: Future<Output = Result<Arc<V>, E>> + Send + 'static,
    {
        let mut load = Some(load);
        // From here on it stays, or stays awaited.
        let mut step = self.with(|inner| {
            inner.state.pin(key);
            inner.step(key, true)
        });
        let pin = Pin(self.clone(), key);
        loop {
            match (step, load.take()) {
                (Step::Take(value), _) => return Ok(Pinned { value, pin }),
                (Step::Load(telling, waiting), Some(load)) => {
                    let under_way = UnderWay::new(self, key, Outcome::Load(None), telling);
                    spawn(under_way.load(load()));
                    waiting.await.map_err(|_| E::CANCELLED)??;
                }
                (Step::Wait(Some(waiting)), unused) => {
                    // Whoever began may be gone with its runtime while ours is not: then we load ourselves.
                    if let Ok(result) = waiting.await {
                        result?;
                    }
                    load = unused;
                }
                (Step::Load(..) | Step::Wait(None), _) => return Err(E::CANCELLED),
            }
            step = self.with(|inner| inner.step(key, load.is_some()));
        }
    }

    /// Writes a dirty value, in a task of its own, and waits for it; `leaving`: because there is no room for it. If it is being
    /// written already or is not dirty any more, there is nothing to do.
    pub(super) async fn write<F>(&self, key: K, leaving: bool, write: impl FnOnce(Arc<V>) -> F) -> Result<(), E>
    where
        F: Future<Output = Result<(), E>> + Send + 'static,
    {
        let begun = self.with(|inner| {
            let value = inner.state.begin_write(key, leaving)?;
            Some((value, inner.begin(Work::Write, key)))
        });
        let Some((value, (telling, waiting))) = begun else {
            return Ok(());
        };
        let under_way = UnderWay::new(self, key, Outcome::Write { saved: false }, telling);
        spawn(under_way.write(write(value)));
        waiting.await.map_err(|_| E::CANCELLED)?
    }
}

/// Keeps a value in the cache, or on its way there.
pub(super) struct Pin<K: Key, V: Value, E: Failure>(Shelf<K, V, E>, K);

impl<K: Key, V: Value, E: Failure> Drop for Pin<K, V, E> {
    fn drop(&mut self) {
        self.0.with(|inner| inner.state.unpin(self.1));
    }
}

/// A value that stays in the cache as long as this lives.
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

/// What has come of a task so far.
enum Outcome<V> {
    Load(Option<Arc<V>>),
    Write { saved: bool },
}

/// A load or write-back in its task. When it is dropped, by whatever end, it is over.
struct UnderWay<K: Key, V: Value, E: Failure> {
    shelf: Shelf<K, V, E>,
    key: K,
    outcome: Outcome<V>,
    result: Option<Result<(), E>>,
    telling: Option<Telling<E>>,
}

impl<K: Key, V: Value, E: Failure> UnderWay<K, V, E> {
    fn new(shelf: &Shelf<K, V, E>, key: K, outcome: Outcome<V>, telling: Telling<E>) -> Self {
        Self {
            shelf: shelf.clone(),
            key,
            outcome,
            result: None,
            telling: Some(telling),
        }
    }

    async fn load(mut self, load: impl Future<Output = Result<Arc<V>, E>>) {
        let result = load.await.map(|value| self.outcome = Outcome::Load(Some(value)));
        self.come_to(result);
    }

    async fn write(mut self, write: impl Future<Output = Result<(), E>>) {
        let result = write.await;
        self.outcome = Outcome::Write { saved: result.is_ok() };
        self.come_to(result);
    }

    /// What others learn. Of a runtime that ends, they do not.
    fn come_to(&mut self, result: Result<(), E>) {
        let cancelled = result.as_ref().is_err_and(Failure::is_cancelled);
        self.result = (!cancelled).then_some(result);
    }
}

impl<K: Key, V: Value, E: Failure> Drop for UnderWay<K, V, E> {
    fn drop(&mut self) {
        let key = self.key;
        self.shelf.with(|inner| match &mut self.outcome {
            Outcome::Load(value) => {
                inner.end(Work::Load, key);
                inner.state.end_load(key, value.take());
            }
            Outcome::Write { saved } => {
                inner.end(Work::Write, key);
                inner.state.end_write(key, *saved);
            }
        });
        if let (Some(telling), Some(result)) = (self.telling.take(), self.result.take()) {
            // Nobody may wait any more.
            let _ = telling.send(result);
        }
    }
}
