//! A file in memory, for tests and for services that keep a whole map in memory.

use std::io;
use std::ops::Range;
use std::sync::Arc;

use bytes::Bytes;
use futures::future::{BoxFuture, FutureExt, ready};
use parking_lot::RwLock;

use crate::io::file::{ReadAt, WriteAt, end_of, length_of};

/// A file whose bytes are in memory. Clones share them.
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
        match length_of(&range) {
            Ok(0) => return ready(Ok(Bytes::new())).boxed(),
            Ok(_) => (),
            Err(error) => return ready(Err(error)).boxed(),
        }
        let bytes = self.bytes.read();
        let part = usize::try_from(range.start)
            .ok()
            .zip(usize::try_from(range.end).ok())
            .and_then(|(start, end)| bytes.get(start..end));
        let read = part
            .map(Bytes::copy_from_slice)
            .ok_or_else(|| io::Error::from(io::ErrorKind::UnexpectedEof));
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
