//! Passes over the tiles of a file: how many tiles are in memory at once, and who computes with them.
//!
//! A tile is read, checked, computed with and dropped; from its first byte to its end it has one of a limited number of
//! slots. How many there are follows from the memory that the reader may use and from the largest tile of the file. What comes
//! out, and in which order, does not depend on it.

use std::ops::{Deref, Range};
use std::sync::Arc;
use std::thread::available_parallelism;

use futures::future::TryFutureExt;
use futures::stream;
use futures::stream::{Stream, StreamExt};
use parking_lot::Mutex;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::task::JoinHandle;

use crate::io::{blocking, memory_of};
use crate::memory::FileShares;
use crate::store::error::ReadError;
use crate::store::format::directory::{Directory, TileEntry};
use crate::store::format::ids::TileId;
use crate::store::format::tile::Tile;
use crate::store::reader::TileReader;

/// Bytes of tiles that are read ahead, if the memory allows.
const READ_AHEAD: u64 = 64 << 20;
/// Tiles that are read ahead, at least and at most, if the memory allows.
const TILES_AHEAD: (u64, u64) = (2, 64);
/// Bytes of the directory in memory for each tile: its entry, two nodes of the tree, and what passes note of a tile.
const DIRECTORY_BYTES: u64 = 256;

/// What a pass needs memory for, beside the tiles and the directory. In bytes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Needs {
    /// What the pass keeps as a whole.
    pub(crate) fixed: u64,
    /// What each thread that computes has.
    pub(crate) per_thread: u64,
    /// And beside that for each vertex of its tile.
    pub(crate) per_vertex: u64,
}

/// What a pass over the tiles of a file takes, in bytes.
struct Cost {
    /// As a whole.
    fixed: u64,
    /// For a tile of middling length.
    mean: u64,
    /// For the largest tile.
    largest: u64,
    /// For each thread that computes.
    work: u64,
}

impl Needs {
    fn cost(self, directory: &Directory) -> Cost {
        let tiles = &directory.tiles;
        let length = |t: &TileEntry| {
            [t.core, t.border]
                .map(|its| memory_of(its.length as usize) as u64)
                .iter()
                .sum::<u64>()
        };
        let vertices = tiles.iter().map(|t| u64::from(t.vertices)).max().unwrap_or(0);
        Cost {
            fixed: self.fixed.saturating_add(DIRECTORY_BYTES * tiles.len() as u64),
            mean: tiles.iter().map(length).sum::<u64>() / tiles.len().max(1) as u64,
            largest: tiles.iter().map(length).max().unwrap_or(0),
            work: self.per_thread.saturating_add(vertices.saturating_mul(self.per_vertex)),
        }
    }

    /// Bytes that a pass takes with one tile at once.
    pub(crate) fn least(self, directory: &Directory) -> u64 {
        let Cost {
            fixed, largest, work, ..
        } = self.cost(directory);
        fixed.saturating_add(largest).saturating_add(work)
    }
}

/// How much a pass does at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PassPlan {
    /// Tiles in memory.
    pub(crate) tiles: usize,
    /// Threads that compute.
    pub(crate) threads: usize,
}

impl PassPlan {
    /// As much as `memory` allows and the machine has use for. An error says how many bytes are needed at least.
    fn new(directory: &Directory, memory: Option<u64>, needs: Needs, processors: usize) -> Result<Self, u64> {
        let Cost {
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
        // A thread is of use if there is a tile for it.
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

/// A tile that takes one of its pass's slots until it is dropped.
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

/// A reader that is told when a pass is over after which there is none for a while.
struct Passing(TileReader);

impl Drop for Passing {
    fn drop(&mut self) {
        self.0.rest();
    }
}

/// What the threads of a pass compute in. A tile takes over what the one before it left, so that there are as many as threads,
/// and their memory is not given back and asked for again with every tile.
pub(crate) struct Workspaces<T>(Mutex<Vec<T>>);

impl<T> Default for Workspaces<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T: Default> Workspaces<T> {
    /// Computes in one that nobody else is in.
    pub(crate) fn with<R>(&self, compute: impl FnOnce(&mut T) -> R) -> R {
        let mut workspace = self.0.lock().pop().unwrap_or_default();
        let result = compute(&mut workspace);
        self.0.lock().push(workspace);
        result
    }
}

impl TileReader {
    /// How much a pass does at once.
    ///
    /// # Errors
    /// If the memory that the reader may use does not suffice for one tile.
    pub(crate) fn plan(&self, needs: Needs) -> Result<PassPlan, ReadError> {
        let processors = available_parallelism().map_or(1, usize::from);
        PassPlan::new(self.directory(), self.memory(), needs, processors).map_err(|needed| self.too_little_memory(needed))
    }

    /// Bytes of the largest tile.
    pub(crate) fn largest_tile(&self) -> u64 {
        Needs::default().cost(self.directory()).largest
    }

    /// The numbers of all tiles.
    pub(crate) fn tile_ids(&self) -> Vec<TileId> {
        (0..self.directory().tiles.len() as u32).map(TileId).collect()
    }

    /// All tiles in order, read ahead of their consumer. What is not in the cache stays out of it, so that a scan does not
    /// flush what queries keep hot. Must be polled within a tokio runtime.
    ///
    /// If the reader [may use](crate::store::OpenOptions::memory) less memory than the largest tile takes, all that comes is an
    /// error.
    pub fn tiles(&self) -> impl Stream<Item = Result<Arc<Tile>, ReadError>> + Send + Unpin + 'static {
        match self.plan(Needs::default()) {
            Err(error) => stream::iter([Err(error)]).boxed(),
            Ok(plan) => {
                let reader = Passing(self.clone());
                let ids = self.tile_ids();
                let mut borders = self.borders_ahead(ids.len());
                // One of the tiles is with the consumer, who asks for the next when he is done with it.
                let loads =
                    stream::iter(ids).map(move |id| reader.0.load_ahead(id, borders.of(id, reader.0.directory())));
                loads.buffered(plan.tiles).boxed()
            }
        }
    }

    /// Some tiles, in the order asked for, read ahead like [`tiles`](Self::tiles), as many at once as there are slots.
    pub(crate) fn pass(
        &self,
        ids: Vec<TileId>,
        plan: PassPlan,
    ) -> impl Stream<Item = Result<TileInPass, ReadError>> + Send + Unpin + 'static {
        let (reader, slots) = (Passing(self.clone()), Arc::new(Semaphore::new(plan.tiles)));
        let mut borders = self.borders_ahead(ids.len());
        // Slots are taken in the order of the tiles, so the tile that all others wait for has one.
        let loads = stream::iter(ids).then(move |id| {
            let (reader, slots) = (reader.0.clone(), Arc::clone(&slots));
            let border = borders.of(id, reader.directory());
            async move { (slots.acquire_owned().await, reader.load_ahead(id, border)) }
        });
        let loads = loads.map(|(slot, load)| async move {
            Ok(TileInPass {
                tile: load.await?,
                _slot: slot.map_err(|_| ReadError::Cancelled)?,
            })
        });
        loads.buffered(plan.tiles).boxed()
    }

    /// What `compute` makes of each tile, in order; a tile is dropped when it is done. It runs on threads for blocking work.
    ///
    /// # Errors
    /// If the memory that the reader may use does not suffice for one tile.
    pub(crate) fn for_each_tile<T: Send + 'static, F: Fn(TileInPass) -> T + Clone + Send + 'static>(
        &self,
        needs: Needs,
        compute: F,
    ) -> Result<impl Stream<Item = Result<T, ReadError>> + Send + Unpin + use<T, F>, ReadError> {
        let plan = self.plan(needs)?;
        let all = self.tile_ids().into_iter().map(|id| (id, ())).collect();
        Ok(self.for_some_tiles(all, plan, move |tile, ()| compute(tile)))
    }

    /// The same for some tiles, each with what it is to be computed with.
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

/// The tiles of things that are in their order, and where those of each are.
pub(crate) fn by_tile<T>(sorted: &[T], tile: impl Fn(&T) -> u32) -> Vec<(TileId, Range<usize>)> {
    let mut end = 0;
    let groups = sorted.chunk_by(|a, b| tile(a) == tile(b)).map(|group| {
        end += group.len();
        (TileId(tile(&group[0])), end - group.len()..end)
    });
    groups.collect()
}

/// A list with room for so many things, whose memory the system has back as soon as the list is gone.
///
/// Of large allocations below 32 MiB glibc learns to keep such amounts for itself, in each of its arenas, so that what one pass
/// gave back comes on top of what the next one takes. More room is asked for then; what is never written takes no memory.
pub(crate) fn list_for<T>(count: usize) -> Vec<T> {
    const LEARNT: usize = 33 << 20;
    Vec::with_capacity(count.max(LEARNT / size_of::<T>().max(1)))
}

/// Starts what takes long on a thread for such work.
pub(crate) fn spawn<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> impl Future<Output = Result<T, ReadError>> + Send + 'static {
    blocking(work).map_err(ReadError::thread)
}

/// What a task comes to; a panic goes on here.
pub(crate) async fn joined<T>(task: JoinHandle<T>) -> Result<T, ReadError> {
    match task.await {
        Ok(done) => Ok(done),
        Err(error) => match error.try_into_panic() {
            Ok(panic) => std::panic::resume_unwind(panic),
            Err(_) => Err(ReadError::Cancelled),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::format::directory::Extent;

    const MEBIBYTE: u64 = 1 << 20;

    /// A directory of tiles of so many mebibytes, 65,536 vertices each.
    fn directory(mebibytes: &[u32]) -> Directory {
        let extent = |length| Extent {
            offset: 8192,
            length,
            crc: 0,
        };
        let tiles = mebibytes.iter().map(|length| TileEntry {
            core: extent(length << 20),
            border: extent(0),
            generation: 1,
            vertices: 1 << 16,
            core_triangles: 0,
            border_triangles: 0,
            owned_triangles: 0,
            bounds: crate::geometry::Rect::EMPTY,
        });
        Directory {
            tiles: tiles.collect(),
            ..Directory::default()
        }
    }

    #[test]
    fn a_plan_fits_and_grows_with_the_memory_up_to_what_is_of_use() {
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
