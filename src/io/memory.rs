//! Files in memory: bytes that do not change, and a file for tests that is written too.

use std::io;
use std::ops::Range;
use std::sync::Arc;

use bytes::Bytes;
use futures::future::{BoxFuture, FutureExt, ready};
use parking_lot::RwLock;

use crate::io::file::{ReadAt, WriteAt, end_of, length_of};

/// A file in memory that does not change. What is read shares the memory of the file: opened tiles
/// are not copies, unless they are stored compressed.
///
/// ```no_run
/// use bytes::Bytes;
/// use delaunay_tiles::store::{OpenOptions, TileReader};
///
/// # async fn read() -> Result<(), Box<dyn std::error::Error>> {
/// let file = Bytes::from(std::fs::read("town.tiles")?);
/// let reader = TileReader::open_source(file, "town.tiles", OpenOptions::default()).await?;
/// # Ok(())
/// # }
/// ```
impl ReadAt for Bytes {
    fn length(&self) -> u64 {
        self.len() as u64
    }

    fn backend(&self) -> &'static str {
        "memory"
    }

    fn read_at(&self, range: Range<u64>) -> BoxFuture<'static, io::Result<Bytes>> {
        ready(part_of(self, &range).map(|part| self.slice(part))).boxed()
    }
}

/// Returns the range as positions in `bytes`.
fn part_of(bytes: &[u8], range: &Range<u64>) -> io::Result<Range<usize>> {
    // What is empty may be anywhere.
    if length_of(range)? == 0 {
        return Ok(0..0);
    }
    let ends = [range.start, range.end].map(usize::try_from);
    match ends {
        [Ok(start), Ok(end)] if end <= bytes.len() => Ok(start..end),
        _ => Err(io::ErrorKind::UnexpectedEof.into()),
    }
}

/// A file whose bytes are in memory. Clones share them. Reads copy, since the bytes may change; for
/// a file that does not change, take [`Bytes`].
#[derive(Clone, Debug, Default)]
pub struct MemoryFile {
    bytes: Arc<RwLock<Vec<u8>>>,
}

impl MemoryFile {
    /// Creates a file with these bytes.
    #[must_use]
    pub fn new(bytes: Vec<u8>) -> Self {
        Self {
            bytes: Arc::new(RwLock::new(bytes)),
        }
    }

    /// Returns a copy of the bytes.
    #[must_use]
    pub fn to_vec(&self) -> Vec<u8> {
        self.bytes.read().clone()
    }

    fn write(&self, offset: u64, data: &[u8]) -> io::Result<()> {
        let end = usize::try_from(end_of(offset, data.len())?).map_err(|_| io::ErrorKind::OutOfMemory)?;
        let mut bytes = self.bytes.write();
        if data.is_empty() {
            return Ok(());
        }
        if let Some(more) = end.checked_sub(bytes.len()) {
            bytes.try_reserve(more).map_err(|_| io::ErrorKind::OutOfMemory)?;
            bytes.resize(end, 0);
        }
        bytes[end - data.len()..end].copy_from_slice(data);
        Ok(())
    }
}

impl ReadAt for MemoryFile {
    fn length(&self) -> u64 {
        self.bytes.read().len() as u64
    }

    fn backend(&self) -> &'static str {
        "memory"
    }

    fn read_at(&self, range: Range<u64>) -> BoxFuture<'static, io::Result<Bytes>> {
        let bytes = self.bytes.read();
        let read = part_of(&bytes, &range).map(|part| Bytes::copy_from_slice(&bytes[part]));
        ready(read).boxed()
    }
}

impl WriteAt for MemoryFile {
    fn write_at(&self, offset: u64, data: Bytes) -> BoxFuture<'static, io::Result<()>> {
        ready(self.write(offset, &data)).boxed()
    }

    fn sync(&self) -> BoxFuture<'static, io::Result<()>> {
        ready(Ok(())).boxed()
    }
}
