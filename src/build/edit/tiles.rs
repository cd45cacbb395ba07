//! The tiles of a file while it is edited: those in work in memory, the least recently used ones written behind the end of the
//! file when they were changed.
//!
//! What is there is never overwritten: until the superblock says otherwise, the file is what it was.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bytes::Bytes;
use futures::executor::block_on;
use lru::LruCache;

use super::EditError;
use super::tile::{Drafts, EditTile};
use crate::io::{Buffers, ReadAt, ThreadsFile};
use crate::store::{Component, Directory, OpenOptions, ReadError, Tile, TileEntry, TileId, TileReader, TileWriter};

/// The tiles of a file, to be changed.
pub(super) struct Tiles {
    path: PathBuf,
    reader: TileReader,
    file: ThreadsFile,
    writer: TileWriter<ThreadsFile>,
    /// Where each tile lies now.
    entries: Vec<TileEntry>,
    loaded: LruCache<TileId, Loaded>,
    bytes: usize,
    capacity: usize,
    generation: u32,
    /// Tiles that were changed since the file was opened.
    pub(super) is_changed: Vec<bool>,
    buffers: Buffers,
    pub(super) loads: u64,
    pub(super) written: u64,
}

struct Loaded {
    tile: EditTile,
    /// As it counts.
    bytes: usize,
    is_dirty: bool,
}

impl Tiles {
    /// Opens a file to edit it, which nobody else must do meanwhile; tiles in memory take up to `capacity` bytes.
    pub(super) fn open(path: &Path, capacity: u64) -> Result<Self, EditError> {
        let cannot = |what: &'static str| {
            move |source| EditError::Io {
                file: path.to_owned(),
                what,
                source,
            }
        };
        let file = File::options()
            .read(true)
            .write(true)
            .open(path)
            .map_err(cannot("open"))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(std::fs::TryLockError::WouldBlock) => return Err(EditError::Busy(path.to_owned())),
            Err(std::fs::TryLockError::Error(error)) => return Err(cannot("lock")(error)),
        }
        let file = ThreadsFile::from(Arc::new(file));
        let name = path.display().to_string();
        let reader = block_on(TileReader::open_source(file.clone(), &name, OpenOptions::default()))?;
        let generation = u32::try_from(reader.generation() + 1);
        let directory = reader.directory();
        Ok(Self {
            path: path.to_owned(),
            writer: TileWriter::behind(file.clone(), reader.file_length()),
            entries: directory.tiles.clone(),
            loaded: LruCache::unbounded(),
            bytes: 0,
            capacity: capacity as usize,
            generation: generation.map_err(|_| EditError::Internal("the file was edited too often".to_owned()))?,
            is_changed: vec![false; directory.tiles.len()],
            buffers: Buffers::default(),
            loads: 0,
            written: 0,
            file,
            reader,
        })
    }

    /// The file as it was opened.
    pub(super) fn directory(&self) -> &Directory {
        self.reader.directory()
    }

    /// The error for tiles that contradict each other.
    pub(super) fn damaged(&self, tile: TileId, reason: impl Into<String>) -> EditError {
        self.reader.damaged(tile, reason).into()
    }

    /// A tile to look at or, after [`change`](Self::change), to change.
    pub(super) fn get(&mut self, id: TileId) -> Result<&mut EditTile, EditError> {
        if self.loaded.get(&id).is_none() {
            let tile = EditTile::of(&self.read(id)?);
            let bytes = tile.byte_size();
            self.make_room(bytes)?;
            self.bytes += bytes;
            let loaded = Loaded {
                tile,
                bytes,
                is_dirty: false,
            };
            self.loaded.put(id, loaded);
        }
        match self.loaded.get_mut(&id) {
            Some(loaded) => Ok(&mut loaded.tile),
            None => Err(EditError::Internal("a tile that was just loaded is gone".to_owned())),
        }
    }

    /// A tile that will be written again.
    pub(super) fn change(&mut self, id: TileId) -> Result<&mut EditTile, EditError> {
        self.get(id)?;
        self.is_changed[id.0 as usize] = true;
        // It may have grown since it was counted.
        if let Some(loaded) = self.loaded.get_mut(&id) {
            loaded.is_dirty = true;
            let bytes = loaded.tile.byte_size();
            self.bytes += bytes - loaded.bytes.min(bytes);
            loaded.bytes = loaded.bytes.max(bytes);
        }
        self.get(id)
    }

    /// The bytes of a tile as they lie in the file, checked.
    pub(super) fn read(&mut self, id: TileId) -> Result<Tile, EditError> {
        let Some(entry) = self.entries.get(id.0 as usize).copied() else {
            return Err(self.damaged(id, "a vertex is of a tile that there is not"));
        };
        // What was gathered to be written must be there to be read.
        block_on(self.writer.flush()).map_err(|error| self.cannot("write", error))?;
        self.loads += 1;
        let read = block_on(self.file.read_many(&[entry.core.range(), entry.border.range()]));
        let read = read.map_err(|error| self.cannot("read", error))?;
        let [core, border]: [Bytes; 2] = read
            .try_into()
            .map_err(|_| self.cannot("read", io::ErrorKind::Other.into()))?;
        Tile::open(id, &entry, &core, &border).map_err(|reason| self.damaged(id, reason))
    }

    fn cannot(&self, what: &'static str, source: io::Error) -> EditError {
        EditError::Io {
            file: self.path.clone(),
            what,
            source,
        }
    }

    /// Lets the least recently used tiles go until there is room for so many bytes.
    fn make_room(&mut self, bytes: usize) -> Result<(), EditError> {
        while self.bytes + bytes > self.capacity {
            let Some((id, loaded)) = self.loaded.pop_lru() else {
                break;
            };
            self.bytes -= loaded.bytes;
            if loaded.is_dirty {
                // Its regions are put down at the end.
                self.write(id, &loaded.tile.drafts(None))?;
            }
        }
        Ok(())
    }

    /// A tile that is to be written by other means: it is in memory no more.
    pub(super) fn take(&mut self, id: TileId) -> Result<EditTile, EditError> {
        match self.loaded.pop(&id) {
            Some(loaded) => {
                self.bytes -= loaded.bytes;
                Ok(loaded.tile)
            }
            None => Ok(EditTile::of(&self.read(id)?)),
        }
    }

    /// Bytes of the file when it was opened.
    pub(super) fn length(&self) -> u64 {
        self.reader.file_length()
    }

    /// Writes a tile with its regions.
    pub(super) fn write_labelled(
        &mut self,
        tile: &EditTile,
        label: &dyn Fn(u32) -> Component,
    ) -> Result<(), EditError> {
        self.write(tile.id, &tile.drafts(Some(label)))
    }

    fn write(&mut self, id: TileId, drafts: &Drafts) -> Result<(), EditError> {
        let core = drafts.core.encode(id, self.generation, &self.buffers);
        let border = drafts.border.encode(id, self.generation, &self.buffers);
        let written = block_on(async {
            let core = self.writer.append_core(&core).await?;
            Ok((core, self.writer.append_border(&border).await?))
        });
        let (core, border) = written.map_err(|error| self.cannot("write", error))?;
        self.written += 1;
        let entry = drafts.entry(&self.entries[id.0 as usize], self.generation);
        self.entries[id.0 as usize] = TileEntry { core, border, ..entry };
        Ok(())
    }

    /// Makes the file what its tiles are now, with a directory that `change` adapts. Returns its length.
    pub(super) fn publish(self, change: impl FnOnce(&mut Directory)) -> Result<u64, EditError> {
        let mut directory = self.reader.directory().clone();
        directory.tiles = self.entries;
        change(&mut directory);
        let before = self.reader.in_force();
        let path = self.path;
        let done = block_on(self.writer.replace(&directory, before));
        done.map_err(|source| EditError::Io {
            file: path,
            what: "finish",
            source,
        })
    }
}

impl From<ReadError> for EditError {
    fn from(error: ReadError) -> Self {
        Self::Read(error)
    }
}
