//! The traits of files that are read and written by position.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::sync::Arc;

use bytes::Bytes;
use futures::future::{BoxFuture, FutureExt, try_join_all};

/// The number of bytes at the start of a file that are read first, if it has so many. In a new tile
/// file, they contain the superblocks, the root of the directory, short lists, and the lists of up
/// to a thousand pages.
pub(crate) const FIRST_READ: u64 = 44 << 10;

/// A file that is read by byte range, from any thread.
pub trait ReadAt: Send + Sync {
    /// Returns the number of bytes in the file when it was opened.
    fn length(&self) -> u64;

    /// Returns the name of the backend.
    fn backend(&self) -> &'static str;

    /// Returns a note for the user about how this backend was chosen or works, if there is one.
    fn note(&self) -> Option<&str> {
        None
    }

    /// Reads exactly the bytes of `range`. Reading beyond the end fails with
    /// [`io::ErrorKind::UnexpectedEof`].
    fn read_at(&self, range: Range<u64>) -> BoxFuture<'static, io::Result<Bytes>>;

    /// Reads several ranges at once. The answers are in the order of the ranges.
    fn read_many(&self, ranges: &[Range<u64>]) -> BoxFuture<'static, io::Result<Vec<Bytes>>> {
        try_join_all(ranges.iter().map(|range| self.read_at(range.clone()))).boxed()
    }

    /// Locks a number, as others may at the same time, until this file and its clones are dropped and
    /// nobody awaits a read. Tile files lock the generation that they read. By default, and where the system has no locks of byte ranges that
    /// belong to an open file, it fails with [`io::ErrorKind::Unsupported`].
    fn lock_shared(&self, number: u64) -> io::Result<()> {
        let _ = number;
        Err(io::ErrorKind::Unsupported.into())
    }

    /// Ends a series of reads: memory that is kept for reading may be released.
    fn rest(&self) {}
}

/// A file that is written by byte range, from any thread.
pub trait WriteAt: Send + Sync {
    /// Writes all of `data` at `offset`, which may be beyond the end.
    fn write_at(&self, offset: u64, data: Bytes) -> BoxFuture<'static, io::Result<()>>;

    /// Brings everything written before onto the medium, including the file's length.
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

    fn lock_shared(&self, number: u64) -> io::Result<()> {
        (**self).lock_shared(number)
    }

    fn rest(&self) {
        (**self).rest();
    }
}

/// The limit on the buffers kept for a file of tiles: the number that a scan may return before it
/// takes another one.
pub(crate) const KEPT_OF_TILES: usize = 16;

/// The size in bytes of a huge page on most processors.
pub(crate) const HUGE_PAGE: usize = 2 << 20;

/// Returns how many bytes of memory for `length` bytes should be in huge pages: all whole huge
/// pages, and the last one too if it exceeds the bytes by at most a third.
///
/// Tiles of the default size take four fifths of a huge page.
pub(crate) const fn in_huge_pages(length: usize) -> usize {
    let up = length.next_multiple_of(HUGE_PAGE);
    if up - length <= length / 3 {
        up
    } else {
        length / HUGE_PAGE * HUGE_PAGE
    }
}

/// Returns an upper bound on the memory in bytes that `length` bytes of a file take once they are
/// read.
pub(crate) const fn memory_of(length: usize) -> usize {
    let huge = in_huge_pages(length);
    if huge > length { huge } else { length }
}

/// Returns the length of a range in bytes.
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

/// Returns the end of `length` bytes that are written at `offset`.
pub(crate) fn end_of(offset: u64, length: usize) -> io::Result<u64> {
    let end = offset
        .checked_add(length as u64)
        .filter(|&end| i64::try_from(end).is_ok());
    end.ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, format!("{length} bytes at byte {offset}")))
}

/// Fails if `range` ends beyond the end of the file, whose earlier length is `length`.
pub(crate) fn check_within(range: &Range<u64>, length: u64, file: &File) -> io::Result<()> {
    if range.end <= length || range.end <= file.metadata()?.len() {
        Ok(())
    } else {
        Err(io::ErrorKind::UnexpectedEof.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn huge_pages_take_at_most_a_third_more_than_the_bytes() {
        for length in (0..5 * HUGE_PAGE).step_by(4096) {
            let huge = in_huge_pages(length);
            assert!(
                huge.is_multiple_of(HUGE_PAGE) && huge <= length + length / 3,
                "{length}"
            );
            assert!(memory_of(length) >= length && huge + HUGE_PAGE > length, "{length}");
        }
        // The core of a tile of 32,768 vertices, in one huge page.
        assert_eq!(in_huge_pages(1_700_000), HUGE_PAGE);
        assert_eq!(in_huge_pages(1_500_000), 0);
    }
}
