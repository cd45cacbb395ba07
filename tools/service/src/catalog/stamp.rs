//! Whether a file on disk is still the same.

use std::fs;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::time::{Duration, SystemTime};

/// A change within this time before a stamp may leave no other trace: clocks of file systems are coarse.
const RACY: Duration = Duration::from_secs(2);

/// The identity of a file, and when it was changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    device: u64,
    inode: u64,
    length: u64,
    modified: (i64, i64),
    changed: (i64, i64),
    /// Whether the last change is so old that a later one would be seen.
    is_settled: bool,
}

impl Stamp {
    /// Returns the stamp of a file.
    ///
    /// # Errors
    /// Returns the error of the system.
    pub fn of(path: &Path) -> io::Result<Self> {
        let data = fs::metadata(path)?;
        let age = data
            .modified()
            .ok()
            .and_then(|at| SystemTime::now().duration_since(at).ok());
        Ok(Self {
            device: data.dev(),
            inode: data.ino(),
            length: data.len(),
            modified: (data.mtime(), data.mtime_nsec()),
            changed: (data.ctime(), data.ctime_nsec()),
            is_settled: age.is_some_and(|age| age > RACY),
        })
    }

    /// Returns whether a file with the stamp `now` surely has the content that it had with this one.
    pub fn proves_unchanged(&self, now: &Self) -> bool {
        self.is_settled && self == now
    }

    /// Returns whether it is the same file, whatever its content.
    pub fn is_same_file(&self, now: &Self) -> bool {
        (self.device, self.inode) == (now.device, now.inode)
    }
}
