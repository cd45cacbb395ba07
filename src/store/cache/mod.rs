//! An LRU cache of tiles, limited in bytes and shared by readers.
//!
//! Concurrent misses of the same tile share one load.
//!
//! ```text
//!     Cache (tiles, read-only)    EditCache (any values, changed and written back)
//!          └──────────┬──────────────────┘
//!                   Shelf         the lock; each load and write-back in a task of its own,
//!                     │           shared by all callers that wait for it
//!                 CacheState      which values are held, pinned or dirty, and which is
//!                                 evicted next; no lock, no tasks, no I/O
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
use super::{FileId, Page, ReadError, Tile, TileId};

/// The key of a tile in a cache.
///
/// It contains the generation of the tile's entry, because a file that was changed in place has
/// different tiles under the same numbers; what did not change is found by readers of all
/// generations. Checksums distinguish copies of a file that were changed differently.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct TileKey {
    pub(crate) file: FileId,
    pub(crate) generation: u32,
    pub(crate) tile: TileId,
    /// The checksums of the core, the border and the component table.
    pub(crate) crcs: [u32; 3],
}

/// The key of a page of a directory in a cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct PageKey {
    pub(crate) file: FileId,
    pub(crate) offset: u64,
    pub(crate) crc: u32,
}

/// The share of the capacity that is added for pages of directories.
const PAGES_SHARE: usize = 16;
/// The minimum number of bytes for pages of directories.
const LEAST_FOR_PAGES: usize = 256 << 10;

impl Weight for Page {
    fn weight(&self) -> usize {
        self.byte_size()
    }
}

impl Weight for Tile {
    fn weight(&self) -> usize {
        self.byte_size()
    }
}

/// A cache of tiles, limited in bytes.
///
/// Clones share the same cache, and readers of several files may share one. Tiles that were used
/// more than once are kept longer than tiles that were used once, so a scan does not evict the
/// tiles that queries use. Tiles that are [pinned](super::TileReader::pin) are never evicted; if
/// they alone take more bytes than the capacity, the cache exceeds its capacity.
///
/// Besides, it holds pages of the files' directories: up to a sixteenth of its capacity, and at
/// least 256 KiB.
#[derive(Clone)]
pub struct Cache {
    shelf: Shelf<TileKey, Tile, ReadError>,
    pages: Shelf<PageKey, Page, ReadError>,
}

impl fmt::Debug for Cache {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Cache")
            .field("capacity", &self.capacity())
            .field("statistics", &self.statistics())
            .finish()
    }
}

/// A tile that stays in its cache until this value is dropped.
pub struct PinnedTile(Pinned<TileKey, Tile, ReadError>);

impl PinnedTile {
    /// Returns the tile, which may outlive the pin.
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
    /// Creates a cache of up to `capacity` bytes of tiles. With 0, it holds pinned tiles only.
    #[must_use]
    pub fn new(capacity: usize) -> Self {
        Self {
            shelf: Shelf::new(capacity),
            pages: Shelf::new((capacity / PAGES_SHARE).max(LEAST_FOR_PAGES)),
        }
    }

    /// Returns the capacity in bytes. Pinned tiles may exceed it.
    #[must_use]
    pub fn capacity(&self) -> usize {
        self.shelf.with(|inner| inner.state.capacity())
    }

    /// Returns the statistics since the cache was created.
    #[must_use]
    pub fn statistics(&self) -> CacheStatistics {
        self.shelf.with(|inner| inner.state.statistics())
    }

    /// Returns the tile if it is in the cache.
    pub(crate) fn get(&self, key: TileKey) -> Option<Arc<Tile>> {
        self.shelf.with(|inner| inner.state.get(&key))
    }

    /// Returns the tile from the cache, or loads it with `load`, and pins it. An error is passed to
    /// every caller that waits for the load, and is not cached.
    pub(crate) async fn pin_or_load<F>(&self, key: TileKey, load: impl FnOnce() -> F) -> Result<PinnedTile, ReadError>
    where
        F: Future<Output = Result<Arc<Tile>, ReadError>> + Send + 'static,
    {
        Ok(PinnedTile(self.shelf.pin_or_load(key, load).await?))
    }

    /// Returns the tile if it is in the cache. This does not count as a use.
    pub(crate) fn peek(&self, key: TileKey) -> Option<Arc<Tile>> {
        match self.shelf.with(|inner| inner.state.peek(&key)) {
            Content::Here(tile) => Some(tile),
            _ => None,
        }
    }

    /// Returns a page of a directory if it is in the cache.
    pub(crate) fn page(&self, key: PageKey) -> Option<Arc<Page>> {
        self.pages.with(|inner| inner.state.get(&key))
    }

    /// Returns a page of a directory from the cache, or loads it with `load`.
    pub(crate) async fn load_page<F>(&self, key: PageKey, load: impl FnOnce() -> F) -> Result<Arc<Page>, ReadError>
    where
        F: Future<Output = Result<Arc<Page>, ReadError>> + Send + 'static,
    {
        self.pages.get_or_load(key, load).await
    }

    /// Returns a page of a directory if it is in the cache. This does not count as a use.
    pub(crate) fn peek_page(&self, key: PageKey) -> Option<Arc<Page>> {
        match self.pages.with(|inner| inner.state.peek(&key)) {
            Content::Here(page) => Some(page),
            _ => None,
        }
    }
}
