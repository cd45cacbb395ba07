//! Exclusive locks of files.

use std::fs::{File, TryLockError};
use std::process;
use std::sync::Arc;

/// An exclusive lock of a file, released when this is dropped.
///
/// The system's own lock lasts until the last handle of the open file is closed, those of reads in
/// progress among them, and those that a process which is being started inherits for a moment.
#[derive(Debug)]
pub(crate) struct FileLock {
    file: Arc<File>,
    /// A child of a fork has the same lock, and must not release it.
    process: u32,
}

impl FileLock {
    /// Locks a file, unless another handle has a lock of it.
    pub(crate) fn try_new(file: File) -> Result<Self, TryLockError> {
        file.try_lock()?;
        Ok(Self {
            file: Arc::new(file),
            process: process::id(),
        })
    }

    pub(crate) fn file(&self) -> &Arc<File> {
        &self.file
    }
}

impl Drop for FileLock {
    fn drop(&mut self) {
        if self.process == process::id() {
            // If it fails, the lock lasts until the file is closed.
            let _ = self.file.unlock();
        }
    }
}
