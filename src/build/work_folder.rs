//! The folder `OUT.partial/`, in which a file is completed before it gets its name.

use std::ffi::OsString;
use std::fs::{self, File, TryLockError};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use super::BuildError;

const LOCK: &str = "lock";
const TILES: &str = "tiles";

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
    ///
    /// A folder with anything in it that no build leaves there is not touched.
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
        // A build that ends removes its folder and unlocks: whoever locked what it removed must try again.
        for _ in 0..100 {
            if let Some(lock) = lock(&path)? {
                let this = Self {
                    output: output.to_owned(),
                    path,
                    _lock: lock,
                };
                this.empty()
                    .map_err(|e| BuildError::io(&this.path, "empty the work folder", e))?;
                return Ok(this);
            }
        }
        Err(BuildError::Locked(path))
    }

    fn empty(&self) -> io::Result<()> {
        match fs::remove_file(self.file()) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }

    /// The folder.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Where the file is completed.
    pub(super) fn file(&self) -> PathBuf {
        self.path.join(TILES)
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

/// Makes the folder, or takes over one that holds nothing but what a build leaves, and locks it. None: another build removed it
/// meanwhile.
fn lock(path: &Path) -> Result<Option<File>, BuildError> {
    match fs::create_dir(path) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => match is_ours(path) {
            Ok(true) => {}
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Ok(false) | Err(_) => return Err(BuildError::NotOurs(path.to_owned())),
        },
        made => made.map_err(|error| BuildError::io(path, "make the work folder", error))?,
    }
    let cannot = |error| BuildError::io(path, "lock the work folder", error);
    let name = path.join(LOCK);
    let lock = match File::options().write(true).create(true).truncate(false).open(&name) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        opened => opened.map_err(cannot)?,
    };
    match lock.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => return Err(BuildError::Locked(path.to_owned())),
        Err(TryLockError::Error(error)) => return Err(cannot(error)),
    }
    let identity = |metadata: fs::Metadata| (metadata.dev(), metadata.ino());
    let still_there = fs::metadata(&name).map(identity).ok() == Some(lock.metadata().map(identity).map_err(cannot)?);
    Ok(still_there.then_some(lock))
}

/// Whether a folder holds nothing but files with the names that a build gives.
fn is_ours(path: &Path) -> io::Result<bool> {
    if !fs::symlink_metadata(path)?.is_dir() {
        return Ok(false);
    }
    for entry in fs::read_dir(path)? {
        let entry = entry?;
        if !(entry.file_name() == LOCK || entry.file_name() == TILES) || !entry.file_type()?.is_file() {
            return Ok(false);
        }
    }
    Ok(true)
}
