//! Locks of single bytes of a file, beyond its end, which stand for numbers. They belong to an open
//! file and not to the process, so that they hold within a process, too ("open file description
//! locks", Linux).

use std::fs::File;
use std::sync::Arc;
use std::{io, process};

use parking_lot::Mutex;

#[cfg(all(target_os = "linux", target_pointer_width = "64"))]
pub(crate) use linux::is_locked_below;
#[cfg(all(target_os = "linux", target_pointer_width = "64"))]
use linux::{lock_shared, unlock};
#[cfg(not(all(target_os = "linux", target_pointer_width = "64")))]
pub(crate) use others::is_locked_below;
#[cfg(not(all(target_os = "linux", target_pointer_width = "64")))]
use others::{lock_shared, unlock};

/// The numbers that are locked through an open file, released when this is dropped.
///
/// The system's own locks last until the last handle of the open file is closed. An operation that
/// nobody awaits may have one for a while, and so may a process that is being started.
#[derive(Debug)]
pub(crate) struct RangeLocks {
    file: Arc<File>,
    locked: Mutex<Vec<u64>>,
    /// A child of a fork has the same locks, and must not release them.
    process: u32,
}

impl RangeLocks {
    pub(crate) fn new(file: Arc<File>) -> Self {
        Self {
            file,
            locked: Mutex::default(),
            process: process::id(),
        }
    }

    /// Locks a number, as others may at the same time.
    pub(crate) fn lock_shared(&self, number: u64) -> io::Result<()> {
        lock_shared(&self.file, number)?;
        self.locked.lock().push(number);
        Ok(())
    }
}

impl Drop for RangeLocks {
    fn drop(&mut self) {
        if self.process == process::id() {
            for &number in &*self.locked.get_mut() {
                // If it fails, the lock lasts until the file is closed.
                let _ = unlock(&self.file, number);
            }
        }
    }
}

#[cfg(all(target_os = "linux", target_pointer_width = "64"))]
mod linux {
    use std::fs::File;
    use std::io;

    use nix::fcntl::{FcntlArg, fcntl};
    use nix::libc::{F_RDLCK, F_UNLCK, F_WRLCK, SEEK_SET, c_int, flock, off_t};

    /// The byte that stands for 0. No file is so long.
    const FIRST: off_t = 1 << 62;

    fn range(kind: c_int, numbers: std::ops::Range<u64>) -> io::Result<flock> {
        let at = |number: u64| {
            let at = off_t::try_from(number)
                .ok()
                .and_then(|number| FIRST.checked_add(number));
            at.ok_or_else(|| io::Error::from(io::ErrorKind::InvalidInput))
        };
        let (start, end) = (at(numbers.start)?, at(numbers.end)?);
        Ok(flock {
            l_type: kind as i16,
            l_whence: SEEK_SET as i16,
            l_start: start,
            l_len: end - start,
            l_pid: 0,
        })
    }

    pub(super) fn lock_shared(file: &File, number: u64) -> io::Result<()> {
        set(file, F_RDLCK, number)
    }

    pub(super) fn unlock(file: &File, number: u64) -> io::Result<()> {
        set(file, F_UNLCK, number)
    }

    fn set(file: &File, kind: c_int, number: u64) -> io::Result<()> {
        let lock = range(kind, number..number + 1)?;
        fcntl(file, FcntlArg::F_OFD_SETLK(&lock))?;
        Ok(())
    }

    /// Returns whether others have locked a number below `end`. Fails if the file cannot be locked.
    pub(crate) fn is_locked_below(file: &File, end: u64) -> io::Result<bool> {
        if end == 0 {
            return Ok(false);
        }
        let mut lock = range(F_WRLCK, 0..end)?;
        fcntl(file, FcntlArg::F_OFD_GETLK(&mut lock))?;
        Ok(c_int::from(lock.l_type) != F_UNLCK)
    }
}

#[cfg(not(all(target_os = "linux", target_pointer_width = "64")))]
mod others {
    use std::fs::File;
    use std::io;

    pub(super) fn lock_shared(_: &File, _: u64) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }

    pub(super) fn unlock(_: &File, _: u64) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }

    pub(crate) fn is_locked_below(_: &File, _: u64) -> io::Result<bool> {
        Err(io::ErrorKind::Unsupported.into())
    }
}

#[cfg(all(test, target_os = "linux", target_pointer_width = "64"))]
mod tests {
    use super::*;

    #[test]
    fn locks_of_other_open_files_are_seen_until_they_are_dropped() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let open = || Arc::new(File::open(file.path()).unwrap());
        let editor = File::options().write(true).open(file.path()).unwrap();
        // The files stay open.
        let files = [open(), open()];
        let [first, second] = files.clone().map(RangeLocks::new);
        first.lock_shared(4).unwrap();
        second.lock_shared(4).unwrap();
        let below = |end: u64| is_locked_below(&editor, end).unwrap();
        assert_eq!([0, 4, 5, 1 << 40].map(below), [false, false, true, true]);
        drop(first);
        assert!(below(5));
        drop(second);
        assert!(!below(5));
        assert!(is_locked_below(&editor, u64::MAX).is_err());
    }
}
