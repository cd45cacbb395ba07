//! Files that appear under their name when they are complete.
//!
//! Until then such a file lies beside its name, as `.NAME.partial`, locked. What a killed process left there is not locked, and the
//! next one that writes the same output takes it over.

use std::ffi::OsString;
use std::fs::{File, TryLockError};
use std::io::ErrorKind;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::{fs, io};

use rustix::fs::OFlags;

use crate::io::regular::require_regular;

/// The most symbolic links that are followed, as many as Linux follows.
const MOST_LINKS: usize = 40;

/// The file that an output of this name goes to: what a symbolic link leads to, there or not, else the name itself.
///
/// # Errors
/// If what has the name is no file, since devices, pipes, sockets and folders are never replaced; or links go round in a circle.
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
    // Nothing is there, or a link to nothing.
    for _ in 0..MOST_LINKS {
        match fs::read_link(&target) {
            Ok(next) => target = folder_of(&target).join(next),
            Err(_) if target.file_name().is_none() => return Err(ErrorKind::IsADirectory.into()),
            Err(_) => return Ok(target),
        }
    }
    Err(rustix::io::Errno::LOOP.into())
}

/// The folder that a file lies in.
pub(crate) fn folder_of(file: &Path) -> &Path {
    let parent = file.parent().filter(|parent| !parent.as_os_str().is_empty());
    parent.unwrap_or(Path::new("."))
}

/// Whether a name leads to this file.
pub(crate) fn is_named(file: &File, name: &Path) -> io::Result<bool> {
    let identity = |metadata: fs::Metadata| (metadata.dev(), metadata.ino());
    Ok(fs::symlink_metadata(name).map(identity).ok() == Some(identity(file.metadata()?)))
}

/// A file that gets its name when it is complete. Dropped before that it goes away.
#[derive(Debug)]
pub struct OutputFile {
    /// Locked as long as it is open.
    file: File,
    partial: PathBuf,
    target: PathBuf,
    is_published: bool,
}

impl OutputFile {
    /// Begins a file of this name, or the one that a symbolic link of this name leads to.
    ///
    /// # Errors
    /// Those of [`output_target`], [`ErrorKind::ResourceBusy`] if another process is writing the same output, and what the
    /// system says.
    pub fn create(path: &Path) -> io::Result<Self> {
        let target = output_target(path)?;
        let mut name = OsString::from(".");
        name.push(target.file_name().unwrap_or_default());
        name.push(".partial");
        let partial = target.with_file_name(name);
        // Whoever publishes or drops a file takes the name away: whoever locked that one must try again.
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

    /// The file, to be written. Its clones hold its lock, too.
    #[must_use]
    pub fn file(&self) -> &File {
        &self.file
    }

    /// The name that it will get.
    #[must_use]
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Gives the file its name when all of it is on the medium, and brings the name there too. What had the name is replaced.
    ///
    /// # Errors
    /// What the system says, and those of [`output_target`] if what has the name by now is no file.
    pub fn publish(mut self) -> io::Result<()> {
        self.file.sync_all()?;
        output_target(&self.target)?;
        // Before the file has its name, so that a refusal leaves what was there.
        let folder = File::open(folder_of(&self.target))?;
        fs::rename(&self.partial, &self.target)?;
        self.is_published = true;
        folder.sync_all()
    }
}

impl Drop for OutputFile {
    fn drop(&mut self) {
        if !self.is_published {
            // An error is under way already; this one would hide it.
            let _ = fs::remove_file(&self.partial);
        }
    }
}

fn about(path: &Path, error: io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}
