//! The device without anything of ours: blocks of the same file, read past the page cache, so many at a time.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use memmap2::MmapMut;

use super::took::{Clock, Took};

/// Bytes of a huge page: more than direct reads ask of where memory begins.
const HUGE_PAGE: usize = 2 << 20;

/// A file that is read past the page cache.
pub struct Device {
    file: File,
    length: u64,
}

impl Device {
    /// Fails where the system or the file system has no such thing.
    #[cfg(target_os = "linux")]
    pub fn open(path: &Path) -> io::Result<Self> {
        use std::os::unix::fs::OpenOptionsExt;

        let flags = rustix::fs::OFlags::DIRECT.bits() as i32;
        let file = File::options().read(true).custom_flags(flags).open(path)?;
        let length = file.metadata()?.len();
        Ok(Self { file, length })
    }

    /// Only Linux has it.
    #[cfg(not(target_os = "linux"))]
    pub fn open(_: &Path) -> io::Result<Self> {
        Err(io::ErrorKind::Unsupported.into())
    }

    /// Reads the whole file from front to back in blocks of so many bytes, so many at a time.
    pub fn scan(&self, block: usize, depth: usize, into: Into) -> io::Result<Took> {
        let places: Vec<u64> = (0..self.length).step_by(block).collect();
        self.read(&places, block, depth, into)
    }

    /// Reads blocks at these places, which are multiples of 4096, each of so many bytes, so many at a time.
    pub fn read(&self, places: &[u64], block: usize, depth: usize, into: Into) -> io::Result<Took> {
        let (next, bytes) = (AtomicU64::new(0), AtomicU64::new(0));
        let clock = Clock::start();
        let work = || -> io::Result<()> {
            let mut memory = into.memory((block + HUGE_PAGE).next_multiple_of(HUGE_PAGE))?;
            let address = memory.as_ptr().addr();
            let start = address.next_multiple_of(HUGE_PAGE) - address;
            let buffer = &mut memory[start..start + block];
            while let Some(&place) = places.get(next.fetch_add(1, Ordering::Relaxed) as usize) {
                let read = self.file.read_at(buffer, place)?;
                bytes.fetch_add(read as u64, Ordering::Relaxed);
            }
            Ok(())
        };
        thread::scope(|scope| {
            let workers = (0..depth).map(|_| thread::Builder::new().spawn_scoped(scope, work));
            let workers: Vec<_> = workers.collect::<io::Result<_>>()?;
            workers.into_iter().try_for_each(|worker| {
                let done = worker.join();
                done.unwrap_or_else(|_| Err(io::Error::other("a thread that read is gone")))
            })
        })?;
        Ok(clock.took(bytes.into_inner()))
    }
}

/// What is read into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Into {
    /// Memory as programs have it.
    Pages,
    /// Huge pages, where there are any: a disk is handed memory page by page, which takes longer for small ones.
    HugePages,
}

impl Into {
    fn memory(self, bytes: usize) -> io::Result<MmapMut> {
        let memory = MmapMut::map_anon(bytes)?;
        #[cfg(target_os = "linux")]
        // Where there are none, the others have to do.
        let _ = memory.advise(match self {
            Self::Pages => memmap2::Advice::NoHugePage,
            Self::HugePages => memmap2::Advice::HugePage,
        });
        Ok(memory)
    }
}
