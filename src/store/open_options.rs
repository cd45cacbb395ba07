//! Options for opening a tile file, and where it is found again.

use std::path::PathBuf;

use crate::io::Backend;
use crate::store::cache::Cache;

/// Options for opening a tile file.
#[derive(Clone, Default)]
pub struct OpenOptions {
    pub(super) cache: Option<Cache>,
    pub(super) memory: Option<u64>,
    pub(super) backend: Option<Backend>,
}

impl OpenOptions {
    /// Uses this cache, which other readers may share. By default, a reader has a cache of its own,
    /// of 64 MiB or an eighth of the [memory](Self::memory) that it may use.
    #[must_use]
    pub fn cache(mut self, cache: &Cache) -> Self {
        self.cache = Some(cache.clone());
        self
    }

    /// Limits the memory of each pass over all tiles, in bytes. These passes are
    /// [`tiles`](crate::TileReader::tiles), [`recompute_digest`](crate::TileReader::recompute_digest),
    /// [`verify`](crate::TileReader::verify) and [`export`](crate::export::export).
    ///
    /// The directory counts, and so does the cache if the pass uses it. A pass works on as many
    /// tiles at once as fit, and fails with [`ReadError::Memory`](crate::ReadError::Memory) if not even one fits. The limit
    /// does not affect results. By default, a pass reads about 64 MiB ahead.
    ///
    /// The limit applies to one pass at a time. Threads and the allocator need a few mebibytes
    /// more.
    #[must_use]
    pub fn memory(mut self, bytes: u64) -> Self {
        self.memory = Some(bytes);
        self
    }

    /// Reads files on disk with this backend. By default, the environment variable
    /// [`DELAUNAY_TILES_IO`](crate::io::BACKEND_VARIABLE) selects the backend; if it is not set,
    /// the backend is [`Backend::Auto`].
    #[must_use]
    pub fn backend(mut self, backend: Backend) -> Self {
        self.backend = Some(backend);
        self
    }
}

/// Where a reader finds its file again.
pub(super) enum Origin {
    Path(PathBuf, Option<Backend>),
    #[cfg(feature = "object-store")]
    Url(String),
    /// Nowhere: it was given the source.
    Given,
}
