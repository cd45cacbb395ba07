//! A cache of values that one editor changes: what changed is written back before it goes.
//!
//! Comes in: how to write a value. Goes out: values to read, each as it was between two edits, and values to change, for one at a
//! time. Values that changed stay readable until they are saved; one that cannot be saved stays, dirty, and the error goes to
//! whoever needed the room, or to [`flush`](EditCache::flush).
//!
//! ```text
//!     edit ─▶ Edit ── dropped, changed ─▶ dirty ── no room, or flush ─▶ write_back ── saved ─▶ clean, and may go
//!                                          ▲                               │
//!                                          └──────────── failed ───────────┘
//! ```
//!
//! What `state.rs` draws is the same in full.

use std::future::Future;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

use futures::future::BoxFuture;
use futures::stream::{self, StreamExt, TryStreamExt};

use super::shelf::{Failure, Key, Pin, Pinned, Shelf, Telling, Value, Work};
use super::statistics::CacheStatistics;

type WriteBack<K, V, E> = Arc<dyn Fn(K, Arc<V>) -> BoxFuture<'static, Result<(), E>> + Send + Sync>;

/// A cache for one editor, who owns it. Flush it before it is dropped: what is dirty then is lost.
///
/// Memory is kept like this: whoever asks for a value waits until there is room, so that the cache exceeds its capacity only by
/// what is pinned, lent or being written for others, and by what grew since somebody asked last.
pub(crate) struct EditCache<K, V, E> {
    reader: EditReader<K, V, E>,
}

/// Reads what the editor changes.
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
    /// A value to read, as the last edit left it. Waits while it is being edited. It stays in the cache as long as the
    /// answer lives, which does not keep the editor from changing it: the editor gets a copy then.
    ///
    /// # Errors
    /// If it cannot be loaded, or what must go for it cannot be written.
    pub(crate) async fn read<F>(&self, key: K, load: impl FnOnce() -> F) -> Result<Pinned<K, V, E>, E>
    where
        F: Future<Output = Result<Arc<V>, E>> + Send + 'static,
    {
        let pinned = self.shelf.pin_or_load(key, load).await?;
        if let Err(error) = self.make_room().await {
            // Or each call that fails would leave its value.
            drop(pinned);
            self.shelf.with(|inner| inner.state.drop_clean());
            return Err(error);
        }
        Ok(pinned)
    }

    /// Writes what must go until there is room, or nothing is left that could go.
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
    /// A cache of up to `capacity` bytes. `write_back` saves a value, so that what is loaded from then on is that value; it is
    /// called for one state of a value at a time.
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

    /// A value to read, as [`EditReader::read`] gives it.
    ///
    /// # Errors
    /// As there.
    pub(crate) async fn read<F>(&self, key: K, load: impl FnOnce() -> F) -> Result<Pinned<K, V, E>, E>
    where
        F: Future<Output = Result<Arc<V>, E>> + Send + 'static,
    {
        self.reader.read(key, load).await
    }

    /// For others to read by.
    pub(crate) fn reader(&self) -> EditReader<K, V, E> {
        self.reader.clone()
    }

    /// A value to change, from the cache or by `load`. Who asks for it again before the [`Edit`] is dropped waits until then,
    /// be it the editor, who would wait for ever. Must be awaited within a tokio runtime.
    ///
    /// # Errors
    /// If it cannot be loaded, or what must go for it cannot be written.
    pub(crate) async fn edit<F>(&self, key: K, load: impl FnOnce() -> F) -> Result<Edit<'_, K, V, E>, E>
    where
        F: Future<Output = Result<Arc<V>, E>> + Send + 'static,
    {
        // Without the value, which would make the editor copy it.
        let pin = self.reader.read(key, load).await?.into_pin();
        loop {
            let lent = self.reader.shelf.with(|inner| match inner.state.lend(key) {
                Some(value) => Ok((value, inner.begin(Work::Edit, key).0)),
                None => Err(inner.waiting(Work::Edit, key)),
            });
            match lent {
                Ok((value, telling)) => {
                    return Ok(Edit {
                        cache: self,
                        key,
                        value,
                        changed: false,
                        _pin: pin,
                        _telling: telling,
                    });
                }
                // Another edit of the same value was faster.
                Err(Some(other)) => drop(other.await),
                Err(None) => {}
            }
        }
    }

    /// Writes all that is dirty, by number, so many at a time; it stays in the cache. No [`Edit`] can be alive meanwhile.
    ///
    /// # Errors
    /// The first of `write_back`; what has not been written then is still dirty.
    pub(crate) async fn flush(&mut self, at_once: usize) -> Result<(), E>
    where
        K: Ord,
    {
        let shelf = &self.reader.shelf;
        let mut keys = shelf.with(|inner| inner.state.unsaved());
        keys.sort_unstable();
        let reader = &self.reader;
        let writes = keys.into_iter().map(|key| async move {
            // A write that others began: if it fails, they have its error, and we try it once more.
            if let Some(other) = shelf.with(|inner| inner.waiting(Work::Write, key)) {
                drop(other.await);
            }
            reader.write(key, false).await
        });
        stream::iter(writes).buffered(at_once.max(1)).try_collect().await
    }

    /// What the cache has done so far.
    pub(crate) fn statistics(&self) -> CacheStatistics {
        self.reader.shelf.with(|inner| inner.state.statistics())
    }
}

/// A value that its editor may change. When this is dropped, others see the change, all of it at once.
pub(crate) struct Edit<'a, K: Key, V: Value, E: Failure> {
    value: Arc<V>,
    changed: bool,
    cache: &'a EditCache<K, V, E>,
    key: K,
    /// Dropped, it wakes up those who wait for the value.
    _telling: Telling<E>,
    _pin: Pin<K, V, E>,
}

impl<K: Key, V: Value, E: Failure> Deref for Edit<'_, K, V, E> {
    type Target = V;

    fn deref(&self) -> &V {
        &self.value
    }
}

impl<K: Key, V: Value + Clone, E: Failure> DerefMut for Edit<'_, K, V, E> {
    /// The value is dirty from here on.
    fn deref_mut(&mut self) -> &mut V {
        self.changed = true;
        Arc::make_mut(&mut self.value)
    }
}

impl<K: Key, V: Value, E: Failure> Drop for Edit<'_, K, V, E> {
    fn drop(&mut self) {
        self.cache.reader.shelf.with(|inner| {
            inner.end(Work::Edit, self.key);
            inner.state.give_back(self.key, Arc::clone(&self.value), self.changed);
        });
    }
}
