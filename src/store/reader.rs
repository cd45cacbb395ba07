//! Opens tile files and reads their tiles.

use std::io;
use std::ops::Range;
use std::sync::Arc;

use bytes::Bytes;
use futures::future;
use futures::future::FutureExt;

use crate::io::{ReadAt, Section, in_turn};

use crate::store::borders_ahead::BorderAhead;
use crate::store::cache::{Cache, PinnedTile, TileKey};
use crate::store::error::ReadError;
use crate::store::format::component_table::decode;
use crate::store::format::damage::Damage;
use crate::store::format::directory::Directory;
use crate::store::format::entry::TileEntry;
use crate::store::format::extent::Extent;
use crate::store::format::flat_buffer::{check_crc, within};
use crate::store::format::ids::TileId;
use crate::store::format::lists::{Lists, Source};
use crate::store::format::metadata::Metadata;
use crate::store::format::overview::Overviews;
use crate::store::format::superblock::{FileId, InForce};
use crate::store::format::table_place::TablePlace;
use crate::store::format::tile::Tile;
use crate::store::open_options::{OpenOptions, Origin};
use crate::store::pages::Pages;

/// Bytes of the directory in memory per tile: its entry, two nodes of the tree, and the notes of
/// passes on the tile.
pub(super) const DIRECTORY_BYTES: u64 = 320;

/// An open tile file.
///
/// Clones share the file. They and their streams may be used from any task of a tokio runtime.
#[derive(Clone)]
pub struct TileReader {
    inner: Arc<ReaderInner>,
}

struct ReaderInner {
    pages: Arc<Pages>,
    memory: Option<u64>,
    overviews: Overviews,
    origin: Origin,
}

impl TileReader {
    /// Opens a tile file that is a section of this one. It shares the cache of this reader.
    pub(super) async fn open_section(&self, section: Range<u64>, name: &str) -> Result<Self, ReadError> {
        let Self { inner } = self;
        let source = Section::new(
            Arc::clone(&inner.pages.source),
            section.start,
            section.end - section.start,
        );
        let pages = Pages::open(Arc::new(source), name.into(), inner.pages.cache.clone()).await?;
        // An overview has none of its own, whatever its bytes say.
        Ok(Self::of(pages, inner.memory, Overviews::default(), Origin::Given))
    }

    pub(super) fn of(pages: Pages, memory: Option<u64>, overviews: Overviews, origin: Origin) -> Self {
        Self {
            inner: Arc::new(ReaderInner {
                pages: Arc::new(pages),
                memory,
                overviews,
                origin,
            }),
        }
    }

    /// Returns where the file is found again, and the options with which it is opened then.
    pub(super) fn origin(&self) -> (&Origin, OpenOptions) {
        let options = OpenOptions {
            cache: Some(self.inner.pages.cache.clone()),
            memory: self.inner.memory,
            backend: None,
        };
        (&self.inner.origin, options)
    }

    /// Returns what the directory says of overviews.
    pub(super) fn overview_entries(&self) -> &Overviews {
        &self.inner.overviews
    }

    /// Returns the metadata of the whole file.
    #[must_use]
    pub fn metadata(&self) -> &Metadata {
        &self.inner.pages.root.metadata
    }

    /// Returns the lists of the file. They are read on the first call.
    ///
    /// # Errors
    ///
    /// Returns an error if a list cannot be read or is damaged.
    pub fn lists(&self) -> impl Future<Output = Result<Arc<Lists>, ReadError>> + Send {
        async move { self.inner.pages.lists().await }.boxed()
    }

    /// Returns the coordinate reference system, as [`Lists::crs`] has it, without reading the other
    /// lists.
    ///
    /// # Errors
    ///
    /// Returns an error if it cannot be read or is damaged.
    pub async fn crs(&self) -> Result<Option<String>, ReadError> {
        self.inner.pages.crs().await
    }

    /// Returns the files from which the points were read, as [`Lists::sources`] has them, without
    /// reading the other lists.
    ///
    /// # Errors
    ///
    /// Returns an error if the list cannot be read or is damaged.
    pub async fn sources(&self) -> Result<Vec<Source>, ReadError> {
        self.inner.pages.sources().await
    }

    /// Reads the whole directory: the metadata, the lists, the k-d tree and the entry of every
    /// tile.
    ///
    /// Whoever needs few tiles finds them by [`tile_at`](Self::tile_at) and
    /// [`entry`](Self::entry).
    ///
    /// # Errors
    ///
    /// Returns an error if a part of the directory cannot be read or is damaged, or if the
    /// directory needs more memory than the reader may use.
    pub fn directory(&self) -> impl Future<Output = Result<Arc<Directory>, ReadError>> + Send {
        async move {
            let needed = DIRECTORY_BYTES * u64::from(self.inner.pages.root.next_tile);
            if self.memory().is_some_and(|memory| needed > memory) {
                return Err(self.too_little_memory(needed));
            }
            Ok(Arc::new(self.inner.pages.whole().await?))
        }
        .boxed()
    }

    /// Returns the entry of a tile in the directory.
    ///
    /// # Errors
    ///
    /// Returns an error if there is no such tile, or if a part of the directory cannot be read or
    /// is damaged.
    pub async fn entry(&self, id: TileId) -> Result<TileEntry, ReadError> {
        self.inner.pages.entry(id).await
    }

    /// Returns the entry of a tile, if it is in memory.
    pub(crate) fn entry_in_memory(&self, id: TileId) -> Option<TileEntry> {
        self.inner.pages.entry_in_memory(id)
    }

    /// Returns the directory, page by page.
    pub(super) fn pages(&self) -> &Arc<Pages> {
        &self.inner.pages
    }

    /// Returns the name with which the file was opened.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.inner.pages.name
    }

    /// Returns the identity of the file: a hash of the directory with which it was made. Edits do
    /// not change it.
    #[must_use]
    pub fn file_id(&self) -> FileId {
        self.inner.pages.in_force.superblock.file_id
    }

    /// Returns the generation of the file: 1 for a new file, and one more for each change.
    #[must_use]
    pub fn generation(&self) -> u64 {
        self.inner.pages.in_force.superblock.generation
    }

    /// Returns the length of the file in bytes.
    #[must_use]
    pub fn file_length(&self) -> u64 {
        self.inner.pages.in_force.superblock.file_length
    }

    /// Returns the name of the I/O backend.
    #[must_use]
    pub fn backend(&self) -> &'static str {
        self.inner.pages.source.backend()
    }

    /// Returns the superblock that was in force when the file was opened.
    pub(crate) fn in_force(&self) -> &InForce {
        &self.inner.pages.in_force
    }

    /// Returns a note for the user on how the I/O backend was chosen, such as why there is no ring,
    /// or `None` if there is nothing to say.
    #[must_use]
    pub fn backend_note(&self) -> Option<&str> {
        self.inner.pages.source.note()
    }

    /// Returns the cache in use.
    #[must_use]
    pub fn cache(&self) -> &Cache {
        &self.inner.pages.cache
    }

    /// Returns a tile from the cache or the file. Must be awaited within a tokio runtime.
    ///
    /// # Errors
    ///
    /// Returns an error if there is no such tile, if it cannot be read, or if it is damaged.
    pub async fn tile(&self, id: TileId) -> Result<Arc<Tile>, ReadError> {
        let entry = self.entry(id).await?;
        self.tile_of_entry(id, &entry).await
    }

    /// Returns the tile of an entry.
    pub(crate) async fn tile_of_entry(&self, id: TileId, entry: &TileEntry) -> Result<Arc<Tile>, ReadError> {
        let cache = &self.inner.pages.cache;
        match cache.get(self.inner.key(id, entry)) {
            Some(tile) => Ok(tile),
            None => Ok(self.load_pinned(id, *entry).await?.tile()),
        }
    }

    /// Returns a tile that stays in the cache until the result is dropped, and loads it if need be.
    fn load_pinned(&self, id: TileId, entry: TileEntry) -> impl Future<Output = Result<PinnedTile, ReadError>> + Send {
        let key = self.inner.key(id, &entry);
        let load = move || Arc::clone(&self.inner).load(id, entry);
        self.inner.pages.cache.pin_or_load(key, load).boxed()
    }

    /// Returns whether a tile is in the cache.
    pub(crate) fn is_cached(&self, id: TileId) -> bool {
        let entry = self.entry_in_memory(id);
        entry.is_some_and(|entry| self.inner.pages.cache.peek(self.inner.key(id, &entry)).is_some())
    }

    /// Returns whether the tile is not in the cache, and is known to fit into it without an
    /// eviction.
    pub(crate) fn has_room_for(&self, id: TileId) -> bool {
        let cache = &self.inner.pages.cache;
        let Some(entry) = self.entry_in_memory(id) else {
            return false;
        };
        let bytes = entry.cached_bytes();
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
        let entry = self.entry(id).await?;
        self.load_pinned(id, entry).await
    }

    /// Starts to load a tile in a task of its own, which continues while the consumer computes. The
    /// tile is taken from the cache if it is there, but is not added to it. Must be called within a
    /// tokio runtime.
    pub(super) fn load_ahead(
        &self,
        id: TileId,
        entry: Option<TileEntry>,
        border: Option<BorderAhead>,
    ) -> impl Future<Output = Result<Arc<Tile>, ReadError>> + Send + 'static + use<> {
        let inner = Arc::clone(&self.inner);
        let load = tokio::spawn(async move {
            let entry = entry.ok_or_else(|| inner.pages.no_such_tile(id))?;
            if let Some(tile) = inner.pages.cache.peek(inner.key(id, &entry)) {
                return Ok(tile);
            }
            let Some(border) = border else {
                return inner.load(id, entry).await;
            };
            let core = inner.pages.source.read_at(entry.core.range());
            let read = future::try_join(core, border.bytes()).await;
            let (core, border) = read.map_err(|error| inner.unreadable(id, &entry, error))?;
            inner.load_rest(id, entry, core, border).await
        });
        async move { load.await.unwrap_or_else(|_| Err(ReadError::Cancelled)) }
    }

    /// Returns the file.
    pub(super) fn source(&self) -> &Arc<dyn ReadAt> {
        &self.inner.pages.source
    }

    /// Tells the I/O backend that a pass over tiles has ended.
    pub(crate) fn rest(&self) {
        self.inner.pages.source.rest();
    }

    /// Returns the limit on the reader's memory in bytes, if there is one.
    pub(crate) fn memory(&self) -> Option<u64> {
        self.inner.memory
    }

    /// Returns the error for a pass that needs at least `needed` bytes of memory.
    pub(crate) fn too_little_memory(&self, needed: u64) -> ReadError {
        ReadError::Memory {
            file: Arc::clone(&self.inner.pages.name),
            needed,
            allowed: self.inner.memory.unwrap_or(u64::MAX),
        }
    }

    /// Reads the core or the border of a tile, without any checks.
    pub(super) async fn read_extent(&self, id: TileId, entry: &TileEntry, extent: Extent) -> Result<Bytes, ReadError> {
        let read = self.inner.pages.source.read_at(extent.range()).await;
        read.map_err(|error| self.inner.unreadable(id, entry, error))
    }

    /// Reads the component table of a tile. Also returns the number of components.
    pub(crate) async fn component_table(&self, id: TileId, entry: &TileEntry) -> Result<(Vec<u8>, u32), ReadError> {
        let damaged = |damage: Damage| self.damaged(id, damage);
        let table = match entry.table {
            TablePlace::Nowhere => return Err(self.damaged(id, "it has no component table")),
            TablePlace::InPage(table) => table.bytes().to_vec(),
            TablePlace::Apart(extent) => self.read_extent(id, entry, extent).await?.into(),
        };
        check_crc("the component table", &table, entry.table.crc()).map_err(damaged)?;
        let components = decode(id, &table).map_err(damaged)?.len() as u32;
        Ok((table, components))
    }

    /// Returns the error for a tile that contradicts its neighbours.
    pub(crate) fn damaged(&self, tile: TileId, reason: impl Into<String>) -> ReadError {
        self.inner.damaged(tile, reason.into())
    }
}

impl ReaderInner {
    fn key(&self, tile: TileId, entry: &TileEntry) -> TileKey {
        TileKey {
            file: self.pages.in_force.superblock.file_id,
            generation: entry.generation,
            tile,
            crcs: [entry.core.crc, entry.border.crc, entry.table.crc()],
        }
    }

    fn damaged(&self, tile: TileId, reason: String) -> ReadError {
        let entry = self.pages.entry_in_memory(tile);
        ReadError::Tile {
            file: Arc::clone(&self.pages.name),
            tile,
            offset: entry.map_or(0, |entry| entry.core.offset),
            reason,
        }
    }

    fn unreadable(&self, id: TileId, entry: &TileEntry, error: io::Error) -> ReadError {
        ReadError::Io {
            file: Arc::clone(&self.pages.name),
            what: format!("tile {id} at byte {}", entry.core.offset),
            source: Arc::new(error),
        }
    }

    async fn load(self: Arc<Self>, id: TileId, entry: TileEntry) -> Result<Arc<Tile>, ReadError> {
        let border = entry.border_and_table().unwrap_or(entry.border.range());
        let read = self.pages.source.read_many(&[entry.core.range(), border]).await;
        let extents = read.map_err(|error| self.unreadable(id, &entry, error))?;
        let [core, border]: [Bytes; 2] = extents.try_into().expect("an answer for each range");
        self.load_rest(id, entry, core, border).await
    }

    /// Opens a tile whose core and border are read. `border` may contain the component table behind
    /// it; otherwise the table is read, if it lies apart.
    async fn load_rest(
        self: Arc<Self>,
        id: TileId,
        entry: TileEntry,
        core: Bytes,
        border: Bytes,
    ) -> Result<Arc<Tile>, ReadError> {
        let start = entry.border.offset;
        let table = match entry.table.apart() {
            None => None,
            Some(extent) => Some(match within(&border, start, extent) {
                Some(table) => table,
                None => self
                    .pages
                    .source
                    .read_at(extent.range())
                    .await
                    .map_err(|error| self.unreadable(id, &entry, error))?,
            }),
        };
        // A border that is cut off does not have its checksum.
        let border = within(&border, start, entry.border).unwrap_or(border);
        // Checksums and range checks take milliseconds, which would block the runtime's workers.
        // A scan reads dozens of tiles ahead, and needs them in order.
        let opened = in_turn(move || Tile::open(id, &entry, [&core, &border], table.as_ref())).await;
        let tile = opened.map_err(ReadError::thread)?;
        tile.map(Arc::new).map_err(|damage| ReadError::Tile {
            file: Arc::clone(&self.pages.name),
            tile: id,
            offset: entry.core.offset,
            reason: damage.into(),
        })
    }
}
