//! Measures the bare device: reads blocks of the same file with direct I/O, several at a time.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use memmap2::MmapMut;

use super::measurement::{Clock, Measurement};

/// Bytes of a huge page, which exceeds the alignment that direct reads require of memory.
const HUGE_PAGE: usize = 2 << 20;

/// A file that is read with direct I/O, which bypasses the page cache.
pub struct Device {
    file: File,
    length: u64,
}

impl Device {
    /// Opens a file for direct I/O.
    ///
    /// # Errors
    /// Fails if the system or the file system does not support direct I/O.
    #[cfg(target_os = "linux")]
    pub fn open(path: &Path) -> io::Result<Self> {
        use std::os::unix::fs::OpenOptionsExt;

        let flags = rustix::fs::OFlags::DIRECT.bits() as i32;
        let file = File::options().read(true).custom_flags(flags).open(path)?;
        let length = file.metadata()?.len();
        Ok(Self { file, length })
    }

    /// Fails, because only Linux supports direct I/O.
    #[cfg(not(target_os = "linux"))]
    pub fn open(_: &Path) -> io::Result<Self> {
        Err(io::ErrorKind::Unsupported.into())
    }

    /// Reads the whole file sequentially in blocks of `block` bytes, `depth` at a time.
    pub fn scan(&self, block: usize, depth: usize, buffer_kind: BufferKind) -> io::Result<Measurement> {
        let offsets: Vec<u64> = (0..self.length).step_by(block).collect();
        self.read(&offsets, block, depth, buffer_kind)
    }

    /// Reads blocks of `block` bytes at these offsets, which are multiples of 4096, `depth` at a
    /// time.
    pub fn read(
        &self,
        offsets: &[u64],
        block: usize,
        depth: usize,
        buffer_kind: BufferKind,
    ) -> io::Result<Measurement> {
        let (next, bytes) = (AtomicU64::new(0), AtomicU64::new(0));
        let clock = Clock::start();
        let work = || -> io::Result<()> {
            let mut memory = buffer_kind.memory((block + HUGE_PAGE).next_multiple_of(HUGE_PAGE))?;
            let address = memory.as_ptr().addr();
            let start = address.next_multiple_of(HUGE_PAGE) - address;
            let buffer = &mut memory[start..start + block];
            while let Some(&offset) = offsets.get(next.fetch_add(1, Ordering::Relaxed) as usize) {
                let read = self.file.read_at(buffer, offset)?;
                bytes.fetch_add(read as u64, Ordering::Relaxed);
            }
            Ok(())
        };
        thread::scope(|scope| {
            let workers = (0..depth).map(|_| thread::Builder::new().spawn_scoped(scope, work));
            let workers: Vec<_> = workers.collect::<io::Result<_>>()?;
            workers.into_iter().try_for_each(|worker| {
                let done = worker.join();
                done.unwrap_or_else(|_| Err(io::Error::other("a reading thread panicked")))
            })
        })?;
        Ok(clock.measure(bytes.into_inner()))
    }
}

/// The kind of memory that blocks are read into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BufferKind {
    /// Pages of the usual size.
    Pages,
    /// Huge pages, if there are any. The disk is given memory page by page, which takes longer for
    /// small pages.
    HugePages,
}

impl BufferKind {
    fn memory(self, bytes: usize) -> io::Result<MmapMut> {
        let memory = MmapMut::map_anon(bytes)?;
        #[cfg(target_os = "linux")]
        // If there are no huge pages, the usual ones are used.
        let _ = memory.advise(match self {
            Self::Pages => memmap2::Advice::NoHugePage,
            Self::HugePages => memmap2::Advice::HugePage,
        });
        Ok(memory)
    }
}
