//! Opens tile files and reads their tiles.

use std::io;
use std::path::Path;
use std::sync::Arc;

use bytes::Bytes;
use futures::future;

use crate::io::{Backend, ReadAt};
use crate::memory::FileShares;
use crate::store::borders_ahead::BorderAhead;
use crate::store::cache::{Cache, PinnedTile, TileKey};
use crate::store::error::ReadError;
use crate::store::format::damage::Damage;
use crate::store::format::directory::Directory;
use crate::store::format::entry::{Extent, TileEntry};
use crate::store::format::ids::TileId;
use crate::store::format::metadata::Metadata;
use crate::store::format::superblock::{FIRST_EXTENT, FileId, InForce, Superblock};
use crate::store::format::tile::Tile;
use crate::{io as files, shown};

/// Options for opening a tile file.
#[derive(Clone, Default)]
pub struct OpenOptions {
    cache: Option<Cache>,
    memory: Option<u64>,
    backend: Option<Backend>,
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
    /// [`tiles`](TileReader::tiles), [`digest`](TileReader::digest), [`verify`](TileReader::verify)
    /// and [`export`](crate::export::export).
    ///
    /// The directory counts, and so does the cache if the pass uses it. A pass works on as many
    /// tiles at once as fit, and fails with [`ReadError::Memory`] if not even one fits. The limit
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

/// An open tile file.
///
/// Clones share the file. They and their streams may be used from any task of a tokio runtime.
#[derive(Clone)]
pub struct TileReader {
    inner: Arc<ReaderInner>,
}

struct ReaderInner {
    name: Arc<str>,
    source: Arc<dyn ReadAt>,
    in_force: InForce,
    directory: Arc<Directory>,
    cache: Cache,
    memory: Option<u64>,
}

/// Reads and checks the superblock in force and the directory.
async fn read_directory(
    source: &impl ReadAt,
    name: &Arc<str>,
    memory: Option<u64>,
) -> Result<(InForce, Directory), ReadError> {
    let io = |what: &str| {
        let (file, what) = (Arc::clone(name), what.to_owned());
        move |error| ReadError::Io {
            file,
            what,
            source: Arc::new(error),
        }
    };
    let invalid = |reason: String| ReadError::Invalid {
        file: Arc::clone(name),
        reason,
    };
    let damaged = |damage: Damage| invalid(damage.into());
    let length = source.length();
    let head = source.read_at(0..length.min(FIRST_EXTENT)).await;
    let in_force = Superblock::choose(&head.map_err(io("the superblocks"))?).map_err(damaged)?;
    let superblock = &in_force.superblock;
    if superblock.file_length > length {
        let reason = format!("it is cut off: it has {length} of {} bytes", superblock.file_length);
        return Err(invalid(reason));
    }
    // While it is decoded, the directory is in memory twice.
    let needed = superblock.directory_length.saturating_mul(2);
    if let Some(allowed) = memory.filter(|&memory| needed > memory) {
        return Err(ReadError::Memory {
            file: Arc::clone(name),
            needed,
            allowed,
        });
    }
    let start = superblock.directory_offset;
    let bytes = source.read_at(start..start + superblock.directory_length).await;
    let bytes = bytes.map_err(io("the directory"))?;
    let directory =
        Directory::decode(&bytes, superblock).map_err(|damage| damaged(damage.of("its directory is damaged")))?;
    // The id is the key in caches: a file must not pass for another.
    if superblock.file_id != FileId::of(&bytes) {
        return Err(invalid("its id is not that of its directory".to_owned()));
    }
    Ok((in_force, directory))
}

impl TileReader {
    /// Opens a file.
    ///
    /// # Errors
    ///
    /// Returns an error if the file cannot be read, is no tile file, has a damaged directory, or if
    /// the directory needs more memory than the reader may use.
    pub async fn open(path: impl AsRef<Path>, options: OpenOptions) -> Result<Self, ReadError> {
        let path = path.as_ref();
        let name: Arc<str> = shown::path(path).into();
        let backend = options.backend.map_or_else(Backend::from_environment, Ok);
        let file = backend.and_then(|backend| files::open(path, backend));
        let file = file.map_err(|error| ReadError::Io {
            file: Arc::clone(&name),
            what: "the file".to_owned(),
            source: Arc::new(error),
        })?;
        Self::open_source(file, &name, options).await
    }

    /// Opens a file on a web server or in an object store: `http://…`, `https://…` or
    /// `s3://bucket/…`. See [`ObjectFile::open`](crate::io::ObjectFile::open).
    ///
    /// # Errors
    ///
    /// Returns the errors of [`open`](Self::open), and errors of the server.
    #[cfg(feature = "object-store")]
    pub async fn open_url(url: &str, options: OpenOptions) -> Result<Self, ReadError> {
        let file = files::ObjectFile::open(url).await.map_err(|error| ReadError::Io {
            file: shown::text(url).into(),
            what: "the file".to_owned(),
            source: Arc::new(error),
        })?;
        Self::open_source(file, &shown::text(url), options).await
    }

    /// Opens a file on any backend. Errors contain `name` as the name of the file.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`open`](Self::open).
    pub async fn open_source(
        source: impl ReadAt + 'static,
        name: &str,
        options: OpenOptions,
    ) -> Result<Self, ReadError> {
        let name: Arc<str> = name.into();
        let (in_force, directory) = read_directory(&source, &name, options.memory).await?;
        let cache = options.cache;
        let cache = cache.unwrap_or_else(|| Cache::new(FileShares(options.memory).cache()));
        tracing::debug!(
            file = &*name,
            backend = source.backend(),
            note = source.note(),
            tiles = directory.tiles.len(),
            "opened"
        );
        Ok(Self {
            inner: Arc::new(ReaderInner {
                name,
                source: Arc::new(source),
                in_force,
                directory: Arc::new(directory),
                cache,
                memory: options.memory,
            }),
        })
    }

    /// Returns the metadata of the whole file.
    #[must_use]
    pub fn metadata(&self) -> &Metadata {
        &self.inner.directory.metadata
    }

    /// Returns the whole directory: the metadata, the k-d tree and the entry of every tile.
    ///
    /// Whoever needs few tiles finds them by [`tile_at`](Self::tile_at) and
    /// [`entry`](Self::entry).
    ///
    /// # Errors
    ///
    /// Returns an error if a part of the directory cannot be read or is damaged.
    pub async fn directory(&self) -> Result<Arc<Directory>, ReadError> {
        Ok(Arc::clone(&self.inner.directory))
    }

    /// Returns the entry of a tile in the directory.
    ///
    /// # Errors
    ///
    /// Returns an error if there is no such tile, or if a part of the directory cannot be read or
    /// is damaged.
    pub async fn entry(&self, id: TileId) -> Result<TileEntry, ReadError> {
        self.inner.entry(id).await
    }

    /// Returns the entry of a tile, if it is in memory.
    pub(crate) fn entry_in_memory(&self, id: TileId) -> Option<&TileEntry> {
        self.inner.directory.tiles.get(id.0 as usize)
    }

    /// Returns the name with which the file was opened.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.inner.name
    }

    /// Returns the identity of the file: a hash of its whole content.
    #[must_use]
    pub fn file_id(&self) -> FileId {
        self.inner.in_force.superblock.file_id
    }

    /// Returns the generation of the file: 1 for a new file, and one more for each change.
    #[must_use]
    pub fn generation(&self) -> u64 {
        self.inner.in_force.superblock.generation
    }

    /// Returns the length of the file in bytes.
    #[must_use]
    pub fn file_length(&self) -> u64 {
        self.inner.in_force.superblock.file_length
    }

    /// Returns the name of the I/O backend.
    #[must_use]
    pub fn backend(&self) -> &'static str {
        self.inner.source.backend()
    }

    /// Returns the superblock that was in force when the file was opened.
    pub(crate) fn in_force(&self) -> &InForce {
        &self.inner.in_force
    }

    /// Returns a note for the user on how the I/O backend was chosen, such as why there is no ring,
    /// or `None` if there is nothing to say.
    #[must_use]
    pub fn backend_note(&self) -> Option<&str> {
        self.inner.source.note()
    }

    /// Returns the cache in use.
    #[must_use]
    pub fn cache(&self) -> &Cache {
        &self.inner.cache
    }

    /// Returns a tile from the cache or the file. Must be awaited within a tokio runtime.
    ///
    /// # Errors
    ///
    /// Returns an error if there is no such tile, if it cannot be read, or if it is damaged.
    pub async fn tile(&self, id: TileId) -> Result<Arc<Tile>, ReadError> {
        let inner = Arc::clone(&self.inner);
        let key = self.inner.key(id);
        self.inner.cache.get_or_load(key, || inner.load(id)).await
    }

    /// Returns whether a tile is in the cache.
    pub(crate) fn is_cached(&self, id: TileId) -> bool {
        self.inner.cache.peek(self.inner.key(id)).is_some()
    }

    /// Returns whether the tile is not in the cache, and is known to fit into it without an
    /// eviction.
    pub(crate) fn has_room_for(&self, id: TileId) -> bool {
        let cache = &self.inner.cache;
        let Some(entry) = self.entry_in_memory(id) else {
            return false;
        };
        // With its notes, a tile takes about twice as much memory as in the file.
        let bytes = 2 * (u64::from(entry.core.length) + u64::from(entry.border.length));
        let free = cache.capacity().saturating_sub(cache.statistics().bytes);
        bytes <= free as u64 && !self.is_cached(id)
    }

    /// Returns a tile that stays in the cache until the result is dropped. For callers that use a
    /// tile repeatedly.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`tile`](Self::tile).
    pub async fn pin(&self, id: TileId) -> Result<PinnedTile, ReadError> {
        let inner = Arc::clone(&self.inner);
        let key = self.inner.key(id);
        self.inner.cache.pin_or_load(key, || inner.load(id)).await
    }

    /// Starts to load a tile in a task of its own, which continues while the consumer computes. The
    /// tile is taken from the cache if it is there, but is not added to it. Must be called within a
    /// tokio runtime.
    pub(super) fn load_ahead(
        &self,
        id: TileId,
        border: Option<BorderAhead>,
    ) -> impl Future<Output = Result<Arc<Tile>, ReadError>> + Send + 'static + use<> {
        let inner = Arc::clone(&self.inner);
        let load = tokio::spawn(async move {
            if let Some(tile) = inner.cache.peek(inner.key(id)) {
                return Ok(tile);
            }
            let Some(border) = border else {
                return inner.load(id).await;
            };
            let entry = inner.entry(id).await?;
            let core = inner.source.read_at(entry.core.range());
            let read = future::try_join(core, border.bytes()).await;
            let (core, border) = read.map_err(|error| inner.unreadable(id, &entry, error))?;
            inner.open(id, entry, core, border).await
        });
        async move { load.await.unwrap_or_else(|_| Err(ReadError::Cancelled)) }
    }

    /// Returns the file.
    pub(super) fn source(&self) -> &Arc<dyn ReadAt> {
        &self.inner.source
    }

    /// Tells the I/O backend that a pass over tiles has ended.
    pub(crate) fn rest(&self) {
        self.inner.source.rest();
    }

    /// Returns the limit on the reader's memory in bytes, if there is one.
    pub(crate) fn memory(&self) -> Option<u64> {
        self.inner.memory
    }

    /// Returns the error for a pass that needs at least `needed` bytes of memory.
    pub(crate) fn too_little_memory(&self, needed: u64) -> ReadError {
        ReadError::Memory {
            file: Arc::clone(&self.inner.name),
            needed,
            allowed: self.inner.memory.unwrap_or(u64::MAX),
        }
    }

    /// Reads the core or the border of a tile, without any checks.
    pub(super) async fn read_extent(&self, id: TileId, entry: &TileEntry, extent: Extent) -> Result<Bytes, ReadError> {
        let read = self.inner.source.read_at(extent.range()).await;
        read.map_err(|error| self.inner.unreadable(id, entry, error))
    }

    /// Returns the error for a tile that contradicts its neighbours.
    pub(crate) fn damaged(&self, tile: TileId, reason: impl Into<String>) -> ReadError {
        self.inner.damaged(tile, reason.into())
    }
}

impl ReaderInner {
    fn key(&self, tile: TileId) -> TileKey {
        TileKey {
            file: self.in_force.superblock.file_id,
            generation: self.in_force.superblock.generation,
            tile,
        }
    }

    async fn entry(&self, id: TileId) -> Result<TileEntry, ReadError> {
        let tiles = &self.directory.tiles;
        tiles.get(id.0 as usize).copied().ok_or_else(|| ReadError::NoSuchTile {
            file: Arc::clone(&self.name),
            tile: id,
            tiles: tiles.len(),
        })
    }

    fn damaged(&self, tile: TileId, reason: String) -> ReadError {
        ReadError::Tile {
            file: Arc::clone(&self.name),
            tile,
            offset: self.directory.tiles.get(tile.0 as usize).map_or(0, |t| t.core.offset),
            reason,
        }
    }

    fn unreadable(&self, id: TileId, entry: &TileEntry, error: io::Error) -> ReadError {
        ReadError::Io {
            file: Arc::clone(&self.name),
            what: format!("tile {id} at byte {}", entry.core.offset),
            source: Arc::new(error),
        }
    }

    async fn load(self: Arc<Self>, id: TileId) -> Result<Arc<Tile>, ReadError> {
        let entry = self.entry(id).await?;
        let ranges = [entry.core, entry.border].map(Extent::range);
        let read = self.source.read_many(&ranges).await;
        let extents = read.map_err(|error| self.unreadable(id, &entry, error))?;
        let [core, border]: [Bytes; 2] = extents.try_into().expect("an answer for each range");
        self.open(id, entry, core, border).await
    }

    async fn open(
        self: Arc<Self>,
        id: TileId,
        entry: TileEntry,
        core: Bytes,
        border: Bytes,
    ) -> Result<Arc<Tile>, ReadError> {
        // Checksums and range checks take milliseconds, which would block the runtime's workers.
        let opened = files::blocking(move || Tile::open(id, &entry, &core, &border)).await;
        let tile = opened.map_err(ReadError::thread)?;
        tile.map(Arc::new).map_err(|damage| self.damaged(id, damage.into()))
    }
}
