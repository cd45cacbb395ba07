//! Passes over the tiles of a file: how many tiles are in memory at once, and how many threads
//! compute.
//!
//! A tile is read, checked, computed with and dropped. From its first byte read until it is
//! dropped, it occupies one of a limited number of slots. The number of slots follows from the
//! memory that the reader may use and from the largest tile of the file. The results and their
//! order do not depend on it.

use std::ops::{Deref, Range};
use std::sync::Arc;
use std::thread::available_parallelism;

use futures::future::TryFutureExt;
use futures::stream;
use futures::stream::{Stream, StreamExt, TryStreamExt};
use parking_lot::Mutex;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use crate::io::blocking;
use crate::memory::FileShares;
use crate::store::borders_ahead::{BorderAhead, BordersAhead};
use crate::store::error::ReadError;
use crate::store::format::directory::Directory;
use crate::store::format::entry::TileEntry;
use crate::store::format::ids::TileId;
use crate::store::format::tile::Tile;
use crate::store::reader::{DIRECTORY_BYTES, TileReader};

/// Bytes of tiles that are read ahead, if the memory allows.
const READ_AHEAD: u64 = 64 << 20;
/// The minimum and maximum number of tiles that are read ahead, if the memory allows.
const TILES_AHEAD: (u64, u64) = (2, 64);
/// The memory that a pass needs besides the tiles and the directory, in bytes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Needs {
    /// Memory of the pass as a whole.
    pub(crate) fixed: u64,
    /// Memory of each computing thread.
    pub(crate) per_thread: u64,
    /// Additional memory of each thread per vertex of its tile.
    pub(crate) per_vertex: u64,
}

/// The memory that a pass over the tiles of a file takes, in bytes.
struct PassCost {
    /// Memory of the pass as a whole.
    fixed: u64,
    /// Memory of a tile of average length.
    mean: u64,
    /// Memory of the largest tile.
    largest: u64,
    /// Memory of each computing thread.
    work: u64,
}

impl Needs {
    fn cost(self, directory: &Directory) -> PassCost {
        let tiles = &directory.tiles;
        let length = |t: &TileEntry| {
            let table = t.table.apart().map_or(0, |table| u64::from(table.length));
            t.core.memory_to_open() + t.border.memory_to_open() + table
        };
        let vertices = tiles.iter().map(|t| u64::from(t.vertices)).max().unwrap_or(0);
        PassCost {
            fixed: self.fixed.saturating_add(DIRECTORY_BYTES * tiles.len() as u64),
            mean: tiles.iter().map(length).sum::<u64>() / tiles.len().max(1) as u64,
            largest: tiles.iter().map(length).max().unwrap_or(0),
            work: self.per_thread.saturating_add(vertices.saturating_mul(self.per_vertex)),
        }
    }

    /// Returns the memory for both.
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            fixed: self.fixed.saturating_add(other.fixed),
            per_thread: self.per_thread.saturating_add(other.per_thread),
            per_vertex: self.per_vertex.saturating_add(other.per_vertex),
        }
    }

    /// Returns the bytes that a pass takes with one tile at a time.
    pub(crate) fn least(self, directory: &Directory) -> u64 {
        let PassCost {
            fixed, largest, work, ..
        } = self.cost(directory);
        fixed.saturating_add(largest).saturating_add(work)
    }
}

/// The number of tiles and threads of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PassPlan {
    /// The number of tiles in memory at once.
    pub(crate) tiles: usize,
    /// The number of computing threads.
    pub(crate) threads: usize,
}

impl PassPlan {
    /// Creates the largest plan that `memory` allows and that the machine can use. The error is the
    /// minimum number of bytes needed.
    fn new(directory: &Directory, memory: Option<u64>, needs: Needs, processors: usize) -> Result<Self, u64> {
        let PassCost {
            fixed,
            mean,
            largest,
            work,
        } = needs.cost(directory);
        let ahead = (READ_AHEAD / mean.max(1)).clamp(TILES_AHEAD.0, TILES_AHEAD.1);
        let useful = |threads: usize| threads as u64 + ahead;
        let shares = FileShares(memory);
        let (Some(memory), Some(tiles)) = (memory, shares.pass()) else {
            return Ok(Self {
                tiles: useful(processors) as usize,
                threads: processors,
            });
        };
        let least = needs.least(directory);
        if least > memory {
            return Err(least);
        }
        let memory = tiles.max(least);
        // A thread is useful only if there is a tile for it.
        let with = |threads: usize| {
            let left = (memory - fixed).checked_sub(work.saturating_mul(threads as u64))?;
            let tiles = left.checked_div(largest).unwrap_or(u64::MAX).min(useful(threads));
            (tiles >= threads as u64).then_some(Self {
                tiles: tiles as usize,
                threads,
            })
        };
        Ok((1..=processors)
            .rev()
            .find_map(with)
            .unwrap_or(Self { tiles: 1, threads: 1 }))
    }
}

/// A tile that occupies one of its pass's slots until it is dropped.
pub(crate) struct TileInPass {
    tile: Arc<Tile>,
    _slot: OwnedSemaphorePermit,
}

impl Deref for TileInPass {
    type Target = Tile;

    fn deref(&self) -> &Tile {
        &self.tile
    }
}

/// A reader whose I/O backend is told, when this is dropped, that the pass is over and none follows
/// for a while.
struct RestOnDrop(PassReader);

impl Drop for RestOnDrop {
    fn drop(&mut self) {
        self.0.rest();
    }
}

/// The workspaces in which the threads of a pass compute. Each tile reuses a workspace of a
/// finished one, so there are as many workspaces as threads, and their memory is not released and
/// allocated again for every tile.
pub(crate) struct Workspaces<T>(Mutex<Vec<T>>);

impl<T> Default for Workspaces<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T: Default> Workspaces<T> {
    /// Calls `compute` with a workspace that nobody else uses.
    pub(crate) fn with<R>(&self, compute: impl FnOnce(&mut T) -> R) -> R {
        let mut workspace = self.0.lock().pop().unwrap_or_default();
        let result = compute(&mut workspace);
        self.0.lock().push(workspace);
        result
    }
}

/// A tile reader with the whole directory, for passes over all tiles.
#[derive(Clone)]
pub(crate) struct PassReader {
    reader: TileReader,
    directory: Arc<Directory>,
}

/// What a reader does with single tiles, it does here too.
impl Deref for PassReader {
    type Target = TileReader;

    fn deref(&self) -> &TileReader {
        &self.reader
    }
}

impl TileReader {
    /// Returns a reader for passes over all tiles.
    ///
    /// # Errors
    ///
    /// Returns an error if a part of the directory cannot be read or is damaged.
    pub(crate) async fn for_passes(&self) -> Result<PassReader, ReadError> {
        Ok(PassReader {
            reader: self.clone(),
            directory: self.directory().await?,
        })
    }

    /// Returns all tiles in order, read ahead of their consumer. Tiles that are not in the cache
    /// are not added to it, so that a scan does not evict the tiles that queries use. Must be
    /// polled within a tokio runtime.
    ///
    /// If the reader [may use](crate::store::OpenOptions::memory) less memory than the largest tile
    /// takes, the stream yields one error and nothing else.
    pub fn tiles(&self) -> impl Stream<Item = Result<Arc<Tile>, ReadError>> + Send + Unpin + 'static {
        let reader = self.clone();
        let tiles = async move {
            let reader = reader.for_passes().await?;
            let plan = reader.plan(Needs::default())?;
            let (ids, reader) = (reader.tile_ids(), RestOnDrop(reader));
            let mut borders = reader.0.borders_ahead(ids.len());
            // The consumer holds one of the tiles, and requests the next when it is done with it.
            let loads = stream::iter(ids).map(move |id| Ok(reader.0.load_in_pass(id, borders.of(id))));
            Ok(loads.try_buffered(plan.tiles))
        };
        stream::once(tiles).try_flatten().boxed()
    }
}

impl PassReader {
    /// Returns the directory.
    pub(crate) fn directory(&self) -> &Directory {
        &self.directory
    }

    /// Returns a reader of borders for a pass over `tiles` tiles in order.
    fn borders_ahead(&self, tiles: usize) -> BordersAhead {
        BordersAhead::new(&self.directory, self.source(), tiles, self.memory())
    }

    /// Returns the number of tiles and threads of a pass.
    ///
    /// # Errors
    ///
    /// Returns an error if the memory that the reader may use does not suffice for one tile.
    pub(crate) fn plan(&self, needs: Needs) -> Result<PassPlan, ReadError> {
        let processors = available_parallelism().map_or(1, usize::from);
        PassPlan::new(self.directory(), self.memory(), needs, processors)
            .map_err(|needed| self.too_little_memory(needed))
    }

    /// Returns the memory of the largest tile in bytes.
    pub(crate) fn largest_tile(&self) -> u64 {
        Needs::default().cost(self.directory()).largest
    }

    /// Returns the ids of all tiles, in the order of the leaves of the tree.
    pub(crate) fn tile_ids(&self) -> Vec<TileId> {
        self.directory().tile_ids().collect()
    }

    /// Starts to load a tile of the file.
    fn load_in_pass(
        &self,
        id: TileId,
        border: Option<BorderAhead>,
    ) -> impl Future<Output = Result<Arc<Tile>, ReadError>> + Send + 'static + use<> {
        self.load_ahead(id, self.directory().entry(id).copied(), border)
    }

    /// Returns the error for a tile that contradicts its neighbours.
    pub(crate) fn damaged(&self, tile: TileId, reason: impl Into<String>) -> ReadError {
        ReadError::Tile {
            file: self.name().into(),
            tile,
            offset: self
                .directory
                .tiles
                .get(tile.0 as usize)
                .map_or(0, |entry| entry.core.offset),
            reason: reason.into(),
        }
    }

    /// Returns some tiles in the given order, read ahead like [`tiles`](TileReader::tiles). At most as
    /// many tiles as there are slots are in memory at once.
    pub(crate) fn pass(
        &self,
        ids: Vec<TileId>,
        plan: PassPlan,
    ) -> impl Stream<Item = Result<TileInPass, ReadError>> + Send + Unpin + 'static {
        let (reader, slots) = (RestOnDrop(self.clone()), Arc::new(Semaphore::new(plan.tiles)));
        let mut borders = self.borders_ahead(ids.len());
        // Slots are acquired in the order of the tiles, so the tile that all others wait for has
        // one.
        let loads = stream::iter(ids).then(move |id| {
            let (reader, slots) = (reader.0.clone(), Arc::clone(&slots));
            let border = borders.of(id);
            async move { (slots.acquire_owned().await, reader.load_in_pass(id, border)) }
        });
        let loads = loads.map(|(slot, load)| async move {
            Ok(TileInPass {
                tile: load.await?,
                _slot: slot.map_err(|_| ReadError::Cancelled)?,
            })
        });
        loads.buffered(plan.tiles).boxed()
    }

    /// Returns the result of `compute` for each tile, in order. A tile is dropped when `compute`
    /// returns. `compute` runs on threads for blocking work.
    ///
    /// # Errors
    ///
    /// Returns an error if the memory that the reader may use does not suffice for one tile.
    pub(crate) fn for_each_tile<T: Send + 'static, F: Fn(TileInPass) -> T + Clone + Send + 'static>(
        &self,
        needs: Needs,
        compute: F,
    ) -> Result<impl Stream<Item = Result<T, ReadError>> + Send + Unpin + use<T, F>, ReadError> {
        let plan = self.plan(needs)?;
        let all = self.tile_ids().into_iter().map(|id| (id, ())).collect();
        Ok(self.for_some_tiles(all, plan, move |tile, ()| compute(tile)))
    }

    /// Computes like [`for_each_tile`](Self::for_each_tile) on some tiles, each with a value that
    /// is passed to `compute`.
    pub(crate) fn for_some_tiles<G, T, F>(
        &self,
        tiles: Vec<(TileId, G)>,
        plan: PassPlan,
        compute: F,
    ) -> impl Stream<Item = Result<T, ReadError>> + Send + Unpin + use<G, T, F>
    where
        G: Send + 'static,
        T: Send + 'static,
        F: Fn(TileInPass, G) -> T + Clone + Send + 'static,
    {
        let (tiles, given): (Vec<TileId>, Vec<G>) = tiles.into_iter().unzip();
        let tiles = self.pass(tiles, plan).zip(stream::iter(given));
        let tasks = tiles.map(move |(tile, given)| {
            let compute = compute.clone();
            let task = tile.map(|tile| spawn(move || compute(tile, given)));
            async move { task?.await }
        });
        tasks.buffered(plan.threads).boxed()
    }
}

/// Groups items that are sorted by tile. Returns each tile with the range of its items.
pub(crate) fn by_tile<T>(sorted: &[T], tile: impl Fn(&T) -> u32) -> Vec<(TileId, Range<usize>)> {
    let mut end = 0;
    let groups = sorted.chunk_by(|a, b| tile(a) == tile(b)).map(|group| {
        end += group.len();
        (TileId(tile(&group[0])), end - group.len()..end)
    });
    groups.collect()
}

/// Returns a list with room for at least `count` items, whose memory goes back to the system as
/// soon as the list is dropped.
///
/// When glibc frees a large allocation below 32 MiB, it raises its threshold for keeping such
/// memory in each of its arenas; the memory that one pass frees would then add to the memory that
/// the next one takes. Therefore the list always has more room than that. Memory that is never
/// written takes no space.
pub(crate) fn list_for<T>(count: usize) -> Vec<T> {
    const ALWAYS_MAPPED: usize = 33 << 20;
    Vec::with_capacity(count.max(ALWAYS_MAPPED / size_of::<T>().max(1)))
}

/// Runs `work`, which takes long, on a thread for blocking work.
pub(crate) fn spawn<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> impl Future<Output = Result<T, ReadError>> + Send + 'static {
    blocking(work).map_err(ReadError::thread)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::format::extent::Extent;

    const MEBIBYTE: u64 = 1 << 20;

    /// Returns a directory of tiles of the given sizes in mebibytes, with 65,536 vertices each.
    fn directory(mebibytes: &[u32]) -> Directory {
        let extent = |length| Extent::raw(8192, length, 0);
        let tiles = mebibytes.iter().map(|length| TileEntry {
            core: extent(length << 20),
            border: extent(0),
            generation: 1,
            vertices: 1 << 16,
            core_triangles: 0,
            border_triangles: 0,
            owned_triangles: 0,
            bounds: crate::geometry::Rect::EMPTY,
            table: crate::store::format::table_place::TablePlace::Nowhere,
        });
        Directory {
            tiles: tiles.collect(),
            ..Directory::default()
        }
    }

    #[test]
    fn a_plan_fits_into_the_memory_and_grows_with_it_up_to_the_useful_maximum() {
        let directory = directory(&[4, 4, 10, 2]);
        let needs = Needs {
            fixed: 5 * MEBIBYTE,
            per_thread: MEBIBYTE,
            per_vertex: 32,
        };
        let least = needs.least(&directory);
        assert_eq!(least, 18 * MEBIBYTE + 4 * DIRECTORY_BYTES);
        let plan = |memory| PassPlan::new(&directory, memory, needs, 4);
        assert_eq!(plan(Some(least - 1)), Err(least));
        assert_eq!(plan(Some(0)), Err(least));
        assert_eq!(plan(Some(least)), Ok(PassPlan { tiles: 1, threads: 1 }));
        let all = PassPlan { tiles: 16, threads: 4 };
        assert_eq!(plan(None), Ok(all));
        assert_eq!(plan(Some(u64::MAX)), Ok(all));
        let mut before = PassPlan { tiles: 1, threads: 1 };
        for memory in (least..least + 200 * MEBIBYTE).step_by(MEBIBYTE as usize) {
            let plan = plan(Some(memory)).unwrap();
            assert!(plan.tiles >= plan.threads && plan.threads >= before.threads);
            let used = 5 * MEBIBYTE + 10 * MEBIBYTE * plan.tiles as u64 + 3 * MEBIBYTE * plan.threads as u64;
            assert!(used <= memory, "{plan:?} in {memory}");
            before = plan;
        }
        assert_eq!(before, all);
    }

    #[test]
    fn files_without_tiles_or_with_empty_ones_have_plans() {
        for directory in [directory(&[]), directory(&[0])] {
            let plan = PassPlan::new(&directory, Some(MEBIBYTE), Needs::default(), 2).unwrap();
            assert_eq!(plan.threads, 2);
            assert!((2..=66).contains(&plan.tiles));
        }
    }
}
