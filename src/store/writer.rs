//! Writes the extents of a tile file from front to back.

use std::io;

use bytes::{Bytes, BytesMut};

use crate::io::WriteAt;
use crate::store::format::codec::StoredPart;
use crate::store::format::extent::Extent;
use crate::store::format::limits::{BLOCK, FIRST_EXTENT, MAX_FLATBUFFER};
use crate::store::format::table_place::{ShortTable, TablePlace};
use crate::store::free_space::FreeSpace;

/// The number of bytes to buffer before a write.
const CHUNK: usize = 4 << 20;

impl StoredPart {
    /// Returns the extent of the part at an offset. Its lengths were compared with the limit.
    fn at(&self, offset: u64) -> Extent {
        Extent {
            offset,
            length: self.bytes.len() as u32,
            crc: self.crc,
            codec: self.codec,
            decoded: self.decoded as u32,
        }
    }
}

/// Writes extents, and then the [directory](crate::store::directory_writer). The superblocks are
/// written last, so an unfinished file is no valid file.
///
/// An extent goes to free bytes where it fits, and otherwise behind the end.
pub(crate) struct TileWriter<W> {
    pub(super) file: W,
    /// Bytes that are not written yet, and the offset at which they will be.
    pending: BytesMut,
    written: u64,
    /// Where the room for the root of the directory, behind the superblocks, ends.
    pub(super) front_end: u64,
    is_draft: bool,
    /// The bytes before the end that may be overwritten.
    free: FreeSpace,
}

impl<W: WriteAt> TileWriter<W> {
    /// Creates a writer for a new file. Its extents start at `front_end`, so that the root of the
    /// directory may come before them; see
    /// [`front_end_for`](crate::store::directory_writer::front_end_for).
    pub(crate) fn new(file: W, front_end: u64) -> Self {
        Self {
            front_end,
            ..Self::behind(file, front_end)
        }
    }

    /// Creates a writer that continues a file after the extents that end at `length`.
    pub(crate) fn behind(file: W, length: u64) -> Self {
        Self {
            file,
            pending: BytesMut::new(),
            written: length,
            front_end: FIRST_EXTENT,
            is_draft: false,
            free: FreeSpace::default(),
        }
    }

    /// Sets which bytes before the end may be overwritten.
    #[must_use]
    pub(crate) fn reusing(self, free: FreeSpace) -> Self {
        Self { free, ..self }
    }

    /// Sets where the room for the root of the directory ends, in a new file that is continued.
    #[must_use]
    pub(crate) fn front_end(self, front_end: u64) -> Self {
        Self { front_end, ..self }
    }

    /// Sets whether the file is a draft that nobody relies on. A draft is not synchronised to the
    /// medium.
    #[must_use]
    pub(crate) fn draft(mut self, is_draft: bool) -> Self {
        self.is_draft = is_draft;
        self
    }

    pub(super) async fn sync(&self) -> io::Result<()> {
        match self.is_draft {
            true => Ok(()),
            false => self.file.sync().await,
        }
    }

    /// Returns the length of the file so far, in bytes.
    pub(crate) fn length(&self) -> u64 {
        self.written + self.pending.len() as u64
    }

    /// Passes over bytes that others write, up to `length`, after it has written what is pending.
    pub(crate) async fn pass_over(&mut self, length: u64) -> io::Result<()> {
        self.flush().await?;
        self.written = self.written.max(length);
        Ok(())
    }

    /// Appends a core, aligned so that it can be read with direct I/O.
    pub(crate) async fn append_core(&mut self, core: impl Into<StoredPart>) -> io::Result<Extent> {
        self.append(core.into(), BLOCK).await
    }

    /// Appends a border. Borders are short and are read together with their neighbours, so they are
    /// stored close together.
    pub(crate) async fn append_border(&mut self, border: impl Into<StoredPart>) -> io::Result<Extent> {
        self.append(border.into(), 8).await
    }

    /// Stores the component table of a tile: in its page if it is short, else appended.
    pub(crate) async fn place_table(&mut self, table: Vec<u8>) -> io::Result<TablePlace> {
        if table.is_empty() {
            return Ok(TablePlace::Nowhere);
        }
        if let Some(short) = ShortTable::new(&table) {
            return Ok(TablePlace::InPage(short));
        }
        let table = Bytes::from(table);
        Ok(TablePlace::Apart(self.append((&table).into(), 8).await?))
    }

    pub(super) async fn append(&mut self, part: StoredPart, alignment: u64) -> io::Result<Extent> {
        let bytes = &part.bytes;
        let longest = bytes.len().max(part.decoded);
        if longest as u64 > MAX_FLATBUFFER {
            let message = format!("a tile takes {longest} bytes, more than the format allows; use smaller tiles");
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, message));
        }
        if let Some(offset) = self.free.take(bytes.len() as u64, alignment) {
            self.put(offset, bytes.clone()).await?;
            return Ok(part.at(offset));
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
        Ok(part.at(offset))
    }

    /// Allows bytes to be overwritten that this writer has written and nothing refers to any more.
    pub(crate) fn release(&mut self, extent: Extent) {
        self.free.give(extent.range());
    }

    /// Takes bytes before the end that may be overwritten, at a multiple of the size of a block.
    pub(super) fn take_blocks(&mut self, length: u64) -> Option<u64> {
        self.free.take(length, BLOCK)
    }

    /// Overwrites bytes before the end.
    pub(super) async fn put(&mut self, offset: u64, bytes: Bytes) -> io::Result<()> {
        if offset + bytes.len() as u64 > self.written {
            // The pending bytes must not overwrite these later.
            self.flush().await?;
        }
        self.file.write_at(offset, bytes).await
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
}
