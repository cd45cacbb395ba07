//! Chunks of bytes: in memory up to a limit, then in a file.

use std::fs::File;
use std::ops::Range;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::{fs, io};

use parking_lot::Mutex;

use crate::store::Extent;

/// Name of the file in the spill folder, which exists only for a moment: see [`create_segments`].
pub(crate) const SEGMENTS: &str = "segments";

/// The location of a chunk.
#[derive(Debug)]
pub(crate) enum Chunk {
    /// In memory.
    Memory(Box<[u8]>),
    /// In the file.
    File(Extent),
}

impl Default for Chunk {
    fn default() -> Self {
        Self::Memory(Box::default())
    }
}

/// A store of chunks, which any thread may append, read back and free.
#[derive(Debug)]
pub(crate) struct ChunkStore {
    folder: PathBuf,
    /// Created with the first chunk that does not stay in memory.
    file: OnceLock<File>,
    room: Mutex<Room>,
}

/// The room for chunks.
#[derive(Debug, Default)]
struct Room {
    /// The length of the file in bytes.
    length: u64,
    /// Ranges of the file whose chunks were freed. Writing there uses pages that are already in the
    /// system's memory, which halves the work.
    free: Vec<Range<u64>>,
    /// Bytes of chunks in memory, and the limit of these bytes.
    held: u64,
    limit: u64,
}

impl Room {
    /// Finds room in the file, and returns its offset. Gives up for good free ranges that are too
    /// small.
    fn take(&mut self, length: u64) -> u64 {
        while let Some(free) = self.free.last_mut() {
            if free.end - free.start >= length {
                free.start += length;
                return free.start - length;
            }
            self.free.pop();
        }
        self.length += length;
        self.length - length
    }
}

impl ChunkStore {
    /// Makes a store with a file in `folder`, which it creates once `limit` bytes are in memory.
    pub(crate) fn new(folder: &Path, limit: u64) -> Self {
        Self {
            folder: folder.to_owned(),
            file: OnceLock::new(),
            room: Mutex::new(Room {
                limit,
                ..Room::default()
            }),
        }
    }

    /// Returns the folder that it spills to.
    pub(crate) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Returns the bytes of chunks in memory.
    pub(crate) fn byte_size(&self) -> u64 {
        self.room.lock().held
    }

    /// Returns the limit of bytes of chunks in memory.
    pub(crate) fn limit(&self) -> u64 {
        self.room.lock().limit
    }

    /// Returns the length of the file in bytes.
    pub(crate) fn file_bytes(&self) -> u64 {
        self.room.lock().length
    }

    /// Appends a chunk of less than 4 GiB. Once one chunk went to the file, all later ones do.
    pub(crate) fn append(&self, bytes: &[u8]) -> io::Result<Chunk> {
        let length = bytes.len() as u64;
        let mut room = self.room.lock();
        let file = match self.file.get() {
            None if room.held + length <= room.limit => {
                room.held += length;
                return Ok(Chunk::Memory(bytes.into()));
            }
            None => {
                let created = create_segments(&self.folder)?;
                self.file.get_or_init(|| created)
            }
            Some(file) => file,
        };
        let offset = room.take(length);
        drop(room);
        file.write_all_at(bytes, offset)?;
        let length = u32::try_from(length).map_err(io::Error::other)?;
        Ok(Chunk::File(Extent::raw(offset, length, crc32c::crc32c(bytes))))
    }

    /// Frees a chunk.
    pub(crate) fn free(&self, chunk: Chunk) {
        let mut room = self.room.lock();
        match chunk {
            Chunk::Memory(bytes) => room.held -= bytes.len() as u64,
            Chunk::File(extent) => {
                let range = extent.range();
                match room.free.last_mut() {
                    Some(last) if last.end == range.start => last.end = range.end,
                    _ => room.free.push(range),
                }
            }
        }
    }

    /// Makes all further chunks go to the file.
    pub(crate) fn fill_no_memory(&self) {
        self.room.lock().limit = 0;
    }

    /// Returns the bytes of a chunk, from memory or read into `buffer`.
    pub(crate) fn read<'a>(&self, chunk: &'a Chunk, buffer: &'a mut Vec<u8>) -> io::Result<&'a [u8]> {
        let extent = match chunk {
            Chunk::Memory(bytes) => return Ok(bytes),
            Chunk::File(extent) => extent,
        };
        let file = self.file.get().ok_or(io::ErrorKind::NotFound)?;
        buffer.resize(extent.length as usize, 0);
        file.read_exact_at(buffer, extent.offset)?;
        if crc32c::crc32c(buffer) != extent.crc {
            return Err(damaged(&format!(
                "the checksum of segments is wrong at {}",
                extent.offset
            )));
        }
        Ok(buffer)
    }

    /// Returns the file, if there is one.
    #[cfg(test)]
    pub(crate) fn file(&self) -> Option<&File> {
        self.file.get()
    }
}

/// Returns the error for data that differs from what was written.
pub(crate) fn damaged(problem: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, problem)
}

/// Creates a file for segments in the spill folder. It has no name, so the system removes it when
/// it is closed.
fn create_segments(spill: &Path) -> io::Result<File> {
    // A process that is killed in between leaves a file whose name is known to be ours.
    let name = spill.join(SEGMENTS);
    let file = File::options()
        .read(true)
        .write(true)
        .create(true)
        .truncate(true)
        .open(&name)?;
    fs::remove_file(&name)?;
    Ok(file)
}
