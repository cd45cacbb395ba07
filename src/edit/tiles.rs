//! The tiles of a file during an edit. Those in use are in a cache. Changed tiles are written
//! behind the end of the file when the cache evicts them.
//!
//! Existing bytes are never overwritten: until the superblock changes, the file is in its former
//! state.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::Path;
use std::pin::pin;
use std::sync::Arc;

use futures::future::FutureExt;
use tokio::runtime::Handle;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

use crate::edit::contradiction::Contradiction;
use crate::edit::disk::{Disk, Purpose};
use crate::edit::error::EditError;
use crate::edit::survey::TileSurvey;
use crate::edit::target::Target;
use crate::edit::tile::EditTile;
use crate::geometry::HalfEdge;
use crate::memory::EditShares;
use crate::mesh::{Topology, Twin};
use crate::store::{
    Digest, DigestSum, Directory, EditCache, EditLease, EditPin, KdTree, MAX_TILES, Metadata, Tile, TileId,
};

/// The tiles of a file, changed by one thread that may block, which must not be one of the
/// runtime's.
pub(crate) struct Tiles {
    runtime: Handle,
    cache: EditCache<TileId, EditTile, EditError>,
    disk: Arc<Disk>,
    /// The directory of the file as it was opened, with the tiles that were added since.
    directory: Directory,
    /// Whether each tile was changed since the file was opened.
    is_changed: Vec<bool>,
    /// The tiles that were added, each with the tile whose cell it got a part of.
    added: BTreeMap<TileId, TileId>,
    /// The tiles that have no vertices any more.
    emptied: BTreeSet<TileId>,
    /// The number of vertices that were added.
    new_vertices: u64,
    /// The digest of the changed tiles as they were in the file, without holes.
    digest_before: Digest,
    /// Ends when the last reference to `disk` is dropped.
    gone: oneshot::Receiver<()>,
}

/// A tile to read.
pub(crate) type Pin = EditPin<TileId, EditTile, EditError>;

impl Tiles {
    /// Opens a file to edit it. `shares` returns the memory for its tiles, given the bytes of the
    /// largest one. `adds_lines` says whether constraints may come.
    pub(crate) fn open(
        mut target: Target,
        shares: &dyn Fn(u64) -> EditShares,
        purpose: Purpose,
        adds_lines: bool,
        runtime: Handle,
    ) -> Result<Self, EditError> {
        let reader = runtime.block_on(target.take_reader())?;
        let reader = runtime.block_on(reader.for_passes())?;
        let shares = shares(reader.largest_tile());
        let tiles = shares.tiles;
        let (disk, gone) = Disk::open(target, reader, shares, purpose, adds_lines)?;
        let theirs = Arc::clone(&disk);
        let write_back = move |id, tile| Arc::clone(&theirs).write(id, tile).boxed();
        Ok(Self {
            runtime,
            cache: EditCache::new(tiles as usize, write_back),
            directory: disk.reader.directory().clone(),
            is_changed: vec![false; disk.reader.directory().tiles.len()],
            added: BTreeMap::new(),
            emptied: BTreeSet::new(),
            new_vertices: 0,
            digest_before: Digest::default(),
            disk,
            gone,
        })
    }

    /// Returns the directory of the file as it was opened, with the tiles that were added since.
    pub(crate) fn directory(&self) -> &Directory {
        &self.directory
    }

    /// Adds tiles without vertices, which get parts of the cells of others: those that `subtrees`
    /// names in the place of each. New tiles have the next numbers.
    pub(crate) fn add(&mut self, subtrees: &BTreeMap<TileId, KdTree>) -> Result<(), EditError> {
        for (&of, subtree) in subtrees {
            let new = subtree.leaves().filter(|&id| id != of);
            self.added.extend(new.map(|id| (id, of)));
        }
        let count = self.directory.tiles.len() + subtrees.values().map(|tree| tree.tiles() as usize - 1).sum::<usize>();
        if count > MAX_TILES as usize {
            return Err(EditError::TooManyTiles { max: MAX_TILES });
        }
        self.directory.cut_leaves(subtrees, count);
        self.is_changed.resize(count, true);
        self.runtime.block_on(self.disk.add_tiles(count))
    }

    /// Returns the tiles that were added.
    pub(crate) fn added(&self) -> impl Iterator<Item = TileId> {
        self.added.keys().copied()
    }

    /// Returns the tile that had the cell of a tile that was added.
    pub(crate) fn former(&self, id: TileId) -> Option<TileId> {
        self.added.get(&id).copied()
    }

    /// Returns the tiles that have vertices, in the order of the leaves.
    pub(crate) fn ids(&self) -> impl Iterator<Item = TileId> {
        self.directory().tile_ids().filter(|&id| !self.is_emptied(id))
    }

    /// Returns whether a tile has no vertices any more.
    pub(crate) fn is_emptied(&self, id: TileId) -> bool {
        self.emptied.contains(&id)
    }

    /// Notes that a tile has no vertices any more.
    pub(crate) fn set_emptied(&mut self, id: TileId) {
        self.emptied.insert(id);
    }

    /// Returns the metadata of the file as it was opened.
    pub(crate) fn metadata(&self) -> &Metadata {
        self.disk.reader.metadata()
    }

    /// Notes that vertices were added.
    pub(crate) fn count_new_vertices(&mut self, count: usize) {
        self.new_vertices += count as u64;
    }

    /// Returns an upper bound on the number of triangles: what goes on for longer goes in circles.
    pub(crate) fn most_triangles(&self) -> u64 {
        self.metadata()
            .vertices
            .saturating_add(self.new_vertices)
            .saturating_mul(2)
    }

    /// Returns whether the file will say of which regions its triangles are.
    pub(crate) fn has_regions(&self) -> bool {
        self.disk.has_regions
    }

    /// Returns the length in bytes of the file as it was opened.
    pub(crate) fn length(&self) -> u64 {
        self.disk.reader.file_length()
    }

    /// Returns the number of tiles that were read so far.
    pub(crate) fn reads(&self) -> u64 {
        self.disk.reads()
    }

    pub(crate) fn path(&self) -> &Path {
        self.disk.path()
    }

    /// Returns the error for tiles that contradict each other.
    pub(crate) fn damaged(&self, tile: TileId, contradiction: Contradiction) -> EditError {
        self.disk.damaged(tile, contradiction)
    }

    /// Returns a tile to read. It must be dropped before the tile is changed; otherwise the tile is
    /// copied.
    pub(crate) fn get(&self, id: TileId) -> Result<Pin, EditError> {
        let load = || Arc::clone(&self.disk).load(id);
        self.wait_for(self.cache.read(id, load))
    }

    /// Returns the result of a future. Usually it is ready at once, since the tile is in the cache.
    /// Then the runtime is not needed.
    fn wait_for<T>(&self, future: impl Future<Output = T>) -> T {
        let mut future = pin!(future);
        let _context = self.runtime.enter();
        let at_once = future.as_mut().now_or_never();
        at_once.unwrap_or_else(|| self.runtime.block_on(future))
    }

    /// Returns the twin of a half-edge, with a tile that has it; `None` on the outside.
    pub(crate) fn twin(&self, tile: Pin, half_edge: HalfEdge) -> Result<Option<(Pin, HalfEdge)>, EditError> {
        match tile.twin(half_edge) {
            Twin::HalfEdge(other) => Ok(Some((tile, other))),
            Twin::Hull => Ok(None),
            Twin::Elsewhere => {
                // The tile of an end of the edge has the twin's triangle.
                let ends = [half_edge.next(), half_edge].map(|half_edge| tile.origin_vertex(half_edge).id);
                let tile = self.get(ends[0].tile)?;
                Ok(tile.half_edge_between(ends[0], ends[1]).map(|other| (tile, other)))
            }
        }
    }

    /// Starts to read tiles that will be needed next, up to one less than the number of worker
    /// threads.
    pub(crate) fn read_ahead(&self, ids: impl Iterator<Item = TileId>) {
        // One thread is busy with the tile that is needed now.
        let ids = ids.take(self.disk.workers.threads.saturating_sub(1));
        for id in ids {
            let (reader, disk) = (self.cache.reader(), Arc::clone(&self.disk));
            // If it fails, the later request for the tile tries again and returns the error.
            let read = async move { drop(reader.read(id, || disk.load(id)).await) };
            self.runtime.spawn(read);
        }
    }

    /// Returns what the search for regions needs to know of some tiles, in their order. All changes
    /// must be [written](Self::flush). Tiles of which it was not kept are read, several at a time.
    pub(crate) fn surveys(&self, tiles: Vec<TileId>) -> TileSurveys<'_> {
        TileSurveys {
            tiles: self,
            left: tiles.into(),
            coming: VecDeque::new(),
        }
    }

    /// Writes the changed tiles that are only in the cache.
    pub(crate) fn flush(&mut self) -> Result<(), EditError> {
        self.runtime.block_on(self.cache.flush(self.disk.workers.threads))
    }

    /// Returns the component table of a tile that was not changed, and the number of components.
    pub(crate) fn table(&self, id: TileId) -> Result<(Vec<u8>, u32), EditError> {
        self.runtime.block_on(self.disk.table(id))
    }

    /// Puts a component table in the place of that of a tile.
    pub(crate) fn put_table(&self, id: TileId, table: Vec<u8>) -> Result<(), EditError> {
        self.runtime.block_on(self.disk.put_table(id, table))
    }

    /// Returns the digest of the file once all tiles are written: that of the file as
    /// it was opened, less what the changed tiles had, and with what they have. `holes` are the
    /// triangles in holes.
    pub(crate) fn digest(&self, holes: DigestSum) -> Result<Digest, EditError> {
        let mut digest = self.metadata().digest;
        digest -= self.digest_before;
        digest += self.runtime.block_on(self.disk.digest())?;
        Ok(Digest { holes, ..digest })
    }

    /// Returns a tile to change, one at a time. It will be written, and its components are found anew.
    pub(crate) fn change(&mut self, id: TileId) -> Result<EditLease<'_, TileId, EditTile, EditError>, EditError> {
        let load = || Arc::clone(&self.disk).load(id);
        let mut lease = self.wait_for(self.cache.edit(id, load))?;
        // Borrowing it makes the cache write it.
        let _: &mut EditTile = &mut lease;
        if let Some(is_changed) = self.is_changed.get_mut(id.0 as usize)
            && !std::mem::replace(is_changed, true)
        {
            self.digest_before += lease.digest();
        }
        Ok(lease)
    }

    /// Returns whether a tile was changed since the file was opened.
    pub(crate) fn is_changed(&self, id: TileId) -> bool {
        self.is_changed[id.0 as usize]
    }

    /// Returns the number of tiles that were changed.
    pub(crate) fn count_changed(&self) -> usize {
        self.is_changed.iter().filter(|changed| **changed).count()
    }

    /// Reads a tile from the file.
    pub(crate) fn read(&self, id: TileId) -> Result<Tile, EditError> {
        self.runtime.block_on(self.disk.read(id))
    }

    /// Forgets all changes. Returns the length that the file would have, without its directory.
    pub(crate) fn abandon(self) -> Result<u64, EditError> {
        let abandoned = self.runtime.block_on(self.disk.abandon());
        let Self {
            runtime,
            cache,
            disk,
            gone,
            ..
        } = self;
        close(&runtime, (cache, disk), gone);
        abandoned
    }

    /// Publishes the current tiles, with a directory that `change` adapts. Returns the length of
    /// the file.
    pub(crate) fn publish(self, change: impl FnOnce(&mut Directory)) -> Result<u64, EditError> {
        let Self {
            runtime,
            cache,
            disk,
            directory,
            gone,
            ..
        } = self;
        tracing::debug!(cache = %cache.statistics(), "edited");
        let done = runtime.block_on(disk.publish(directory, change));
        close(&runtime, (cache, disk), gone);
        done
    }
}

/// Drops what has the file locked, and waits until it is unlocked, for the next editor: tiles may
/// still be read ahead, needlessly.
fn close<T>(runtime: &Handle, holders: T, gone: oneshot::Receiver<()>) {
    drop(holders);
    let _ = runtime.block_on(gone);
}

/// What the search for regions needs to know of tiles, in order.
pub(crate) struct TileSurveys<'a> {
    tiles: &'a Tiles,
    left: VecDeque<TileId>,
    coming: VecDeque<Coming>,
}

enum Coming {
    Kept(TileSurvey),
    Read(JoinHandle<Result<TileSurvey, EditError>>),
}

impl TileSurveys<'_> {
    pub(crate) fn next(&mut self) -> Result<Option<TileSurvey>, EditError> {
        let Tiles { runtime, disk, .. } = self.tiles;
        while self.coming.len() < disk.workers.threads
            && let Some(id) = self.left.pop_front()
        {
            let disk = Arc::clone(disk);
            self.coming.push_back(match runtime.block_on(disk.kept_survey(id))? {
                Some(survey) => Coming::Kept(survey),
                None => Coming::Read(runtime.spawn(async move { disk.survey(id).await })),
            });
        }
        let gone = |_| EditError::Internal("a task that reads tiles is gone".to_owned());
        match self.coming.pop_front() {
            None => Ok(None),
            Some(Coming::Kept(survey)) => Ok(Some(survey)),
            Some(Coming::Read(survey)) => runtime.block_on(survey).map_err(gone)?.map(Some),
        }
    }
}
