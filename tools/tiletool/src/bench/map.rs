//! A file mapped into memory, to compare with.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::path::Path;

use bytes::Bytes;
use delaunay_tiles::io::{ReadAt, open_regular};
use futures::future::{BoxFuture, FutureExt, ready};
use memmap2::{Advice, Mmap};

/// A file whose bytes are read where the system has mapped them.
pub struct MappedFile(Bytes);

impl MappedFile {
    /// Maps a file that nobody changes in the meantime. If it is read from front to back, the system may read ahead.
    pub fn open(path: &Path, is_scan: bool) -> io::Result<Self> {
        let (file, _) = open_regular(path, File::options().read(true))?;
        // SAFETY: tile files are never changed in place where a reader may look, and whoever measures one leaves it alone;
        // were it cut off, the process would end by a signal, not go wrong unnoticed.
        #[allow(unsafe_code)]
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
