//! The folder `OUT.partial/`, in which a file is completed before it gets its name.

use std::ffi::OsString;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use super::BuildError;

const LOCK: &str = "lock";

/// A locked work folder; it goes away with this value.
#[derive(Debug)]
pub(super) struct WorkFolder {
    path: PathBuf,
    output: PathBuf,
    /// Held, so that the lock lasts.
    _lock: File,
}

impl WorkFolder {
    /// Makes the folder, or takes over one that a dead build left, after emptying it.
    pub(super) fn create(output: &Path, force: bool) -> Result<Self, BuildError> {
        if output.is_dir() || output.file_name().is_none() {
            return Err(BuildError::io(
                output,
                "write a file under this name",
                io::ErrorKind::IsADirectory.into(),
            ));
        }
        if !force && output.exists() {
            return Err(BuildError::OutputExists(output.to_owned()));
        }
        let mut name = OsString::from(output);
        name.push(".partial");
        let path = PathBuf::from(name);
        match fs::create_dir(&path) {
            Ok(()) => {}
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                if !path.join(LOCK).is_file() {
                    return Err(BuildError::NotOurs(path));
                }
            }
            Err(error) => return Err(BuildError::io(&path, "make the work folder", error)),
        }
        let lock = File::create(path.join(LOCK)).map_err(|e| BuildError::io(&path, "lock the work folder", e))?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(BuildError::Locked(path)),
            Err(TryLockError::Error(error)) => return Err(BuildError::io(&path, "lock the work folder", error)),
        }
        let this = Self {
            output: output.to_owned(),
            path,
            _lock: lock,
        };
        this.empty()
            .map_err(|e| BuildError::io(&this.path, "empty the work folder", e))?;
        Ok(this)
    }

    fn empty(&self) -> io::Result<()> {
        for entry in fs::read_dir(&self.path)? {
            let entry = entry?;
            if entry.file_name() != LOCK {
                fs::remove_file(entry.path())?;
            }
        }
        Ok(())
    }

    /// The folder.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Where the file is completed.
    pub(super) fn file(&self) -> PathBuf {
        self.path.join("tiles")
    }

    /// Gives the completed file its name and removes the folder.
    pub(super) fn publish(self) -> Result<(), BuildError> {
        let output = &self.output;
        fs::rename(self.file(), output).map_err(|e| BuildError::io(output, "rename the finished file to", e))?;
        let folder = match output.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        File::open(folder)
            .and_then(|folder| folder.sync_all())
            .map_err(|e| BuildError::io(folder, "sync the folder", e))
    }
}

impl Drop for WorkFolder {
    fn drop(&mut self) {
        if let Err(error) = fs::remove_dir_all(&self.path) {
            tracing::warn!(folder = %self.path.display(), %error, "the work folder could not be removed");
        }
    }
}
