//! A log of everything that a program does to the files of one folder, in order, with data. Power
//! cuts are replayed from it.
//!
//! A record is a kind, two numbers and two byte strings, each after its length; numbers are
//! little-endian: `kind: u8, first: u64, second: u64, length: u32, bytes, length: u32, bytes`.
//! Paths are relative to the folder.
//!
//! | kind | numbers | bytes |
//! |---|---|---|
//! | 1 a name is opened to create or write a file | inode, 1 if it is truncated | path |
//! | 2 bytes are written | inode, offset | the bytes |
//! | 3 the length is set | inode, length | |
//! | 4 a file is synced | inode | |
//! | 5 a folder is synced | | path |
//! | 6 a name is changed | | path before, path after |
//! | 7 a name is removed | | path |
//! | 8 a folder is made | | path |

use std::ffi::{CStr, CString, OsStr, c_char, c_int};
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, OnceLock};

use libc::{off64_t, size_t};

use crate::real;

/// An open log.
pub struct Log {
    file: c_int,
    root: PathBuf,
}

/// Returns the log, if there is one. The caller keeps it locked until the call and its record are
/// done, so records are in the order of the calls.
pub fn begin() -> Option<MutexGuard<'static, Log>> {
    static LOG: OnceLock<Option<Mutex<Log>>> = OnceLock::new();
    let open = || {
        let root = PathBuf::from(std::env::var_os("FAULTS_LOG_ROOT")?);
        let path = CString::new(std::env::var_os("FAULTS_LOG")?.into_vec()).ok()?;
        let flags = libc::O_WRONLY | libc::O_CREAT | libc::O_APPEND | libc::O_CLOEXEC;
        // SAFETY: the path ends with a zero.
        let file = unsafe { real::open64()(path.as_ptr(), flags, 0o600) };
        (file >= 0).then(|| Mutex::new(Log { file, root }))
    };
    LOG.get_or_init(open).as_ref()?.lock().ok()
}

impl Log {
    fn put(&self, kind: u8, numbers: [u64; 2], bytes: [&[u8]; 2]) {
        let mut record = vec![kind];
        numbers.iter().for_each(|number| record.extend(number.to_le_bytes()));
        for bytes in bytes {
            record.extend((bytes.len() as u32).to_le_bytes());
            record.extend(bytes);
        }
        // SAFETY: the record has the given length.
        let written = unsafe { real::write()(self.file, record.as_ptr().cast(), record.len()) };
        assert_eq!(written, record.len() as isize, "the log of writes cannot be written");
    }

    /// Returns a path within the folder, relative to it.
    fn within(&self, path: &Path) -> Option<PathBuf> {
        let path = std::env::current_dir().ok()?.join(path);
        Some(path.strip_prefix(&self.root).ok()?.to_owned())
    }

    fn path(&self, path: *const c_char) -> Option<PathBuf> {
        // SAFETY: callers of the C library pass a path that ends with a zero.
        let path = unsafe { CStr::from_ptr(path) };
        self.within(Path::new(OsStr::from_bytes(path.to_bytes())))
    }

    /// Returns the path of an open file, whether it is a folder, and its inode.
    fn open_path(&self, fd: c_int) -> Option<(PathBuf, bool, u64)> {
        let path = std::fs::read_link(format!("/proc/self/fd/{fd}")).ok()?;
        let path = self.within(&path)?;
        // SAFETY: the structure is plain numbers, and the call fills it.
        let stat = unsafe {
            let mut stat = std::mem::zeroed::<libc::stat64>();
            (libc::fstat64(fd, &raw mut stat) == 0).then_some(stat)?
        };
        Some((path, stat.st_mode & libc::S_IFMT == libc::S_IFDIR, stat.st_ino))
    }

    pub fn opened(&self, fd: c_int, path: *const c_char, flags: c_int) {
        if flags & libc::O_ACCMODE == libc::O_RDONLY {
            return;
        }
        if let (Some(path), Some((_, false, inode))) = (self.path(path), self.open_path(fd)) {
            let is_truncated = u64::from(flags & libc::O_TRUNC != 0);
            self.put(1, [inode, is_truncated], [path.as_os_str().as_bytes(), &[]]);
        }
    }

    /// Logs a write. `at` is the offset of the bytes, or `None` if they were written at the file's
    /// position, which is behind them now.
    pub fn written(&self, fd: c_int, at: Option<off64_t>, from: *const u8, bytes: size_t) {
        if let Some((_, false, inode)) = self.open_path(fd) {
            // SAFETY: the call moves nothing.
            let at = at.unwrap_or_else(|| unsafe { libc::lseek64(fd, 0, libc::SEEK_CUR) } - bytes as off64_t);
            // SAFETY: the caller of the C library guarantees this number of bytes or more.
            let bytes = unsafe { std::slice::from_raw_parts(from, bytes) };
            self.put(2, [inode, at as u64], [bytes, &[]]);
        }
    }

    pub fn truncated(&self, fd: c_int, length: off64_t) {
        if let Some((_, false, inode)) = self.open_path(fd) {
            self.put(3, [inode, length as u64], [&[], &[]]);
        }
    }

    pub fn synced(&self, fd: c_int) {
        match self.open_path(fd) {
            Some((_, false, inode)) => self.put(4, [inode, 0], [&[], &[]]),
            Some((path, true, _)) => self.put(5, [0, 0], [path.as_os_str().as_bytes(), &[]]),
            None => {}
        }
    }

    pub fn renamed(&self, from: *const c_char, to: *const c_char) {
        if let (Some(from), Some(to)) = (self.path(from), self.path(to)) {
            self.put(6, [0, 0], [from.as_os_str().as_bytes(), to.as_os_str().as_bytes()]);
        }
    }

    pub fn removed(&self, path: *const c_char) {
        self.removed_path(self.path(path));
    }

    pub fn removed_at(&self, folder: c_int, path: *const c_char) {
        let name = match folder {
            libc::AT_FDCWD => self.path(path),
            // SAFETY: callers of the C library pass a path that ends with a zero.
            _ => self
                .open_path(folder)
                .map(|(folder, ..)| folder.join(OsStr::from_bytes(unsafe { CStr::from_ptr(path) }.to_bytes()))),
        };
        self.removed_path(name);
    }

    fn removed_path(&self, path: Option<PathBuf>) {
        if let Some(path) = path {
            self.put(7, [0, 0], [path.as_os_str().as_bytes(), &[]]);
        }
    }

    pub fn made(&self, path: *const c_char) {
        if let Some(path) = self.path(path) {
            self.put(8, [0, 0], [path.as_os_str().as_bytes(), &[]]);
        }
    }
}
