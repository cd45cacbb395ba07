//! Writes a tile file from front to back.

use std::io;

use bytes::{Bytes, BytesMut};

use crate::io::WriteAt;
use crate::store::format::directory::Directory;
use crate::store::format::entry::Extent;
use crate::store::format::superblock::{
    BLOCK, FIRST_EXTENT, FileId, InForce, MAX_DIRECTORY, MAX_FLATBUFFER, Superblock,
};

/// The number of bytes to buffer before a write.
const CHUNK: usize = 4 << 20;

/// Writes extents and then the directory. The superblocks are written last, so an unfinished file
/// is no valid file.
pub(crate) struct TileWriter<W> {
    file: W,
    /// Bytes that are not written yet, and the offset at which they will be.
    pending: BytesMut,
    written: u64,
    is_draft: bool,
}

impl<W: WriteAt> TileWriter<W> {
    /// Creates a writer for a new file.
    pub(crate) fn new(file: W) -> Self {
        Self::behind(file, FIRST_EXTENT)
    }

    /// Creates a writer that continues a file after the cores that end at `length`.
    pub(crate) fn behind(file: W, length: u64) -> Self {
        Self {
            file,
            pending: BytesMut::new(),
            written: length,
            is_draft: false,
        }
    }

    /// Sets whether the file is a draft that nobody relies on. A draft is not synchronised to the
    /// medium.
    #[must_use]
    pub(crate) fn draft(mut self, is_draft: bool) -> Self {
        self.is_draft = is_draft;
        self
    }

    async fn sync(&self) -> io::Result<()> {
        match self.is_draft {
            true => Ok(()),
            false => self.file.sync().await,
        }
    }

    /// Returns the length of the file so far, in bytes.
    pub(crate) fn length(&self) -> u64 {
        self.written + self.pending.len() as u64
    }

    /// Appends a core, aligned so that it can be read with direct I/O.
    pub(crate) async fn append_core(&mut self, core: &Bytes) -> io::Result<Extent> {
        self.append(core, BLOCK).await
    }

    /// Appends a border. Borders are short and are read together with their neighbours, so they are
    /// stored close together.
    pub(crate) async fn append_border(&mut self, border: &Bytes) -> io::Result<Extent> {
        self.append(border, 8).await
    }

    async fn append(&mut self, bytes: &Bytes, alignment: u64) -> io::Result<Extent> {
        if bytes.len() as u64 > MAX_FLATBUFFER {
            let message = format!(
                "a tile takes {} bytes, more than the format allows; use smaller tiles",
                bytes.len()
            );
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, message));
        }
        let offset = self.length().next_multiple_of(alignment);
        let padding = (offset - self.length()) as usize;
        self.pending.resize(self.pending.len() + padding, 0);
        if bytes.len() >= CHUNK / 4 {
            // Long enough to be written directly, without a copy.
            self.flush().await?;
            self.file.write_at(offset, bytes.clone()).await?;
            self.written += bytes.len() as u64;
        } else {
            self.pending.extend_from_slice(bytes);
        }
        if self.pending.len() >= CHUNK {
            self.flush().await?;
        }
        Ok(Extent {
            offset,
            length: bytes.len() as u32,
            crc: crc32c::crc32c(bytes),
        })
    }

    /// Overwrites the bytes at an offset, which must not be in use any more.
    pub(crate) async fn put_at(&mut self, offset: u64, bytes: &Bytes) -> io::Result<Extent> {
        // The pending bytes must not overwrite these later.
        self.flush().await?;
        self.file.write_at(offset, bytes.clone()).await?;
        Ok(Extent {
            offset,
            length: bytes.len() as u32,
            crc: crc32c::crc32c(bytes),
        })
    }

    /// Writes the pending bytes.
    pub(crate) async fn flush(&mut self) -> io::Result<()> {
        if self.pending.is_empty() {
            return Ok(());
        }
        let chunk = self.pending.split().freeze();
        let length = chunk.len() as u64;
        self.file.write_at(self.written, chunk).await?;
        self.written += length;
        Ok(())
    }

    /// Writes the directory, synchronises everything to the medium, and then writes the
    /// superblocks.
    ///
    /// Returns the length of the file in bytes.
    pub(crate) async fn finish(self, directory: &Directory) -> io::Result<u64> {
        self.finish_as(directory, 1).await
    }

    /// Finishes a file like [`finish`](Self::finish), with a given generation, for a file that was
    /// changed before.
    pub(crate) async fn finish_as(mut self, directory: &Directory, generation: u64) -> io::Result<u64> {
        let superblock = self.write_directory(directory, generation).await?;
        let block = superblock.encode();
        self.file.write_at(0, [&block[..], &block[..]].concat().into()).await?;
        self.sync().await?;
        Ok(superblock.file_length)
    }

    /// Replaces the directory of an existing file, whose superblock in force is `before`. Readers
    /// see either the old or the new directory.
    ///
    /// Returns the length of the file in bytes.
    pub(crate) async fn replace(mut self, directory: &Directory, before: &InForce) -> io::Result<u64> {
        let superblock = self
            .write_directory(directory, before.superblock.generation + 1)
            .await?;
        self.file
            .write_at(before.other_offset(), superblock.encode().into())
            .await?;
        self.sync().await?;
        Ok(superblock.file_length)
    }

    /// Writes the directory and waits until everything is on the medium. Returns the superblock
    /// that refers to it.
    async fn write_directory(&mut self, directory: &Directory, generation: u64) -> io::Result<Superblock> {
        let (bytes, root_length, root_crc) = directory.encode();
        if u64::from(root_length) > MAX_FLATBUFFER || bytes.len() as u64 > MAX_DIRECTORY {
            let message = "the directory is larger than the format allows; use larger tiles";
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, message));
        }
        let directory_offset = self.length().next_multiple_of(BLOCK);
        let padding = (directory_offset - self.length()) as usize;
        self.pending.resize(self.pending.len() + padding, 0);
        self.pending.extend_from_slice(&bytes);
        self.flush().await?;
        self.sync().await?;
        Ok(Superblock {
            file_id: FileId::of(&bytes),
            generation,
            file_length: self.written,
            directory_offset,
            directory_length: bytes.len() as u64,
            root_length,
            root_crc,
        })
    }
}
