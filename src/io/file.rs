//! Files that are read and written by position.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::sync::Arc;

use bytes::Bytes;
use futures::future::{BoxFuture, FutureExt, try_join_all};

/// A file that is read by byte range, from any thread.
pub trait ReadAt: Send + Sync {
    /// Bytes in the file, when it was opened.
    fn length(&self) -> u64;

    /// The name of the backend.
    fn backend(&self) -> &'static str;

    /// What a person should know of how this backend was chosen or works, if anything.
    fn note(&self) -> Option<&str> {
        None
    }

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

    fn note(&self) -> Option<&str> {
        (**self).note()
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

/// The most buffers that are kept of a file of tiles: as many as a scan may give back before it takes another.
pub(crate) const KEPT_OF_TILES: usize = 16;

/// Bytes of a huge page, on most processors.
pub(crate) const HUGE_PAGE: usize = 2 << 20;

/// Of memory for so many bytes, those that are to lie in huge pages: all whole ones, and the last one too if it is no more than a quarter
/// of the bytes too long.
pub(crate) const fn in_huge_pages(length: usize) -> usize {
    let up = length.next_multiple_of(HUGE_PAGE);
    if up - length <= length / 4 {
        up
    } else {
        length / HUGE_PAGE * HUGE_PAGE
    }
}

/// Bytes of memory that so many bytes of a file take at most, once they are read.
pub(crate) const fn memory_of(length: usize) -> usize {
    let huge = in_huge_pages(length);
    if huge > length { huge } else { length }
}

/// How many bytes a range is.
pub(crate) fn length_of(range: &Range<u64>) -> io::Result<usize> {
    let length = range.end.checked_sub(range.start).map(usize::try_from);
    match length {
        Some(Ok(length)) => Ok(length),
        _ => Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            format!("a range of bytes {range:?}"),
        )),
    }
}

/// Where so many bytes end that are written at `offset`.
pub(crate) fn end_of(offset: u64, length: usize) -> io::Result<u64> {
    let end = offset
        .checked_add(length as u64)
        .filter(|&end| i64::try_from(end).is_ok());
    end.ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, format!("{length} bytes at byte {offset}")))
}

/// Fails if a file that had so many bytes once ends before the range does.
pub(crate) fn check_within(range: &Range<u64>, length: u64, file: &File) -> io::Result<()> {
    if range.end <= length || range.end <= file.metadata()?.len() {
        Ok(())
    } else {
        Err(io::ErrorKind::UnexpectedEof.into())
    }
}
