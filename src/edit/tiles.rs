//! The tiles of a file while it is edited: those in work in a cache, whose dirty ones are written behind the end of the file when
//! they have to go.
//!
//! What is there is never overwritten: until the superblock says otherwise, the file is what it was.

use std::collections::VecDeque;
use std::fs::{File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::pin::pin;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock, mpsc};

use bytes::Bytes;
use foldhash::{HashMap, HashMapExt};
use futures::future::FutureExt;
use tokio::runtime::Handle;
use tokio::sync::{MappedMutexGuard, Mutex, MutexGuard, oneshot};
use tokio::task::JoinHandle;

use crate::edit::error::EditError;
use crate::edit::regions::{Labels, Parts};
use crate::edit::tile::EditTile;
use crate::geometry::HalfEdge;
use crate::io::{Buffers, ReadAt, ThreadsFile, open_regular, output_target, start_thread};
use crate::memory::EditShares;
use crate::mesh::{Twin, next_side};
use crate::shown;
use crate::store::{
    BLOCK, Directory, EditCache, EditLease, EditPin, Extent, Failure, OpenOptions, ReadError, Tile, TileEntry, TileId,
    TileReader, TileWriter, Weight,
};

/// The tiles of a file, to be changed by one thread, which may wait for them; it is none of the runtime's.
pub(crate) struct Tiles {
    runtime: Handle,
    cache: EditCache<TileId, EditTile, EditError>,
    disk: Arc<Disk>,
    /// Tiles that were changed since the file was opened.
    pub(crate) is_changed: Vec<bool>,
    /// Ends when nobody has `disk` any more.
    gone: oneshot::Receiver<()>,
}

/// A tile to look at.
pub(crate) type Pin = EditPin<TileId, EditTile, EditError>;

/// The file, and where in it each tile lies now.
struct Disk {
    path: PathBuf,
    reader: TileReader,
    file: ThreadsFile,
    generation: u32,
    /// None once the file is published.
    state: Mutex<Option<Written>>,
    /// What regions tiles are written with, once it is known.
    labels: OnceLock<Labels>,
    buffers: Buffers,
    desk: Desk,
    /// Several tiles may be put together at a time, but are written in the order in which that began.
    turn: Turn,
    reads: AtomicU64,
    /// The last to be dropped, when the file is closed.
    _alive: oneshot::Sender<()>,
}

struct Written {
    writer: TileWriter<ThreadsFile>,
    entries: Vec<TileEntry>,
    /// Where tiles lie that this edit has written once more since: places and bytes.
    free: Vec<(u64, u32)>,
    /// Bytes of the places that were used again, for less.
    reused: HashMap<u64, u32>,
    /// How many triangles of each tile are in holes, of those that were written with labels.
    in_holes: HashMap<TileId, u32>,
}

impl Written {
    /// Writes a core, or a border: over what this edit has no use for any more, or behind the end.
    async fn put(&mut self, bytes: &Bytes, is_core: bool) -> io::Result<Extent> {
        let fits = |&&(place, room): &&(u64, u32)| room as usize >= bytes.len() && (!is_core || place % BLOCK == 0);
        let best = self.free.iter().filter(fits).min_by_key(|(_, room)| *room).copied();
        if let Some((place, room)) = best {
            self.free.retain(|free| free.0 != place);
            self.reused.insert(place, room);
            return self.writer.put_at(place, bytes).await;
        }
        match is_core {
            true => self.writer.append_core(bytes).await,
            false => self.writer.append_border(bytes).await,
        }
    }

    /// Says that nobody looks at these bytes any more.
    fn set_free(&mut self, extent: Extent) {
        let room = self.reused.remove(&extent.offset).unwrap_or(extent.length);
        self.free.push((extent.offset, room));
    }
}

/// A file that nobody else may edit as long as this, or what it is given to, is there.
pub(crate) struct Target {
    pub(crate) path: PathBuf,
    file: ThreadsFile,
}

impl Target {
    pub(crate) fn lock(path: &Path) -> Result<Self, EditError> {
        let target = output_target(path).map_err(|error| cannot(path, "open", error))?;
        let file = open_regular(&target, File::options().read(true).write(true));
        let (file, _) = file.map_err(|error| cannot(path, "open", error))?;
        match file.try_lock() {
            Ok(()) => Ok(Self {
                path: path.to_owned(),
                file: ThreadsFile::from(Arc::new(file)),
            }),
            Err(TryLockError::WouldBlock) => Err(EditError::Busy(path.to_owned())),
            Err(TryLockError::Error(error)) => Err(cannot(path, "lock", error)),
        }
    }

    /// The file as it is now.
    pub(crate) async fn read(&self) -> Result<TileReader, ReadError> {
        let name = shown::path(&self.path);
        TileReader::open_source(self.file.clone(), &name, OpenOptions::default()).await
    }
}

pub(crate) fn cannot(path: &Path, what: &'static str, source: io::Error) -> EditError {
    EditError::Io {
        file: path.to_owned(),
        what,
        source: Arc::new(source),
    }
}

impl Weight for EditTile {
    fn weight(&self) -> usize {
        self.byte_size()
    }
}

impl Failure for EditError {
    const CANCELLED: Self = Self::Cancelled;

    fn is_cancelled(&self) -> bool {
        matches!(self, Self::Cancelled)
    }
}

impl From<ReadError> for EditError {
    fn from(error: ReadError) -> Self {
        Self::Read(error)
    }
}

impl Tiles {
    /// Opens a file to edit it; `shares` tells how much memory there is for its tiles, from the bytes of the largest. A file that is a
    /// `draft` is not made sure to be on the medium.
    pub(crate) fn open(
        target: Target,
        shares: &dyn Fn(u64) -> EditShares,
        is_draft: bool,
        runtime: Handle,
    ) -> Result<Self, EditError> {
        let reader = runtime.block_on(target.read())?;
        let EditShares { threads, tiles } = shares(reader.largest_tile());
        let Target { path, file } = target;
        let generation = u32::try_from(reader.generation() + 1);
        let entries = reader.directory().tiles.clone();
        let (alive, gone) = oneshot::channel();
        let disk = Arc::new(Disk {
            generation: generation.map_err(|_| EditError::Internal("the file was edited too often".to_owned()))?,
            state: Mutex::new(Some(Written {
                writer: TileWriter::behind(file.clone(), reader.file_length()).draft(is_draft),
                entries,
                free: Vec::new(),
                reused: HashMap::new(),
                in_holes: HashMap::new(),
            })),
            turn: Turn::default(),
            labels: OnceLock::new(),
            buffers: Buffers::default(),
            desk: Desk::new(threads).map_err(|error| cannot(&path, "start a thread to edit", error))?,
            path,
            reads: AtomicU64::new(0),
            file,
            reader,
            _alive: alive,
        });
        let theirs = Arc::clone(&disk);
        let write_back = move |id, tile| Arc::clone(&theirs).write(id, tile).boxed();
        Ok(Self {
            runtime,
            cache: EditCache::new(tiles as usize, write_back),
            is_changed: vec![false; disk.reader.directory().tiles.len()],
            disk,
            gone,
        })
    }

    /// The directory of the file as it was opened.
    pub(crate) fn directory(&self) -> &Directory {
        self.disk.reader.directory()
    }

    /// Bytes of the file as it was opened.
    pub(crate) fn length(&self) -> u64 {
        self.disk.reader.file_length()
    }

    /// Tiles that were read so far.
    pub(crate) fn reads(&self) -> u64 {
        self.disk.reads.load(Ordering::Relaxed)
    }

    /// The error for tiles that contradict each other.
    pub(crate) fn damaged(&self, tile: TileId, reason: impl Into<String>) -> EditError {
        self.disk.reader.damaged(tile, reason).into()
    }

    /// A tile to look at. It must be given back before it is changed, or it is copied.
    pub(crate) fn get(&self, id: TileId) -> Result<Pin, EditError> {
        let load = || Arc::clone(&self.disk).load(id);
        self.wait_for(self.cache.read(id, load))
    }

    /// What comes of a future. Mostly it is there at once, since the tile is in the cache: then the runtime has nothing to do.
    fn wait_for<T>(&self, future: impl Future<Output = T>) -> T {
        let mut future = pin!(future);
        let _context = self.runtime.enter();
        let at_once = future.as_mut().now_or_never();
        at_once.unwrap_or_else(|| self.runtime.block_on(future))
    }

    /// The side across a side, with a tile that has it. None: that is the outside.
    pub(crate) fn over(&self, tile: Pin, side: u32) -> Result<Option<(Pin, u32)>, EditError> {
        match tile.across(side) {
            Twin::HalfEdge(HalfEdge(other)) => Ok(Some((tile, other))),
            Twin::Hull => Ok(None),
            Twin::Elsewhere => {
                // The tile of an end of the edge has the triangle across.
                let ends = [next_side(side), side].map(|side| tile.from(side).id);
                let tile = self.get(ends[0].tile)?;
                Ok(tile.side_between(ends[0], ends[1]).map(|other| (tile, other)))
            }
        }
    }

    /// Begins to read tiles that will be asked for next, as many as are put together at a time.
    pub(crate) fn read_ahead(&self, ids: impl Iterator<Item = TileId>) {
        // One thread has enough to do with the one that is waited for.
        let ids = ids.take(self.disk.desk.threads.saturating_sub(1));
        for id in ids {
            let (reader, disk) = (self.cache.reader(), Arc::clone(&self.disk));
            // If it fails, whoever asks for the tile tries again, and has the error.
            let read = async move { drop(reader.read(id, || disk.load(id)).await) };
            self.runtime.spawn(read);
        }
    }

    /// All tiles in order, with their parts, which are found as many at a time as are put together.
    pub(crate) fn parted(&self) -> PartedTiles<'_> {
        PartedTiles {
            tiles: self,
            next: 0,
            coming: VecDeque::new(),
        }
    }

    /// How many triangles of a tile are in holes, if it was written with labels.
    pub(crate) fn in_holes(&self, id: TileId) -> Option<u32> {
        let state = self.runtime.block_on(self.disk.state.lock());
        state.as_ref()?.in_holes.get(&id).copied()
    }

    /// A tile to change, one at a time.
    pub(crate) fn change(&mut self, id: TileId) -> Result<EditLease<'_, TileId, EditTile, EditError>, EditError> {
        if let Some(is_changed) = self.is_changed.get_mut(id.0 as usize) {
            *is_changed = true;
        }
        let load = || Arc::clone(&self.disk).load(id);
        self.wait_for(self.cache.edit(id, load))
    }

    /// A tile as it lies in the file.
    pub(crate) fn read(&self, id: TileId) -> Result<Tile, EditError> {
        self.runtime.block_on(self.disk.read(id))
    }

    /// From now on tiles are written with their regions.
    pub(crate) fn label(&mut self, labels: Labels) -> Result<&Labels, EditError> {
        // What has been written without them is written again, and what has not been written yet will be.
        let changed = (0..self.is_changed.len()).filter(|&tile| self.is_changed[tile]);
        let changed: Vec<TileId> = changed.map(|tile| TileId(tile as u32)).collect();
        self.disk.labels.get_or_init(|| labels);
        for id in changed {
            self.change(id)?.touch();
        }
        self.runtime.block_on(self.cache.flush(self.disk.desk.threads))?;
        match self.disk.labels.get() {
            Some(labels) => Ok(labels),
            None => Err(EditError::Internal("there are no labels".to_owned())),
        }
    }

    /// Writes a tile that is not in the cache.
    pub(crate) fn write(&mut self, tile: EditTile) -> Result<(), EditError> {
        let id = tile.id;
        self.is_changed[id.0 as usize] = true;
        self.runtime.block_on(Arc::clone(&self.disk).write(id, Arc::new(tile)))
    }

    /// What the labels of a file are.
    pub(crate) fn labels(&self) -> Option<&Labels> {
        self.disk.labels.get()
    }

    /// Makes the file what its tiles are now, with a directory that `change` adapts. Returns its length.
    pub(crate) fn publish(self, change: impl FnOnce(&mut Directory)) -> Result<u64, EditError> {
        let Self {
            runtime,
            cache,
            disk,
            gone,
            ..
        } = self;
        tracing::debug!(cache = %cache.statistics(), "edited");
        let (path, reader) = (disk.path.clone(), disk.reader.clone());
        let written = runtime.block_on(disk.state.lock()).take();
        let Some(Written { writer, entries, .. }) = written else {
            return Err(EditError::Internal("the file is published already".to_owned()));
        };
        let mut directory = reader.directory().clone();
        directory.tiles = entries;
        change(&mut directory);
        let done = runtime.block_on(writer.replace(&directory, reader.in_force()));
        // Tiles may still be read ahead, in vain, with the file locked. Whoever edits it next shall find it free.
        drop((cache, disk, reader));
        let _ = runtime.block_on(gone);
        done.map_err(|error| cannot(&path, "finish", error))
    }
}

impl Disk {
    fn cannot(&self, what: &'static str, source: io::Error) -> EditError {
        cannot(&self.path, what, source)
    }

    async fn written(&self) -> Result<MappedMutexGuard<'_, Written>, EditError> {
        MutexGuard::try_map(self.state.lock().await, Option::as_mut).map_err(|_| EditError::Cancelled)
    }

    async fn read(&self, id: TileId) -> Result<Tile, EditError> {
        let entry = {
            let mut state = self.written().await?;
            // What was gathered to be written must be there to be read.
            let flushed = state.writer.flush().await;
            flushed.map_err(|error| self.cannot("write", error))?;
            state.entries.get(id.0 as usize).copied()
        };
        let damaged = |reason: String| EditError::from(self.reader.damaged(id, reason));
        let entry = entry.ok_or_else(|| damaged("a vertex is of a tile that there is not".to_owned()))?;
        self.reads.fetch_add(1, Ordering::Relaxed);
        let read = self.file.read_many(&[entry.core.range(), entry.border.range()]).await;
        let read = read.map_err(|error| self.cannot("read", error))?;
        let [core, border]: [Bytes; 2] = read
            .try_into()
            .map_err(|_| self.cannot("read", io::ErrorKind::Other.into()))?;
        Tile::open(id, &entry, &core, &border).map_err(|damage| damaged(damage.into()))
    }

    async fn load(self: Arc<Self>, id: TileId) -> Result<Arc<EditTile>, EditError> {
        let tile = self.read(id).await?;
        self.desk.computed(move || Arc::new(EditTile::of(&tile))).await
    }

    /// Writes a tile, after those that this was called for before.
    fn write(
        self: Arc<Self>,
        id: TileId,
        tile: Arc<EditTile>,
    ) -> impl Future<Output = Result<(), EditError>> + Send + 'static {
        let turn = self.turn.take();
        self.write_in_turn(id, tile, turn)
    }

    async fn write_in_turn(self: Arc<Self>, id: TileId, tile: Arc<EditTile>, turn: Place) -> Result<(), EditError> {
        let this = Arc::clone(&self);
        let (counts, core, border) = self
            .desk
            .computed(move || {
                let drafts = match this.labels.get() {
                    Some(labels) => {
                        let parts = Parts::of(&tile);
                        tile.drafts(Some(&|place| labels.of(id, &parts, place)))
                    }
                    None => tile.drafts(None),
                };
                let core = drafts.core.encode(id, this.generation, &this.buffers);
                let border = drafts.border.encode(id, this.generation, &this.buffers);
                (drafts.counts(), core, border)
            })
            .await?;
        let _done = turn.wait().await;
        let mut state = self.written().await?;
        let before = state.entries[id.0 as usize];
        if before.generation == self.generation {
            // No superblock leads there.
            state.set_free(before.core);
            state.set_free(before.border);
        }
        let written = async {
            let core = state.put(&core, true).await?;
            Ok((core, state.put(&border, false).await?))
        };
        let (core, border) = written.await.map_err(|error| self.cannot("write", error))?;
        if self.labels.get().is_some() {
            state.in_holes.insert(id, counts.in_holes);
        }
        let entry = counts.entry(&before, self.generation);
        state.entries[id.0 as usize] = TileEntry { core, border, ..entry };
        Ok(())
    }
}

/// A tile and its parts; and what it was, if it is not changed.
pub(crate) struct PartedTile {
    pub(crate) tile: Arc<EditTile>,
    pub(crate) parts: Parts,
    pub(crate) before: Option<Tile>,
}

/// All tiles of a file, in order.
pub(crate) struct PartedTiles<'a> {
    tiles: &'a Tiles,
    next: u32,
    coming: VecDeque<JoinHandle<Result<PartedTile, EditError>>>,
}

impl PartedTiles<'_> {
    pub(crate) fn next(&mut self) -> Result<Option<PartedTile>, EditError> {
        let Tiles {
            runtime,
            cache,
            disk,
            is_changed,
            ..
        } = self.tiles;
        while self.coming.len() < disk.desk.threads
            && let Some(&is_changed) = is_changed.get(self.next as usize)
        {
            let id = TileId(self.next);
            let (reader, disk) = (cache.reader(), Arc::clone(disk));
            self.next += 1;
            self.coming.push_back(runtime.spawn(async move {
                let parted = |tile: Arc<EditTile>, before| {
                    let parts = Parts::of(&tile);
                    PartedTile { tile, parts, before }
                };
                if is_changed {
                    let tile = reader.read(id, || Arc::clone(&disk).load(id)).await?;
                    let tile = Arc::clone(&tile);
                    disk.desk.computed(move || parted(tile, None)).await
                } else {
                    let before = disk.read(id).await?;
                    let part = move || parted(Arc::new(EditTile::of(&before)), Some(before));
                    disk.desk.computed(part).await
                }
            }));
        }
        let Some(coming) = self.coming.pop_front() else {
            return Ok(None);
        };
        let gone = |_| EditError::Internal("a task that reads tiles is gone".to_owned());
        runtime.block_on(coming).map_err(gone)?.map(Some)
    }
}

/// Whose turn it is to write.
#[derive(Default)]
struct Turn(parking_lot::Mutex<Option<oneshot::Receiver<()>>>);

/// A place in the order: when the one before is done.
struct Place {
    before: Option<oneshot::Receiver<()>>,
    done: oneshot::Sender<()>,
}

impl Turn {
    fn take(&self) -> Place {
        let (done, after) = oneshot::channel();
        let before = self.0.lock().replace(after);
        Place { before, done }
    }
}

impl Place {
    /// Waits for the ones before. It is the next one's turn when the answer is dropped.
    async fn wait(self) -> oneshot::Sender<()> {
        if let Some(before) = self.before {
            // Whether it was done or given up, its turn is over.
            let _ = before.await;
        }
        self.done
    }
}

type Job = Box<dyn FnOnce() + Send>;

/// Threads for what takes a while, as many as the system gives, beside the runtime's workers: few, so that the allocator keeps what goes for what comes next, and not
/// some for each of many threads.
struct Desk {
    jobs: mpsc::Sender<Job>,
    threads: usize,
}

impl Desk {
    fn new(threads: usize) -> io::Result<Self> {
        let (jobs, work) = mpsc::channel::<Job>();
        let work = Arc::new(parking_lot::Mutex::new(work));
        let start = |number| {
            let work = Arc::clone(&work);
            let next = move || work.lock().recv().ok();
            start_thread(&format!("tile-edit-desk-{number}"), move || {
                std::iter::from_fn(next).for_each(|job| job());
            })
        };
        start(0)?;
        let others = (1..threads).map_while(|number| start(number).ok()).count();
        Ok(Self {
            jobs,
            threads: 1 + others,
        })
    }

    async fn computed<T: Send + 'static>(&self, compute: impl FnOnce() -> T + Send + 'static) -> Result<T, EditError> {
        let (reply, computed) = oneshot::channel();
        // If nobody waits for the answer any more, nobody needs it. If the thread is gone, there is none.
        let _ = self.jobs.send(Box::new(move || drop(reply.send(compute()))));
        computed
            .await
            .map_err(|_| EditError::Internal("a tile could not be put together".to_owned()))
    }
}
