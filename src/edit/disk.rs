//! The file during an edit: reads tiles, and writes changed tiles behind its end.

use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use bytes::Bytes;
use foldhash::HashMap;
use futures::future::try_join;
use tokio::sync::{MappedMutexGuard, Mutex, MutexGuard, oneshot};

use crate::constraints::seeds::Seeds;
use crate::edit::contradiction::Contradiction;
use crate::edit::error::EditError;
use crate::edit::survey::{Surveys, TileSurvey, table_without_regions};
use crate::edit::target::Target;
use crate::edit::tile::EditTile;
use crate::edit::tile::encode::{Counts, Numbering};
use crate::edit::tile::parts::TileParts;
use crate::edit::workers::Workers;
use crate::io::{Buffers, ReadAt, ThreadsFile};
use crate::memory::EditShares;
use crate::store::{
    Codec, Digest, DigestSum, Directory, Extent, FIRST_EXTENT, FreeSpace, Part, PassReader, StoredPart, Tile,
    TileEntry, TileId, TileWriter,
};

/// What an edit is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Purpose {
    /// The next state of a file.
    Commit,
    /// The next state of a draft, which nobody relies on: it is not synced to the medium.
    Draft,
    /// To see what would be done. The file has the same bytes afterwards.
    DryRun,
}

/// The file, and the current location of each tile in it.
pub(crate) struct Disk {
    path: PathBuf,
    /// The file as it was opened.
    pub(crate) reader: PassReader,
    file: ThreadsFile,
    generation: u32,
    /// `None` once the file is published.
    state: Mutex<Option<Written>>,
    /// Whether the file will say of which regions its triangles are. Without constraints it need not.
    pub(crate) has_regions: bool,
    seeds: Arc<Seeds>,
    buffers: Buffers,
    pub(crate) workers: Workers,
    /// Several tiles may be encoded at a time, but they are written in the order in which that
    /// began.
    order: WriteOrder,
    reads: AtomicU64,
    /// Dropped last, when the file is closed.
    _alive: oneshot::Sender<()>,
}

struct Written {
    writer: TileWriter<ThreadsFile>,
    entries: Vec<TileEntry>,
    /// The digests of the tiles that were written, without holes.
    digests: HashMap<TileId, Digest>,
    /// What the search for regions needs to know of these tiles, of as many as the memory allows.
    surveys: Surveys,
}

/// A tile to be encoded.
struct Surveyed {
    tile: Arc<EditTile>,
    numbering: Numbering,
    parts: TileParts,
    /// The sum of the triangles that belong to the tile.
    triangles: DigestSum,
}

/// What a file keeps of a tile besides its core and border.
struct Aside {
    table: Vec<u8>,
    /// `None` in a file without regions.
    survey: Option<TileSurvey>,
}

/// A tile as it is stored.
struct Encoded {
    counts: Counts,
    core: StoredPart,
    border: StoredPart,
}

impl Disk {
    /// Opens a file to edit it, with these shares of the memory and threads. `adds_lines` says whether
    /// constraints may come. The returned receiver ends when the last reference to the file is dropped.
    pub(crate) fn open(
        target: Target,
        reader: PassReader,
        EditShares { threads, surveys, .. }: EditShares,
        purpose: Purpose,
        adds_lines: bool,
    ) -> Result<(Arc<Self>, oneshot::Receiver<()>), EditError> {
        let Target { path, file, .. } = target;
        let free = free_space(&file, &reader, purpose);
        let generation = u32::try_from(reader.generation() + 1);
        // Nobody reads a draft.
        let workers = Workers::new(threads, purpose != Purpose::Draft);
        let written = Written {
            writer: TileWriter::behind(file.clone(), reader.file_length())
                .draft(purpose == Purpose::Draft)
                .reusing(free),
            entries: reader.directory().tiles.clone(),
            digests: HashMap::default(),
            surveys: Surveys::within(surveys),
        };
        let (alive, gone) = oneshot::channel();
        let seeds = Seeds::new(reader.directory().lists.hole_points.clone());
        let metadata = &reader.directory().metadata;
        let knows_regions = metadata.regions > 0 || metadata.constraint_edges > 0 || !seeds.is_empty();
        let disk = Self {
            has_regions: knows_regions || adds_lines || purpose == Purpose::Draft,
            generation: generation.map_err(|_| EditError::Internal("the file was edited too often".to_owned()))?,
            state: Mutex::new(Some(written)),
            order: WriteOrder::default(),
            seeds: Arc::new(seeds),
            buffers: Buffers::default(),
            workers: workers.map_err(|error| EditError::io(&path, "start a thread to edit", error))?,
            path,
            reads: AtomicU64::new(0),
            file,
            reader,
            _alive: alive,
        };
        Ok((Arc::new(disk), gone))
    }

    fn cannot(&self, what: &'static str, source: io::Error) -> EditError {
        EditError::io(&self.path, what, source)
    }

    /// Returns the error for a tile that contradicts itself or others.
    pub(crate) fn damaged(&self, tile: TileId, contradiction: Contradiction) -> EditError {
        self.reader.damaged(tile, contradiction.to_string()).into()
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the number of tiles that were read so far.
    pub(crate) fn reads(&self) -> u64 {
        self.reads.load(Ordering::Relaxed)
    }

    /// Returns the digest of the tiles that were written, without holes.
    pub(crate) async fn digest(&self) -> Result<Digest, EditError> {
        let mut digest = Digest::default();
        let state = self.written().await?;
        state.digests.values().for_each(|&of_tile| digest += of_tile);
        Ok(digest)
    }

    /// Returns what the search for regions needs to know of a tile that was written, if the memory
    /// allowed to keep it.
    pub(crate) async fn kept_survey(&self, id: TileId) -> Result<Option<TileSurvey>, EditError> {
        Ok(self.written().await?.surveys.take(id))
    }

    /// Reads a tile, and returns what the search for regions needs to know of it.
    pub(crate) async fn survey(&self, id: TileId) -> Result<TileSurvey, EditError> {
        let stored = self.read(id).await?;
        let seeds = Arc::clone(&self.seeds);
        let survey = move || {
            let tile = EditTile::of(&stored, true);
            TileSurvey::of(&tile, &tile.in_order(), &TileParts::stored(&stored), &seeds)
        };
        self.workers.run(survey).await
    }

    /// Publishes the current tiles, with the directory as it was, with room for all of them, which
    /// `change` adapts. Returns the length of the file. No tile can be read or written afterwards.
    pub(crate) async fn publish(
        &self,
        mut directory: Directory,
        change: impl FnOnce(&mut Directory),
    ) -> Result<u64, EditError> {
        let Some(Written { writer, entries, .. }) = self.state.lock().await.take() else {
            return Err(EditError::Internal("the file is published already".to_owned()));
        };
        directory.set_tiles(entries);
        directory.remove_emptied();
        directory.renew_bounds();
        change(&mut directory);
        let done = writer.replace(&directory, self.reader.in_force()).await;
        done.map_err(|error| self.cannot("finish", error))
    }

    /// Makes room for tiles that the file does not have yet, up to a number.
    pub(crate) async fn add_tiles(&self, count: usize) -> Result<(), EditError> {
        self.written().await?.entries.resize(count, TileEntry::UNUSED);
        Ok(())
    }

    /// Cuts off what was written. Returns the length that the file had with it.
    pub(crate) async fn abandon(&self) -> Result<u64, EditError> {
        let mut state = self.written().await?;
        let flushed = state.writer.flush().await;
        let cut = flushed.and_then(|()| self.file.truncate(self.reader.file_length()));
        cut.map_err(|error| self.cannot("cut off what was written behind", error))?;
        Ok(state.writer.length())
    }

    async fn written(&self) -> Result<MappedMutexGuard<'_, Written>, EditError> {
        MutexGuard::try_map(self.state.lock().await, Option::as_mut).map_err(|_| EditError::Cancelled)
    }

    /// Reads a tile from the file.
    pub(crate) async fn read(&self, id: TileId) -> Result<Tile, EditError> {
        let entry = {
            let mut state = self.written().await?;
            // Buffered writes must be in the file before it is read.
            let flushed = state.writer.flush().await;
            flushed.map_err(|error| self.cannot("write", error))?;
            state.entries.get(id.0 as usize).copied()
        };
        let entry = entry.ok_or_else(|| self.damaged(id, Contradiction::NoTile))?;
        self.reads.fetch_add(1, Ordering::Relaxed);
        let apart = entry.table.apart();
        let ranges = [Some(entry.core), Some(entry.border), apart].into_iter().flatten();
        let ranges: Vec<Range<u64>> = ranges.map(Extent::range).collect();
        let read = self.file.read_many(&ranges).await;
        let read: Vec<Bytes> = read.map_err(|error| self.cannot("read", error))?;
        let [core, border, table @ ..] = &read[..] else {
            return Err(self.cannot("read", io::ErrorKind::Other.into()));
        };
        Tile::open(id, &entry, [core, border], table.first()).map_err(|reason| self.reader.damaged(id, reason).into())
    }

    /// Returns the component table of a tile that was not changed, and the number of components.
    pub(crate) async fn table(&self, id: TileId) -> Result<(Vec<u8>, u32), EditError> {
        let entry = self.written().await?.entries[id.0 as usize];
        Ok(self.reader.component_table(id, &entry).await?)
    }

    /// Puts a component table in the place of that of a tile.
    pub(crate) async fn put_table(&self, id: TileId, table: Vec<u8>) -> Result<(), EditError> {
        let mut state = self.written().await?;
        let before = state.entries[id.0 as usize];
        if before.table.holds(&table) {
            return Ok(());
        }
        if let Some(extent) = before.table.apart().filter(|_| before.generation == self.generation) {
            state.writer.release(extent);
        }
        let placed = state.writer.place_table(table).await;
        state.entries[id.0 as usize].table = placed.map_err(|error| self.cannot("write", error))?;
        Ok(())
    }

    /// Returns a tile to be changed. Without an entry, it has no vertices yet, or any more.
    pub(crate) async fn load(self: Arc<Self>, id: TileId) -> Result<Arc<EditTile>, EditError> {
        let entry = self.written().await?.entries.get(id.0 as usize).copied();
        if entry.is_some_and(|entry| entry.is_unused()) {
            return Ok(Arc::new(EditTile::empty(id)));
        }
        let tile = Arc::new(self.read(id).await?);
        let (same, has_regions) = (Arc::clone(&tile), self.has_regions);
        let vertices = self.workers.run(move || EditTile::vertices_of(&same));
        let triangles = self.workers.run(move || EditTile::triangles_of(&tile, has_regions));
        let (vertices, triangles) = try_join(vertices, triangles).await?;
        Ok(Arc::new(EditTile::joined(vertices, triangles)))
    }

    /// Writes a tile, after those of earlier calls.
    pub(crate) fn write(
        self: Arc<Self>,
        id: TileId,
        tile: Arc<EditTile>,
    ) -> impl Future<Output = Result<(), EditError>> + Send + 'static {
        let turn = self.order.take();
        self.write_in_turn(id, tile, turn)
    }

    async fn write_in_turn(self: Arc<Self>, id: TileId, tile: Arc<EditTile>, turn: WriteTurn) -> Result<(), EditError> {
        let this = Arc::clone(&self);
        let (surveyed, Aside { table, survey }) = self.workers.run(move || this.surveyed(tile)).await?;
        let Encoded { counts, core, border } = self.encoded(id, surveyed).await?;
        let _done = turn.wait().await;
        let mut state = self.written().await?;
        let before = state.entries[id.0 as usize];
        if before.generation == self.generation {
            // No superblock refers to these bytes.
            let extents = [Some(before.core), Some(before.border), before.table.apart()];
            for extent in extents.into_iter().flatten() {
                state.writer.release(extent);
            }
        }
        state.digests.insert(id, counts.digest);
        if counts.is_empty() {
            state.surveys.take(id);
            state.entries[id.0 as usize] = TileEntry::UNUSED;
            return Ok(());
        }
        // Whoever reads the tile again needs to know the number of its components.
        let table = state.writer.place_table(table).await;
        let table = table.map_err(|error| self.cannot("write", error))?;
        if let Some(survey) = survey {
            state.surveys.put(survey);
        }
        let written = async {
            let core = state.writer.append_core(core).await?;
            Ok((core, state.writer.append_border(border).await?))
        };
        let (core, border) = written.await.map_err(|error| self.cannot("write", error))?;
        state.entries[id.0 as usize] = TileEntry {
            table,
            ..counts.entry(core, border, self.generation)
        };
        Ok(())
    }

    /// Returns the codec of a tile, which it keeps. New tiles have that of the first.
    fn codec_of(&self, id: TileId) -> Codec {
        let directory = self.reader.directory();
        directory.entry(id).map_or_else(|| directory.codec(), TileEntry::codec)
    }

    /// Finds out what must be known of a tile before it is encoded.
    fn surveyed(&self, tile: Arc<EditTile>) -> (Surveyed, Aside) {
        let order = tile.in_order();
        let (parts, triangles, aside) = if self.has_regions {
            let parts = TileParts::of(&tile, &order);
            let survey = TileSurvey::of(&tile, &order, &parts, &self.seeds);
            let (table, triangles) = (survey.table.clone(), survey.triangles);
            let survey = Some(survey);
            (parts, triangles, Aside { table, survey })
        } else {
            let (triangles, survey) = (tile.owned(), None);
            let table = table_without_regions(&tile, &order, triangles);
            (TileParts::whole(&tile, &order), triangles, Aside { table, survey })
        };
        let surveyed = Surveyed {
            numbering: Numbering::of(&tile, order),
            tile,
            parts,
            triangles,
        };
        (surveyed, aside)
    }

    /// Encodes a tile, its core and its border at the same time.
    async fn encoded(self: &Arc<Self>, id: TileId, surveyed: Surveyed) -> Result<Encoded, EditError> {
        let codec = self.codec_of(id);
        let surveyed = Arc::new(surveyed);
        let (this, theirs) = (Arc::clone(self), Arc::clone(&surveyed));
        let core = self.workers.run(move || this.core(&theirs, codec));
        let this = Arc::clone(self);
        let border = self.workers.run(move || this.border(&surveyed, codec));
        let (core, (border, counts)) = try_join(core, border).await?;
        Ok(Encoded { counts, core, border })
    }

    fn core(&self, surveyed: &Surveyed, codec: Codec) -> StoredPart {
        let Surveyed {
            tile, numbering, parts, ..
        } = surveyed;
        let core = tile.encode_core(numbering, parts, self.generation, &self.buffers);
        codec.store(core, Part::Core)
    }

    fn border(&self, surveyed: &Surveyed, codec: Codec) -> (StoredPart, Counts) {
        let Surveyed {
            tile,
            numbering,
            parts,
            triangles,
            ..
        } = surveyed;
        let border = tile.encode_border(numbering, parts, self.generation, &self.buffers);
        (codec.store(border, Part::Border), tile.counts(numbering, *triangles))
    }
}

/// Returns the bytes of a file that may be overwritten: those between the extents of its state in
/// force, if nobody reads an earlier one.
fn free_space(file: &ThreadsFile, reader: &PassReader, purpose: Purpose) -> FreeSpace {
    // Where it cannot be found out, somebody may.
    if purpose != Purpose::Commit || file.is_locked_below(reader.generation()).unwrap_or(true) {
        return FreeSpace::default();
    }
    FreeSpace::around(reader.directory().ranges(), FIRST_EXTENT..reader.file_length())
}

/// The order of writes.
#[derive(Default)]
struct WriteOrder(parking_lot::Mutex<Option<oneshot::Receiver<()>>>);

/// A turn to write, which comes when the one before is done.
struct WriteTurn {
    before: Option<oneshot::Receiver<()>>,
    done: oneshot::Sender<()>,
}

impl WriteOrder {
    fn take(&self) -> WriteTurn {
        let (done, after) = oneshot::channel();
        let before = self.0.lock().replace(after);
        WriteTurn { before, done }
    }
}

impl WriteTurn {
    /// Waits for the turns before. The next turn comes when the returned sender is dropped.
    async fn wait(self) -> oneshot::Sender<()> {
        if let Some(before) = self.before {
            // Whether the turn before was completed or abandoned, it is over.
            let _ = before.await;
        }
        self.done
    }
}
