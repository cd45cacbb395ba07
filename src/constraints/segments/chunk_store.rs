//! Chunks of bytes: in memory up to a limit, then in a file.

use std::fs::File;
use std::ops::Range;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::{fs, io};

use crate::store::Extent;

/// In the folder to spill to, for a moment: see [`create_segments`].
pub(crate) const SEGMENTS: &str = "segments";

/// Where a chunk is.
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

/// Takes chunks, and reads them back. Reading is for any thread.
#[derive(Debug)]
pub(crate) struct ChunkStore {
    folder: PathBuf,
    /// Made with the first chunk that does not stay in memory.
    file: Option<File>,
    length: u64,
    /// Parts of the file whose chunks were given up. What is written there takes pages that are in the system's memory
    /// already, which is half the work.
    free: Vec<Range<u64>>,
    /// Bytes of chunks in memory, and how many there may be.
    held: u64,
    limit: u64,
}

impl ChunkStore {
    /// A store with a file in this folder, once `limit` bytes are in memory.
    pub(crate) fn new(folder: &Path, limit: u64) -> Self {
        Self {
            folder: folder.to_owned(),
            file: None,
            length: 0,
            free: Vec::new(),
            held: 0,
            limit,
        }
    }

    /// The folder that it spills to.
    pub(crate) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Bytes of chunks in memory.
    pub(crate) fn byte_size(&self) -> u64 {
        self.held
    }

    /// Bytes of chunks that stay in memory.
    pub(crate) fn limit(&self) -> u64 {
        self.limit
    }

    /// Bytes of the file.
    pub(crate) fn file_bytes(&self) -> u64 {
        self.length
    }

    /// Keeps a chunk of less than 4 GiB. Once one went to the file, all do.
    pub(crate) fn append(&mut self, bytes: &[u8]) -> io::Result<Chunk> {
        let length = bytes.len() as u64;
        if self.file.is_none() && self.held + length <= self.limit {
            self.held += length;
            return Ok(Chunk::Memory(bytes.into()));
        }
        let offset = self.room(length);
        let file = match &mut self.file {
            Some(file) => file,
            none => none.insert(create_segments(&self.folder)?),
        };
        file.write_all_at(bytes, offset)?;
        let extent = Extent {
            offset,
            length: u32::try_from(length).map_err(io::Error::other)?,
            crc: crc32c::crc32c(bytes),
        };
        Ok(Chunk::File(extent))
    }

    /// Finds room in the file. Where there is too little of it, it is given up for good.
    fn room(&mut self, length: u64) -> u64 {
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

    /// Gives up a chunk.
    pub(crate) fn free(&mut self, chunk: Chunk) {
        match chunk {
            Chunk::Memory(bytes) => self.held -= bytes.len() as u64,
            Chunk::File(extent) => {
                let range = extent.range();
                match self.free.last_mut() {
                    Some(last) if last.end == range.start => last.end = range.end,
                    _ => self.free.push(range),
                }
            }
        }
    }

    /// From now on all chunks go to the file.
    pub(crate) fn fill_no_memory(&mut self) {
        self.limit = 0;
    }

    /// The bytes of a chunk: where they are, or read to the buffer.
    pub(crate) fn read<'a>(&self, chunk: &'a Chunk, buffer: &'a mut Vec<u8>) -> io::Result<&'a [u8]> {
        let extent = match chunk {
            Chunk::Memory(bytes) => return Ok(bytes),
            Chunk::File(extent) => extent,
        };
        let file = self.file.as_ref().ok_or(io::ErrorKind::NotFound)?;
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

    /// The file, if there is one.
    #[cfg(test)]
    pub(crate) fn file(&self) -> Option<&File> {
        self.file.as_ref()
    }
}

/// What was read is not what was written.
pub(crate) fn damaged(problem: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, problem)
}

/// Makes a file for segments in the folder to spill to. It has no name, so that it goes away with whoever has it open.
fn create_segments(spill: &Path) -> io::Result<File> {
    // Who is killed in between leaves a name that is known as ours.
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
