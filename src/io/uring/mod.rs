//! Files on disk, read and written through an io_uring.
//!
//! All files of the process share one ring, which has its own thread (`ring`). Requests go to it by
//! a channel, with everything that the operation needs, and each answer comes back by a channel of
//! its own. Reads bypass the page cache (`O_DIRECT`) if the file system supports this, directly
//! into the memory in which tiles are used. Files that are written use the page cache, since
//! appended data begins and ends at any offset.

mod pages;
pub(crate) mod ring;
mod transfer;

use std::fs::File;
use std::io;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use bytes::Bytes;
use futures::future::{BoxFuture, FutureExt, ready};
use rustix::fs::{AtFlags, OFlags, StatxFlags, fcntl_getfl, fcntl_setfl, statx};
use tokio::sync::oneshot;

use crate::io::file::{KEPT_OF_TILES, ReadAt, WriteAt, check_within, end_of, length_of};
use crate::io::range_lock::RangeLocks;
use crate::io::regular::open_regular;
use pages::{ALIGNMENT, PagePool};
pub(super) use ring::Ring;
use ring::{Operation, gone};

/// A file on disk that an io_uring reads and writes. Clones share it.
#[derive(Clone, Debug)]
pub struct UringFile {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    ring: Arc<Ring>,
    /// The number that identifies the file in the ring.
    number: u64,
    file: Arc<File>,
    numbers: RangeLocks,
    length: u64,
    /// Whether reads bypass the page cache.
    is_direct: bool,
    pool: PagePool,
}

impl Drop for Shared {
    fn drop(&mut self) {
        self.ring.close(self.number);
    }
}

impl UringFile {
    /// Opens a file for reading.
    ///
    /// # Errors
    /// Fails with [`io::ErrorKind::IsADirectory`] for a folder, and with the system's error for the
    /// file or for a ring.
    pub fn open(path: &Path) -> io::Result<Self> {
        Self::open_on(Ring::shared()?, path)
    }

    /// Opens a file for reading through `ring`.
    pub(super) fn open_on(ring: Arc<Ring>, path: &Path) -> io::Result<Self> {
        let (file, _) = open_regular(path, File::options().read(true))?;
        // A file system that claims support may still refuse; then reads use the page cache.
        let is_direct = can_be_direct(&file)
            && fcntl_getfl(&file).is_ok_and(|flags| fcntl_setfl(&file, flags | OFlags::DIRECT).is_ok());
        Self::new(ring, file, is_direct)
    }

    /// Creates a new, empty file for writing and reading.
    ///
    /// # Errors
    /// Fails with the system's error for the file or for a ring.
    pub fn create(path: &Path) -> io::Result<Self> {
        let ring = Ring::shared()?;
        let file = File::options()
            .read(true)
            .write(true)
            .create(true)
            .truncate(true)
            .open(path)?;
        Self::new(ring, file, false)
    }

    fn new(ring: Arc<Ring>, file: File, is_direct: bool) -> io::Result<Self> {
        let file = Arc::new(file);
        let shared = Shared {
            number: ring.open(file.try_clone()?)?,
            ring,
            length: file.metadata()?.len(),
            numbers: RangeLocks::new(Arc::clone(&file)),
            file,
            is_direct,
            pool: PagePool::keeping(KEPT_OF_TILES),
        };
        Ok(Self {
            shared: Arc::new(shared),
        })
    }

    /// Returns whether reads bypass the page cache.
    #[must_use]
    pub fn is_direct(&self) -> bool {
        self.shared.is_direct
    }

    /// Requests an operation of the ring. The file stays open until the answer has come, and numbers
    /// stay locked until nobody awaits it.
    fn ask<T: Send + 'static>(
        &self,
        operation: impl FnOnce(oneshot::Sender<io::Result<T>>) -> Operation,
    ) -> BoxFuture<'static, io::Result<T>> {
        let (reply, answer) = oneshot::channel();
        let shared = Arc::clone(&self.shared);
        match shared.ring.ask(shared.number, operation(reply)) {
            Err(error) => ready(Err(error)).boxed(),
            Ok(()) => async move {
                let answer = answer.await.unwrap_or_else(|_| Err(gone()));
                drop(shared);
                answer
            }
            .boxed(),
        }
    }
}

/// Returns whether reads that are aligned to [`ALIGNMENT`] may bypass the page cache. Linux before
/// 6.1 does not report this.
fn can_be_direct(file: &File) -> bool {
    let Ok(status) = statx(file, "", AtFlags::EMPTY_PATH, StatxFlags::DIOALIGN) else {
        return false;
    };
    let fits = |alignment: u32| alignment != 0 && ALIGNMENT.is_multiple_of(alignment as usize);
    status.stx_mask & StatxFlags::DIOALIGN.bits() != 0
        && fits(status.stx_dio_mem_align)
        && fits(status.stx_dio_offset_align)
}

impl ReadAt for UringFile {
    fn length(&self) -> u64 {
        self.shared.length
    }

    fn backend(&self) -> &'static str {
        "uring"
    }

    fn lock_shared(&self, number: u64) -> io::Result<()> {
        self.shared.numbers.lock_shared(number)
    }

    fn note(&self) -> Option<&str> {
        (!self.shared.is_direct).then_some("through the page cache, since this file cannot be read directly")
    }

    fn read_at(&self, range: Range<u64>) -> BoxFuture<'static, io::Result<Bytes>> {
        let length = match length_of(&range) {
            Ok(0) => return ready(Ok(Bytes::new())).boxed(),
            Ok(length) => length,
            Err(error) => return ready(Err(error)).boxed(),
        };
        // No buffer is allocated for bytes that do not exist.
        if let Err(error) = check_within(&range, self.shared.length, &self.shared.file) {
            return ready(Err(error)).boxed();
        }
        self.ask(|reply| Operation::Read {
            offset: range.start,
            length,
            is_direct: self.shared.is_direct,
            pool: self.shared.pool.clone(),
            reply,
        })
    }

    fn rest(&self) {
        self.shared.pool.clear();
    }
}

impl WriteAt for UringFile {
    fn write_at(&self, offset: u64, data: Bytes) -> BoxFuture<'static, io::Result<()>> {
        if let Err(error) = end_of(offset, data.len()) {
            return ready(Err(error)).boxed();
        }
        self.ask(|reply| Operation::Write { offset, data, reply })
    }

    fn sync(&self) -> BoxFuture<'static, io::Result<()>> {
        self.ask(|reply| Operation::Sync { reply })
    }
}
