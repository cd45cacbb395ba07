//! The LRU tile cache: a number of bytes, shared by readers; concurrent misses of one tile share one load.

use std::collections::HashMap;
use std::future::Future;
use std::sync::Arc;

use futures::future::{BoxFuture, FutureExt, Shared};
use lru::LruCache;
use parking_lot::Mutex;

use super::{FileId, ReadError, Tile, TileId};

type Key = (FileId, TileId);
type Loaded = Result<Arc<Tile>, ReadError>;

/// A cache of tiles, counted in bytes. Clones share it, and so may readers of several files.
#[derive(Clone)]
pub struct Cache {
    state: Arc<Mutex<State>>,
}

struct State {
    capacity: usize,
    bytes: usize,
    tiles: LruCache<Key, Arc<Tile>>,
    /// Loads under way, each in a task of its own: a caller that goes away cancels nobody else's.
    loads: HashMap<Key, Shared<BoxFuture<'static, Loaded>>>,
    statistics: CacheStatistics,
}

/// What a cache has done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CacheStatistics {
    /// Tiles that were there.
    pub hits: u64,
    /// Tiles that had to be loaded.
    pub misses: u64,
    /// Callers that waited for a load that was under way.
    pub shared_loads: u64,
    /// Tiles that had to go.
    pub evictions: u64,
    /// Bytes held now.
    pub bytes: usize,
}

impl Cache {
    /// A cache that holds up to `capacity` bytes of tiles; with 0 it holds none.
    #[must_use]
    pub fn new(capacity: usize) -> Self {
        Self {
            state: Arc::new(Mutex::new(State {
                capacity,
                bytes: 0,
                tiles: LruCache::unbounded(),
                loads: HashMap::new(),
                statistics: CacheStatistics::default(),
            })),
        }
    }

    /// Bytes of tiles that it holds at most.
    #[must_use]
    pub fn capacity(&self) -> usize {
        self.state.lock().capacity
    }

    /// What the cache has done so far.
    #[must_use]
    pub fn statistics(&self) -> CacheStatistics {
        let state = self.state.lock();
        CacheStatistics {
            bytes: state.bytes,
            ..state.statistics
        }
    }

    /// The tile, from the cache or by `load`. Errors are handed to all who wait, and not kept.
    pub(crate) async fn get_or_load<F>(&self, key: Key, load: impl FnOnce() -> F) -> Loaded
    where
        F: Future<Output = Loaded> + Send + 'static,
    {
        let mut load = Some(load);
        loop {
            let (waiting, mine) = {
                let mut state = self.state.lock();
                if let Some(tile) = state.tiles.get(&key).cloned() {
                    state.statistics.hits += 1;
                    return Ok(tile);
                }
                match (state.loads.get(&key).cloned(), load.take()) {
                    (Some(others), unused) => {
                        state.statistics.shared_loads += 1;
                        load = unused;
                        (others, false)
                    }
                    (None, Some(load)) => {
                        state.statistics.misses += 1;
                        let task = tokio::spawn(finish(self.clone(), key, load()));
                        let load = async move { task.await.unwrap_or_else(|_| Err(ReadError::Cancelled)) };
                        let load = load.boxed().shared();
                        state.loads.insert(key, load.clone());
                        (load, true)
                    }
                    (None, None) => return Err(ReadError::Cancelled),
                }
            };
            let loaded = waiting.clone().await;
            if matches!(loaded, Err(ReadError::Cancelled)) {
                // A task that is dropped before it runs, with its runtime, does not end its load itself.
                let mut state = self.state.lock();
                if state.loads.get(&key).is_some_and(|load| load.ptr_eq(&waiting)) {
                    state.loads.remove(&key);
                }
                if !mine {
                    // Its runtime is gone and ours is not, so we load ourselves.
                    continue;
                }
            }
            return loaded;
        }
    }

    /// The tile if it is there; does not count as a use.
    pub(crate) fn peek(&self, key: Key) -> Option<Arc<Tile>> {
        self.state.lock().tiles.peek(&key).cloned()
    }
}

/// Ends the load that `loads` has under `key`, whether it ran to its end, panicked or was cancelled.
struct LoadEnds {
    cache: Cache,
    key: Key,
}

impl Drop for LoadEnds {
    fn drop(&mut self) {
        self.cache.state.lock().loads.remove(&self.key);
    }
}

async fn finish(cache: Cache, key: Key, load: impl Future<Output = Loaded>) -> Loaded {
    let ends = LoadEnds { cache, key };
    let tile = load.await?;
    ends.cache.state.lock().insert(key, &tile);
    Ok(tile)
}

impl State {
    fn insert(&mut self, key: Key, tile: &Arc<Tile>) {
        let size = tile.byte_size();
        if size > self.capacity {
            return;
        }
        if let Some(old) = self.tiles.put(key, Arc::clone(tile)) {
            self.bytes -= old.byte_size();
        }
        self.bytes += size;
        while self.bytes > self.capacity {
            let Some((_, evicted)) = self.tiles.pop_lru() else {
                break;
            };
            self.bytes -= evicted.byte_size();
            self.statistics.evictions += 1;
        }
    }
}
