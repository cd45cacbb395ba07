//! A cache of values that one editor changes. A changed value is written back before it is evicted.
//!
//! The cache is created with a function that writes a value back. It hands out values to read, each
//! in the state between two edits, and values to change, one editor at a time. A changed value
//! stays readable until it is saved. A value that cannot be saved stays in the cache, dirty, and
//! the error is returned to the caller that needed the room, or from [`flush`](EditCache::flush).
//!
//! ```text
//!  edit ─▶ Edit ── dropped, changed ─▶ dirty ── no room, or flush ─▶ write_back ── saved ─▶ clean
//!                                       ▲                               │
//!                                       └──────────── failed ───────────┘
//! ```
//!
//! A clean value may be evicted. `state.rs` has the complete diagram.

use std::future::Future;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

use futures::future::BoxFuture;
use futures::stream::{self, StreamExt, TryStreamExt};

use super::shelf::{Failure, Key, Notifier, Pin, Pinned, Shelf, TaskKind, Value};
use super::statistics::CacheStatistics;

type WriteBack<K, V, E> = Arc<dyn Fn(K, Arc<V>) -> BoxFuture<'static, Result<(), E>> + Send + Sync>;

/// A cache for one editor, who owns it. Flush it before it is dropped: values that are dirty then
/// are lost.
///
/// A request for a value waits until there is room. The cache therefore exceeds its capacity only
/// by values that are pinned, lent or being written for other callers, and by values that grew
/// since the last request.
pub(crate) struct EditCache<K, V, E> {
    reader: EditReader<K, V, E>,
}

/// A handle that reads the values that the editor changes.
pub(crate) struct EditReader<K, V, E> {
    shelf: Shelf<K, V, E>,
    write_back: WriteBack<K, V, E>,
}

impl<K, V, E> Clone for EditReader<K, V, E> {
    fn clone(&self) -> Self {
        Self {
            shelf: self.shelf.clone(),
            write_back: Arc::clone(&self.write_back),
        }
    }
}

impl<K: Key, V: Value, E: Failure> EditReader<K, V, E> {
    /// Returns a value to read, as the last edit left it. Waits while the value is being edited.
    ///
    /// The value stays in the cache until the result is dropped. This does not prevent edits: an
    /// edit then works on a copy.
    ///
    /// # Errors
    ///
    /// Returns an error if the value cannot be loaded, or if a value that must be evicted for it
    /// cannot be written.
    pub(crate) async fn read<F>(&self, key: K, load: impl FnOnce() -> F) -> Result<Pinned<K, V, E>, E>
    where
        F: Future<Output = Result<Arc<V>, E>> + Send + 'static,
    {
        let pinned = self.shelf.pin_or_load(key, load).await?;
        if let Err(error) = self.make_room().await {
            // Otherwise each failing call would leave its value in the cache.
            drop(pinned);
            self.shelf.with(|inner| inner.state.drop_clean());
            return Err(error);
        }
        Ok(pinned)
    }

    /// Writes back and evicts values until there is room, or until nothing is left that can be
    /// evicted.
    async fn make_room(&self) -> Result<(), E> {
        while let Some(key) = self.shelf.with(|inner| inner.state.make_room()) {
            self.write(key, true).await?;
        }
        Ok(())
    }

    async fn write(&self, key: K, leaving: bool) -> Result<(), E> {
        let write = |value| (self.write_back)(key, value);
        self.shelf.write(key, leaving, write).await
    }
}

impl<K: Key, V: Value + Clone, E: Failure> EditCache<K, V, E> {
    /// Creates a cache of up to `capacity` bytes.
    ///
    /// `write_back` saves a value, so that later loads return that value. It is called for one
    /// state of a value at a time.
    pub(crate) fn new(
        capacity: usize,
        write_back: impl Fn(K, Arc<V>) -> BoxFuture<'static, Result<(), E>> + Send + Sync + 'static,
    ) -> Self {
        Self {
            reader: EditReader {
                shelf: Shelf::new(capacity),
                write_back: Arc::new(write_back),
            },
        }
    }

    /// Returns a value to read, like [`EditReader::read`].
    ///
    /// # Errors
    ///
    /// Returns the same errors as [`EditReader::read`].
    pub(crate) async fn read<F>(&self, key: K, load: impl FnOnce() -> F) -> Result<Pinned<K, V, E>, E>
    where
        F: Future<Output = Result<Arc<V>, E>> + Send + 'static,
    {
        self.reader.read(key, load).await
    }

    /// Returns a handle through which others can read.
    pub(crate) fn reader(&self) -> EditReader<K, V, E> {
        self.reader.clone()
    }

    /// Returns a value to change, from the cache or loaded with `load`. Must be awaited within a
    /// tokio runtime.
    ///
    /// Requests for the same value wait until the [`Edit`] is dropped. The editor itself would wait
    /// forever.
    ///
    /// # Errors
    ///
    /// Returns an error if the value cannot be loaded, or if a value that must be evicted for it
    /// cannot be written.
    pub(crate) async fn edit<F>(&self, key: K, load: impl FnOnce() -> F) -> Result<Edit<'_, K, V, E>, E>
    where
        F: Future<Output = Result<Arc<V>, E>> + Send + 'static,
    {
        // Keep only the pin: with the value too, the edit would have to copy it.
        let pin = self.reader.read(key, load).await?.into_pin();
        loop {
            let lent = self.reader.shelf.with(|inner| match inner.state.lend(key) {
                Some(value) => Ok((value, inner.begin(TaskKind::Edit, key).0)),
                None => Err(inner.completion(TaskKind::Edit, key)),
            });
            match lent {
                Ok((value, notifier)) => {
                    return Ok(Edit {
                        cache: self,
                        key,
                        value,
                        changed: false,
                        _pin: pin,
                        _notifier: notifier,
                    });
                }
                // Another edit of the same value was faster.
                Err(Some(other)) => drop(other.await),
                Err(None) => {}
            }
        }
    }

    /// Writes all dirty values in the order of their keys, up to `concurrent_writes` at a time. The
    /// values stay in the cache. No [`Edit`] can be alive meanwhile.
    ///
    /// # Errors
    ///
    /// Returns the first error of `write_back`. Values that were not written by then are still
    /// dirty.
    pub(crate) async fn flush(&mut self, concurrent_writes: usize) -> Result<(), E>
    where
        K: Ord,
    {
        let shelf = &self.reader.shelf;
        let mut keys = shelf.with(|inner| inner.state.unsaved());
        keys.sort_unstable();
        let reader = &self.reader;
        let writes = keys.into_iter().map(|key| async move {
            // Another caller's write: if it fails, that caller gets its error, and this one tries
            // again.
            if let Some(other) = shelf.with(|inner| inner.completion(TaskKind::Write, key)) {
                drop(other.await);
            }
            reader.write(key, false).await
        });
        stream::iter(writes)
            .buffered(concurrent_writes.max(1))
            .try_collect()
            .await
    }

    /// Returns the statistics since the cache was created.
    pub(crate) fn statistics(&self) -> CacheStatistics {
        self.reader.shelf.with(|inner| inner.state.statistics())
    }
}

/// A value that its editor may change. When it is dropped, others see all its changes at once.
pub(crate) struct Edit<'a, K: Key, V: Value, E: Failure> {
    value: Arc<V>,
    changed: bool,
    cache: &'a EditCache<K, V, E>,
    key: K,
    /// Wakes the callers that wait for the value, when it is dropped.
    _notifier: Notifier<E>,
    _pin: Pin<K, V, E>,
}

impl<K: Key, V: Value, E: Failure> Deref for Edit<'_, K, V, E> {
    type Target = V;

    fn deref(&self) -> &V {
        &self.value
    }
}

impl<K: Key, V: Value + Clone, E: Failure> DerefMut for Edit<'_, K, V, E> {
    /// Returns the value for a change, which marks it dirty.
    fn deref_mut(&mut self) -> &mut V {
        self.changed = true;
        Arc::make_mut(&mut self.value)
    }
}

impl<K: Key, V: Value, E: Failure> Drop for Edit<'_, K, V, E> {
    fn drop(&mut self) {
        self.cache.reader.shelf.with(|inner| {
            inner.end(TaskKind::Edit, self.key);
            inner.state.give_back(self.key, Arc::clone(&self.value), self.changed);
        });
    }
}
