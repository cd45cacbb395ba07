//! Files that get their name only when they are complete.
//!
//! Until then such a file is beside its target, as `.NAME.partial`, and locked. A killed process
//! leaves its partial file unlocked, and the next process that writes the same output takes it
//! over.

use std::ffi::OsString;
use std::fs::{File, TryLockError};
use std::io::ErrorKind;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::{fs, io};

use rustix::fs::OFlags;

use crate::io::regular::require_regular;
use crate::shown;

/// The limit on the symbolic links that are followed; the same as in Linux.
const MOST_LINKS: usize = 40;

/// Returns the file that an output with this name is written to: the target of a symbolic link,
/// whether it exists or not, otherwise `path` itself.
///
/// # Errors
/// Fails if `path` is not a file, since devices, pipes, sockets and folders are never replaced, or
/// if symbolic links form a cycle.
pub fn output_target(path: &Path) -> io::Result<PathBuf> {
    let mut target = path.to_owned();
    match fs::metadata(path) {
        Ok(found) => {
            require_regular(&found)?;
            return fs::canonicalize(path);
        }
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    // The name does not exist, or it is a link to a name that does not exist.
    for _ in 0..MOST_LINKS {
        match fs::read_link(&target) {
            Ok(next) => target = folder_of(&target).join(next),
            Err(_) if target.file_name().is_none() => return Err(ErrorKind::IsADirectory.into()),
            Err(_) => return Ok(target),
        }
    }
    Err(rustix::io::Errno::LOOP.into())
}

/// Returns the file that a new output with this name is written to, as [`output_target`] does.
///
/// # Errors
/// Fails as [`output_target`] does, and if the folder of the file does not exist.
pub(crate) fn new_output(path: &Path) -> io::Result<PathBuf> {
    let target = output_target(path)?;
    let folder = folder_of(&target);
    match fs::metadata(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let message = format!("the folder {} does not exist; create it first", shown::path(folder));
            Err(io::Error::new(ErrorKind::NotFound, message))
        }
        // Any other error appears when the file is created.
        _ => Ok(target),
    }
}

/// Returns the folder of a file.
pub(crate) fn folder_of(file: &Path) -> &Path {
    let parent = file.parent().filter(|parent| !parent.as_os_str().is_empty());
    parent.unwrap_or(Path::new("."))
}

/// Returns whether `name` is a name of this file.
pub(crate) fn is_named(file: &File, name: &Path) -> io::Result<bool> {
    let identity = |metadata: fs::Metadata| (metadata.dev(), metadata.ino());
    Ok(fs::symlink_metadata(name).map(identity).ok() == Some(identity(file.metadata()?)))
}

/// A file that gets its name when it is complete. If it is dropped before that, it is removed.
#[derive(Debug)]
pub struct OutputFile {
    /// The partial file, locked while it is open.
    file: File,
    partial: PathBuf,
    target: PathBuf,
    is_published: bool,
}

impl OutputFile {
    /// Creates the partial file for an output with this name, or for the target of a symbolic link
    /// with this name.
    ///
    /// # Errors
    /// Fails as [`output_target`] does, with [`ErrorKind::NotFound`] if the folder does not exist,
    /// with [`ErrorKind::ResourceBusy`] if another process is writing the same output, and with the
    /// errors of the operating system.
    pub fn create(path: &Path) -> io::Result<Self> {
        let target = new_output(path)?;
        let mut name = OsString::from(".");
        name.push(target.file_name().unwrap_or_default());
        name.push(".partial");
        let partial = target.with_file_name(name);
        // A process that publishes or drops its file removes the name. A process that has locked a
        // file without its name must try again.
        for _ in 0..100 {
            let file = File::options()
                .read(true)
                .write(true)
                .create(true)
                .truncate(false)
                .custom_flags((OFlags::NOFOLLOW | OFlags::NONBLOCK).bits().cast_signed())
                .open(&partial)
                .map_err(|error| about(&partial, error))?;
            match file.try_lock() {
                Err(TryLockError::WouldBlock) => break,
                Err(TryLockError::Error(error)) => return Err(about(&partial, error)),
                Ok(()) => {}
            }
            if !is_named(&file, &partial)? {
                continue;
            }
            file.set_len(0).map_err(|error| about(&partial, error))?;
            return Ok(Self {
                file,
                partial,
                target,
                is_published: false,
            });
        }
        let message = format!("another process is writing it, as {}", partial.display());
        Err(io::Error::new(ErrorKind::ResourceBusy, message))
    }

    /// Returns the file for writing. Its clones hold its lock, too.
    #[must_use]
    pub fn file(&self) -> &File {
        &self.file
    }

    /// Returns the name that the file will get.
    #[must_use]
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Brings the file onto the medium, gives it its name, and brings the name onto the medium. A
    /// file that had the name is replaced.
    ///
    /// # Errors
    /// Fails with the errors of the operating system, and as [`output_target`] does if the name no
    /// longer belongs to a file.
    pub fn publish(mut self) -> io::Result<()> {
        self.file.sync_all()?;
        output_target(&self.target)?;
        // Opened before the file gets its name, so that a refusal keeps the old file.
        let folder = File::open(folder_of(&self.target))?;
        fs::rename(&self.partial, &self.target)?;
        self.is_published = true;
        folder.sync_all()
    }
}

impl Drop for OutputFile {
    fn drop(&mut self) {
        if !self.is_published {
            // An error is already being reported; an error here would hide it.
            let _ = fs::remove_file(&self.partial);
        }
    }
}

fn about(path: &Path, error: io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}
