//! A part of a file, read and written as if it were a file of its own.

use std::io;
use std::ops::Range;

use bytes::Bytes;
use futures::future::{BoxFuture, FutureExt, ready};

use crate::io::file::{ReadAt, WriteAt, end_of};

/// A part of a file. Its offsets count from its start.
#[derive(Clone, Debug)]
pub(crate) struct Section<F> {
    file: F,
    offset: u64,
    length: u64,
}

impl<F> Section<F> {
    /// Creates the part of `length` bytes from `offset` on. If these are multiples of the block of
    /// the medium, aligned reads of it are aligned reads of the file.
    pub(crate) fn new(file: F, offset: u64, length: u64) -> Self {
        Self { file, offset, length }
    }

    /// Creates the part from `offset` on, however long it becomes.
    pub(crate) fn from(file: F, offset: u64) -> Self {
        Self::new(file, offset, u64::MAX - offset)
    }

    fn within(&self, range: &Range<u64>) -> io::Result<Range<u64>> {
        if range.end > self.length && range.start < range.end {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let at = |offset: u64| offset.checked_add(self.offset);
        match (at(range.start), at(range.end)) {
            (Some(start), Some(end)) => Ok(start..end),
            // An empty range at any offset is nothing.
            _ if range.is_empty() => Ok(0..0),
            _ => Err(io::ErrorKind::UnexpectedEof.into()),
        }
    }
}

impl<F: ReadAt> ReadAt for Section<F> {
    fn length(&self) -> u64 {
        self.length
    }

    fn backend(&self) -> &'static str {
        self.file.backend()
    }

    fn note(&self) -> Option<&str> {
        self.file.note()
    }

    fn read_at(&self, range: Range<u64>) -> BoxFuture<'static, io::Result<Bytes>> {
        match self.within(&range) {
            Ok(range) => self.file.read_at(range),
            Err(error) => ready(Err(error)).boxed(),
        }
    }

    fn read_many(&self, ranges: &[Range<u64>]) -> BoxFuture<'static, io::Result<Vec<Bytes>>> {
        let ranges: io::Result<Vec<_>> = ranges.iter().map(|range| self.within(range)).collect();
        match ranges {
            Ok(ranges) => self.file.read_many(&ranges),
            Err(error) => ready(Err(error)).boxed(),
        }
    }

    fn rest(&self) {
        self.file.rest();
    }
}

impl<F: WriteAt> WriteAt for Section<F> {
    fn write_at(&self, offset: u64, data: Bytes) -> BoxFuture<'static, io::Result<()>> {
        let end = end_of(offset, data.len()).map(|end| end <= self.length);
        match (end, self.offset.checked_add(offset)) {
            (Ok(true), Some(offset)) => self.file.write_at(offset, data),
            (Err(error), _) => ready(Err(error)).boxed(),
            _ => ready(Err(io::ErrorKind::InvalidInput.into())).boxed(),
        }
    }

    fn sync(&self) -> BoxFuture<'static, io::Result<()>> {
        self.file.sync()
    }
}
