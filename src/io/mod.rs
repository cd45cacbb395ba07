//! Positional reads and writes: the traits, and their backends. Knows bytes, not tiles.
//!
//! The contract of both traits: offsets are 64 bits wide; a read gives all the bytes it was asked for or an error, never
//! fewer; a write that succeeded is seen by every later read of the same process, and is on the medium once
//! [`WriteAt::sync`] succeeded. Dropping a future gives up on the answer, not on the operation.

mod buffers;
mod memory;
mod pool;
mod threads;

use std::io;
use std::ops::Range;
use std::sync::Arc;

use bytes::Bytes;
use futures::future::{BoxFuture, FutureExt, try_join_all};

pub(crate) use buffers::Buffers;
pub use memory::MemoryFile;
pub use threads::ThreadsFile;

/// A file that is read by byte range, from any thread.
pub trait ReadAt: Send + Sync {
    /// Bytes in the file, when it was opened.
    fn length(&self) -> u64;

    /// The name of the backend.
    fn backend(&self) -> &'static str;

    /// Reads exactly the bytes of `range`. Beyond the end it is [`io::ErrorKind::UnexpectedEof`].
    fn read_at(&self, range: Range<u64>) -> BoxFuture<'static, io::Result<Bytes>>;

    /// Reads several ranges at once; the answers are in the order of the ranges.
    fn read_many(&self, ranges: &[Range<u64>]) -> BoxFuture<'static, io::Result<Vec<Bytes>>> {
        try_join_all(ranges.iter().map(|range| self.read_at(range.clone()))).boxed()
    }

    /// Says that a series of reads is over: memory that is kept to read into can be given back.
    fn rest(&self) {}
}

/// A file that is written by byte range, from any thread.
pub trait WriteAt: Send + Sync {
    /// Writes all of `data` at `offset`, which may lie beyond the end.
    fn write_at(&self, offset: u64, data: Bytes) -> BoxFuture<'static, io::Result<()>>;

    /// Brings everything written before onto the medium, the file's length included.
    fn sync(&self) -> BoxFuture<'static, io::Result<()>>;
}

impl<T: ReadAt + ?Sized> ReadAt for Arc<T> {
    fn length(&self) -> u64 {
        (**self).length()
    }

    fn backend(&self) -> &'static str {
        (**self).backend()
    }

    fn read_at(&self, range: Range<u64>) -> BoxFuture<'static, io::Result<Bytes>> {
        (**self).read_at(range)
    }

    fn read_many(&self, ranges: &[Range<u64>]) -> BoxFuture<'static, io::Result<Vec<Bytes>>> {
        (**self).read_many(ranges)
    }

    fn rest(&self) {
        (**self).rest();
    }
}
