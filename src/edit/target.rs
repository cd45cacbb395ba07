//! The locked file of an edit.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use crate::edit::error::EditError;
use crate::io::{FileLock, ThreadsFile, is_manifest, is_named, open_regular, output_target};
use crate::shown;
use crate::store::{Cache, OpenOptions, ReadError, TileReader};

/// A file with an exclusive lock. The lock is released when this, and all that have `file`, are
/// dropped. Readers do not hold it.
#[derive(Clone)]
pub(crate) struct Target {
    pub(crate) path: PathBuf,
    pub(crate) file: ThreadsFile,
    /// A reader of the current state, kept for the next edit.
    kept: Option<TileReader>,
}

impl Target {
    pub(crate) fn lock(path: &Path) -> Result<Self, EditError> {
        if is_manifest(path) {
            return Err(EditError::InParts(path.to_owned()));
        }
        let target = output_target(path).map_err(|error| EditError::io(path, "open", error))?;
        // A build may give the name to another file, between opening and locking.
        for _ in 0..100 {
            let file = open_regular(&target, File::options().read(true).write(true));
            let (file, _) = file.map_err(|error| EditError::io(path, "open", error))?;
            let lock = match FileLock::try_new(file) {
                Ok(lock) => lock,
                Err(TryLockError::WouldBlock) => break,
                Err(TryLockError::Error(error)) => return Err(EditError::io(path, "lock", error)),
            };
            if is_named(lock.file(), &target).map_err(|error| EditError::io(path, "lock", error))? {
                return Ok(Self {
                    path: path.to_owned(),
                    file: ThreadsFile::locked(lock),
                    kept: None,
                });
            }
        }
        Err(EditError::Busy(path.to_owned()))
    }

    /// Returns the same file under the name that it has got.
    pub(crate) fn renamed(self, path: PathBuf) -> Self {
        Self { path, ..self }
    }

    /// Takes note of the length that the file has now.
    pub(crate) fn renew(&mut self) {
        self.file = self.file.renewed();
        self.kept = None;
    }

    /// Opens the file in its current state, and keeps the reader for [`handed_over`](Self::handed_over).
    pub(crate) async fn read_and_keep(&mut self) -> Result<TileReader, ReadError> {
        let reader = self.read().await?;
        self.kept = Some(reader.clone());
        Ok(reader)
    }

    /// Returns the file for one edit, with the reader that was kept.
    pub(crate) fn handed_over(&mut self) -> Self {
        let kept = self.kept.take();
        Self { kept, ..self.clone() }
    }

    /// Takes the reader that was kept, or opens the file in its current state.
    pub(crate) async fn take_reader(&mut self) -> Result<TileReader, ReadError> {
        match self.kept.take() {
            Some(reader) => Ok(reader),
            None => self.read().await,
        }
    }

    /// Opens the file in its current state.
    pub(crate) async fn read(&self) -> Result<TileReader, ReadError> {
        self.open(OpenOptions::default()).await
    }

    /// Opens the file in its current state, with about `bytes` of memory for tiles.
    pub(crate) async fn read_within(&self, bytes: u64) -> Result<TileReader, ReadError> {
        let cache = Cache::new(usize::try_from(bytes).unwrap_or(usize::MAX));
        self.open(OpenOptions::default().cache(&cache)).await
    }

    /// Opens the file in its current state with these options.
    pub(crate) async fn open(&self, options: OpenOptions) -> Result<TileReader, ReadError> {
        let name = shown::path(&self.path);
        TileReader::open_source(self.file.without_lock(), &name, options).await
    }
}
