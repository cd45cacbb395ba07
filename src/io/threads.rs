//! Files on disk, read and written at positions by a pool of threads.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::sync::Arc;

use bytes::Bytes;
use futures::future::{BoxFuture, FutureExt};

use crate::io::buffers::Buffers;
use crate::io::file::{KEPT_OF_TILES, ReadAt, WriteAt, check_within, end_of, length_of};
use crate::io::file_lock::FileLock;
use crate::io::pool;
use crate::io::range_lock::{RangeLocks, is_locked_below};
use crate::io::regular::open_regular;

/// A file on disk that a pool of threads reads and writes. Clones share it.
#[derive(Clone, Debug)]
pub struct ThreadsFile {
    file: Arc<File>,
    length: u64,
    buffers: Buffers,
    /// Held by reads until nobody awaits them.
    numbers: Arc<RangeLocks>,
    /// Held by writes until they are done, even if nobody awaits them. Reads do not hold it.
    lock: Option<Arc<FileLock>>,
}

impl ThreadsFile {
    /// Opens a file for reading.
    ///
    /// # Errors
    /// Fails with [`io::ErrorKind::IsADirectory`] for a folder, and with the errors of the
    /// operating system.
    pub fn open(path: &Path) -> io::Result<Self> {
        let (file, metadata) = open_regular(path, File::options().read(true))?;
        Ok(Self::new(Arc::new(file), metadata.len()))
    }

    /// Creates a new, empty file for writing and reading.
    ///
    /// # Errors
    /// Fails with the errors of the operating system.
    pub fn create(path: &Path) -> io::Result<Self> {
        let file = File::options()
            .read(true)
            .write(true)
            .create(true)
            .truncate(true)
            .open(path)?;
        Ok(Self::new(Arc::new(file), 0))
    }
}

impl ThreadsFile {
    fn new(file: Arc<File>, length: u64) -> Self {
        Self {
            numbers: Arc::new(RangeLocks::new(Arc::clone(&file))),
            file,
            length,
            buffers: Buffers::default(),
            lock: None,
        }
    }

    /// Keeps as many buffers as a scan of tiles uses repeatedly.
    pub(super) fn for_tiles(mut self) -> Self {
        self.buffers = Buffers::keeping(KEPT_OF_TILES);
        self
    }

    /// Returns whether others have [locked](ReadAt::lock_shared) a number below `end`. Fails if the
    /// file cannot be locked.
    pub(crate) fn is_locked_below(&self, end: u64) -> io::Result<bool> {
        is_locked_below(&self.file, end)
    }

    /// Wraps a file with an exclusive lock, which is released when the clones of this are dropped and
    /// their writes are done. Reads that nobody awaits do not delay it.
    pub(crate) fn locked(lock: FileLock) -> Self {
        let file = Self::from(Arc::clone(lock.file()));
        Self {
            lock: Some(Arc::new(lock)),
            ..file
        }
    }

    /// Returns the same open file, without its lock.
    pub(crate) fn without_lock(&self) -> Self {
        Self {
            lock: None,
            ..self.clone()
        }
    }

    /// Returns the same open file with the length that it has now.
    pub(crate) fn renewed(&self) -> Self {
        Self {
            lock: self.lock.clone(),
            ..Self::from(Arc::clone(&self.file))
        }
    }

    /// Cuts the file off at a length.
    pub(crate) fn truncate(&self, length: u64) -> io::Result<()> {
        self.file.set_len(length)
    }

    /// Waits until everything written is on the medium, and lets the system reclaim the memory of
    /// its cached pages.
    ///
    /// For files that are not read soon. Pages that other readers need stay in memory, and the next
    /// write takes pages that were recently used, instead of pages that the system has to find
    /// first. This reduces the system's time by a third on virtual machines whose host reclaims
    /// free memory.
    pub(crate) fn sync_and_release(&self) -> BoxFuture<'static, io::Result<()>> {
        let file = Arc::clone(&self.file);
        pool::run(move || {
            file.sync_all()?;
            // This is advice: if the system ignores it, nothing is lost. That of Apple has none.
            #[cfg(not(target_vendor = "apple"))]
            let _ = rustix::fs::fadvise(&*file, 0, None, rustix::fs::Advice::DontNeed);
            Ok(())
        })
        .boxed()
    }
}

impl From<Arc<File>> for ThreadsFile {
    /// Wraps a file that was opened elsewhere. Reads return at most the bytes that the file has
    /// now.
    fn from(file: Arc<File>) -> Self {
        let length = file.metadata().map_or(0, |metadata| metadata.len());
        Self::new(file, length)
    }
}

impl ReadAt for ThreadsFile {
    fn length(&self) -> u64 {
        self.length
    }

    fn backend(&self) -> &'static str {
        "threads"
    }

    fn lock_shared(&self, number: u64) -> io::Result<()> {
        self.numbers.lock_shared(number)
    }

    fn read_at(&self, range: Range<u64>) -> BoxFuture<'static, io::Result<Bytes>> {
        let (file, buffers, known) = (Arc::clone(&self.file), self.buffers.clone(), self.length);
        let read = pool::run(move || {
            let length = length_of(&range)?;
            if length > 0 {
                check_within(&range, known, &file)?;
            }
            let mut buffer = buffers.take(length);
            file.read_exact_at(buffer.as_mut(), range.start)?;
            Ok(buffer.freeze())
        });
        let numbers = Arc::clone(&self.numbers);
        async move {
            let answer = read.await;
            drop(numbers);
            answer
        }
        .boxed()
    }

    fn rest(&self) {
        self.buffers.clear();
    }
}

impl WriteAt for ThreadsFile {
    fn write_at(&self, offset: u64, data: Bytes) -> BoxFuture<'static, io::Result<()>> {
        let (file, lock) = (Arc::clone(&self.file), self.lock.clone());
        pool::run(move || {
            let _until_written = lock;
            end_of(offset, data.len())?;
            file.write_all_at(&data, offset)
        })
        .boxed()
    }

    fn sync(&self) -> BoxFuture<'static, io::Result<()>> {
        let file = Arc::clone(&self.file);
        pool::run(move || file.sync_all()).boxed()
    }
}
