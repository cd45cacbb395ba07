//! A file mapped into memory, for comparison.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::path::Path;

use bytes::Bytes;
use delaunay_tiles::io::{ReadAt, open_regular};
use futures::future::{BoxFuture, FutureExt, ready};
use memmap2::{Advice, Mmap};

/// A file that is read from a memory map.
pub struct MappedFile(Bytes);

impl MappedFile {
    /// Maps a file that must not change in the meantime. If `is_scan`, the file is read
    /// sequentially and the system may read ahead.
    pub fn open(path: &Path, is_scan: bool) -> io::Result<Self> {
        let (file, _) = open_regular(path, File::options().read(true))?;
        // SAFETY: tile files are never changed in place where a reader may look, and the user
        // leaves a measured file unchanged. If the file were truncated, the process would end by a
        // signal instead of reading wrong bytes.
        #[allow(unsafe_code, reason = "a memory map is unsafe to create")]
        let map = unsafe { Mmap::map(&file)? };
        map.advise(if is_scan { Advice::Sequential } else { Advice::Random })?;
        Ok(Self(Bytes::from_owner(map)))
    }
}

impl ReadAt for MappedFile {
    fn length(&self) -> u64 {
        self.0.len() as u64
    }

    fn backend(&self) -> &'static str {
        "mmap"
    }

    fn read_at(&self, range: Range<u64>) -> BoxFuture<'static, io::Result<Bytes>> {
        let inside = range.start <= range.end && range.end <= self.length();
        let part = inside.then(|| self.0.slice(range.start as usize..range.end as usize));
        ready(part.ok_or_else(|| io::ErrorKind::UnexpectedEof.into())).boxed()
    }
}
