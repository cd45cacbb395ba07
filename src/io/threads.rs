//! A file on disk, read and written at positions by a pool of threads.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::sync::Arc;

use bytes::Bytes;
use futures::future::BoxFuture;

use crate::io::buffers::Buffers;
use crate::io::file::{KEPT_OF_TILES, ReadAt, WriteAt, check_within, end_of, length_of};
use crate::io::pool;
use crate::io::regular::open_regular;

/// A file on disk. Clones share it.
#[derive(Clone, Debug)]
pub struct ThreadsFile {
    file: Arc<File>,
    length: u64,
    buffers: Buffers,
}

impl ThreadsFile {
    /// Opens a file to read it.
    ///
    /// # Errors
    /// What the system says, and [`io::ErrorKind::IsADirectory`].
    pub fn open(path: &Path) -> io::Result<Self> {
        let (file, metadata) = open_regular(path, File::options().read(true))?;
        Ok(Self {
            file: Arc::new(file),
            length: metadata.len(),
            buffers: Buffers::default(),
        })
    }

    /// Makes a new, empty file to write and read.
    ///
    /// # Errors
    /// What the system says.
    pub fn create(path: &Path) -> io::Result<Self> {
        let file = File::options()
            .read(true)
            .write(true)
            .create(true)
            .truncate(true)
            .open(path)?;
        Ok(Self {
            file: Arc::new(file),
            length: 0,
            buffers: Buffers::default(),
        })
    }
}

impl ThreadsFile {
    /// Keeps as many buffers as a scan of tiles uses over and over.
    pub(super) fn for_tiles(mut self) -> Self {
        self.buffers = Buffers::keeping(KEPT_OF_TILES);
        self
    }

    /// Waits until all that was written is on the medium, and lets the system take back the memory that it keeps it in.
    ///
    /// For files that nobody reads soon. What others read stays in memory, and what is written next takes pages that were in
    /// use just now rather than such as must be found first, which takes a third off the system's time on virtual machines
    /// whose host takes back what is free.
    pub(crate) fn sync_and_release(&self) -> BoxFuture<'static, io::Result<()>> {
        let file = Arc::clone(&self.file);
        pool::run(move || {
            file.sync_all()?;
            // Advice: if it is not taken, nothing is lost.
            let _ = rustix::fs::fadvise(&*file, 0, None, rustix::fs::Advice::DontNeed);
            Ok(())
        })
    }
}

impl From<Arc<File>> for ThreadsFile {
    /// A file that was opened elsewhere; what is read from it is at most what was in it then.
    fn from(file: Arc<File>) -> Self {
        let length = file.metadata().map_or(0, |metadata| metadata.len());
        Self {
            file,
            length,
            buffers: Buffers::default(),
        }
    }
}

impl ReadAt for ThreadsFile {
    fn length(&self) -> u64 {
        self.length
    }

    fn backend(&self) -> &'static str {
        "threads"
    }

    fn read_at(&self, range: Range<u64>) -> BoxFuture<'static, io::Result<Bytes>> {
        let (file, buffers, known) = (Arc::clone(&self.file), self.buffers.clone(), self.length);
        pool::run(move || {
            let length = length_of(&range)?;
            if length > 0 {
                check_within(&range, known, &file)?;
            }
            let mut buffer = buffers.take(length);
            file.read_exact_at(buffer.as_mut(), range.start)?;
            Ok(buffer.freeze())
        })
    }

    fn rest(&self) {
        self.buffers.clear();
    }
}

impl WriteAt for ThreadsFile {
    fn write_at(&self, offset: u64, data: Bytes) -> BoxFuture<'static, io::Result<()>> {
        let file = Arc::clone(&self.file);
        pool::run(move || {
            end_of(offset, data.len())?;
            file.write_all_at(&data, offset)
        })
    }

    fn sync(&self) -> BoxFuture<'static, io::Result<()>> {
        let file = Arc::clone(&self.file);
        pool::run(move || file.sync_all())
    }
}
