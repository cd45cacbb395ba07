//! Locks of single bytes of a file, beyond its end, which stand for numbers. They belong to an open
//! file and not to the process, so that they hold within a process, too ("open file description
//! locks", Linux).

#[cfg(all(target_os = "linux", target_pointer_width = "64"))]
pub(crate) use linux::{is_locked_below, lock_shared};
#[cfg(not(all(target_os = "linux", target_pointer_width = "64")))]
pub(crate) use others::{is_locked_below, lock_shared};

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

    /// Locks a number, as others may at the same time, until the file is closed.
    pub(crate) fn lock_shared(file: &File, number: u64) -> io::Result<()> {
        let lock = range(F_RDLCK, number..number + 1)?;
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

    pub(crate) fn lock_shared(_: &File, _: u64) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }

    pub(crate) fn is_locked_below(_: &File, _: u64) -> io::Result<bool> {
        Err(io::ErrorKind::Unsupported.into())
    }
}

#[cfg(all(test, target_os = "linux", target_pointer_width = "64"))]
mod tests {
    use std::fs::File;

    use super::*;

    #[test]
    fn locks_of_other_open_files_are_seen_until_they_are_closed() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let open = || File::open(file.path()).unwrap();
        let editor = File::options().write(true).open(file.path()).unwrap();
        let (first, second) = (open(), open());
        lock_shared(&first, 4).unwrap();
        lock_shared(&second, 4).unwrap();
        let below = |end: u64| is_locked_below(&editor, end).unwrap();
        assert_eq!([0, 4, 5, 1 << 40].map(below), [false, false, true, true]);
        drop(first);
        assert!(below(5));
        drop(second);
        assert!(!below(5));
        assert!(is_locked_below(&editor, u64::MAX).is_err());
    }
}
