//! The LRU tile cache: a number of bytes, shared by readers; concurrent misses of one tile share one load.
//!
//! ```text
//!     Cache (tiles, to read)     EditCache (anything, to change and write back)
//!          └──────────┬──────────────────┘
//!                   Shelf    the lock; loads and write-backs, each in a task of its own, shared by all who wait
//!                     │
//!                   State    what is held, pinned, dirty, and what goes next; no lock, no task, no I/O
//! ```

mod edit;
mod shelf;
mod state;
mod statistics;
mod sync;
#[cfg(test)]
mod tests;

use std::fmt;
use std::future::Future;
use std::ops::Deref;
use std::sync::Arc;

pub use statistics::CacheStatistics;

pub(crate) use edit::{Edit as EditLease, EditCache};
pub(crate) use shelf::{Failure, Pinned as EditPin};
pub(crate) use state::Weight;

use self::shelf::{Pinned, Shelf};
use self::state::Content;
use super::{FileId, ReadError, Tile, TileId};

/// What a tile goes by: a file that was changed in place has other tiles under the same numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct TileKey {
    pub(crate) file: FileId,
    pub(crate) generation: u64,
    pub(crate) tile: TileId,
}

impl Weight for Tile {
    fn weight(&self) -> usize {
        self.byte_size()
    }
}

/// A cache of tiles, counted in bytes. Clones share it, and so may readers of several files.
///
/// Tiles that were used again outlive those that were used once, so that a scan does not flush what queries keep hot. Tiles
/// that are [pinned](super::TileReader::pin) stay; if these alone take more than the capacity, so does the cache.
#[derive(Clone)]
pub struct Cache {
    shelf: Shelf<TileKey, Tile, ReadError>,
}

impl fmt::Debug for Cache {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Cache")
            .field("capacity", &self.capacity())
            .field("statistics", &self.statistics())
            .finish()
    }
}

/// A tile that stays in its cache as long as this lives.
pub struct PinnedTile(Pinned<TileKey, Tile, ReadError>);

impl PinnedTile {
    /// The tile, which may outlive the pin.
    #[must_use]
    pub fn tile(&self) -> Arc<Tile> {
        Arc::clone(&self.0)
    }
}

impl Deref for PinnedTile {
    type Target = Tile;

    fn deref(&self) -> &Tile {
        &self.0
    }
}

impl Failure for ReadError {
    const CANCELLED: Self = Self::Cancelled;

    fn is_cancelled(&self) -> bool {
        matches!(self, Self::Cancelled)
    }
}

impl Cache {
    /// A cache that holds up to `capacity` bytes of tiles; with 0 it holds none but those that are pinned.
    #[must_use]
    pub fn new(capacity: usize) -> Self {
        Self {
            shelf: Shelf::new(capacity),
        }
    }

    /// Bytes of tiles that it holds at most, but for those that are pinned.
    #[must_use]
    pub fn capacity(&self) -> usize {
        self.shelf.with(|inner| inner.state.capacity())
    }

    /// What the cache has done so far.
    #[must_use]
    pub fn statistics(&self) -> CacheStatistics {
        self.shelf.with(|inner| inner.state.statistics())
    }

    /// The tile, from the cache or by `load`. Errors are handed to all who wait, and not kept.
    pub(crate) async fn get_or_load<F>(&self, key: TileKey, load: impl FnOnce() -> F) -> Result<Arc<Tile>, ReadError>
    where
        F: Future<Output = Result<Arc<Tile>, ReadError>> + Send + 'static,
    {
        self.shelf.get_or_load(key, load).await
    }

    /// The same, pinned.
    pub(crate) async fn pin_or_load<F>(&self, key: TileKey, load: impl FnOnce() -> F) -> Result<PinnedTile, ReadError>
    where
        F: Future<Output = Result<Arc<Tile>, ReadError>> + Send + 'static,
    {
        Ok(PinnedTile(self.shelf.pin_or_load(key, load).await?))
    }

    /// The tile if it is there; does not count as a use.
    pub(crate) fn peek(&self, key: TileKey) -> Option<Arc<Tile>> {
        match self.shelf.with(|inner| inner.state.peek(&key)) {
            Content::Here(tile) => Some(tile),
            _ => None,
        }
    }
}
