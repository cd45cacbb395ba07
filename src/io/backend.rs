//! Which backend files on disk are read by: chosen by name, by the environment, or by what the system allows.

use std::ops::Range;
use std::path::Path;
use std::str::FromStr;
use std::sync::{Arc, Once};
use std::{fmt, io};

use bytes::Bytes;
use futures::future::BoxFuture;

use crate::io::file::ReadAt;
use crate::io::threads::ThreadsFile;

/// The environment variable that names the backend where the program does not.
pub const BACKEND_VARIABLE: &str = "DELAUNAY_TILES_IO";

/// How files on disk are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Backend {
    /// By an io_uring; by threads where the system refuses one.
    #[default]
    Auto,
    /// By an io_uring, on Linux, or not at all.
    Uring,
    /// By a few threads that block.
    Threads,
}

impl Backend {
    const NAMES: [(&'static str, Self); 3] = [("auto", Self::Auto), ("uring", Self::Uring), ("threads", Self::Threads)];

    /// What the environment variable [`BACKEND_VARIABLE`] says, or [`Auto`](Self::Auto) if it is not set or empty.
    ///
    /// # Errors
    /// If it is something else.
    pub fn from_environment() -> io::Result<Self> {
        match std::env::var_os(BACKEND_VARIABLE) {
            None => Ok(Self::Auto),
            Some(value) if value.is_empty() => Ok(Self::Auto),
            Some(value) => value.to_string_lossy().parse().map_err(|error| {
                let message = format!("the environment variable {BACKEND_VARIABLE}: {error}");
                io::Error::new(io::ErrorKind::InvalidInput, message)
            }),
        }
    }
}

/// A name that no backend has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no I/O backend `{0}`; there are auto, uring and threads")]
pub struct UnknownBackend(String);

impl FromStr for Backend {
    type Err = UnknownBackend;

    fn from_str(name: &str) -> Result<Self, UnknownBackend> {
        let known = Self::NAMES.into_iter().find(|(known, _)| *known == name);
        known
            .map(|(_, backend)| backend)
            .ok_or_else(|| UnknownBackend(name.to_owned()))
    }
}

impl fmt::Display for Backend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Self::NAMES.into_iter().find(|(_, backend)| backend == self);
        f.pad(name.map_or("", |(name, _)| name))
    }
}

/// Opens a file on disk to read it. [`ReadAt::backend`] and [`ReadAt::note`] tell what became of the choice.
///
/// # Errors
/// What the system says of the file; and if [`Backend::Uring`] is asked for and refused, that.
pub fn open(path: &Path, backend: Backend) -> io::Result<Arc<dyn ReadAt>> {
    if backend == Backend::Threads {
        return Ok(Arc::new(ThreadsFile::open(path)?.for_tiles()));
    }
    match open_on_ring(path) {
        Ok(file) => file,
        Err(error) if backend == Backend::Uring => {
            let message = format!("the system refuses an io_uring: {error}; backends threads and auto do without");
            Err(io::Error::new(error.kind(), message))
        }
        Err(error) => {
            static TOLD: Once = Once::new();
            TOLD.call_once(|| tracing::warn!(%error, "the system refuses an io_uring; threads do the I/O"));
            Ok(Arc::new(FallenBack {
                file: ThreadsFile::open(path)?.for_tiles(),
                note: format!("the system refuses an io_uring: {error}"),
            }))
        }
    }
}

/// The outer error is that of the ring, the inner one that of the file.
#[cfg(target_os = "linux")]
fn open_on_ring(path: &Path) -> io::Result<io::Result<Arc<dyn ReadAt>>> {
    let ring = crate::io::uring::ring::Ring::shared()?;
    Ok(crate::io::uring::UringFile::open_on(ring, path).map(|file| Arc::new(file) as Arc<dyn ReadAt>))
}

#[cfg(not(target_os = "linux"))]
fn open_on_ring(_: &Path) -> io::Result<io::Result<Arc<dyn ReadAt>>> {
    Err(io::Error::new(io::ErrorKind::Unsupported, "only Linux has it"))
}

/// A file that is read by threads since there is no ring, and why.
struct FallenBack {
    file: ThreadsFile,
    note: String,
}

impl ReadAt for FallenBack {
    fn length(&self) -> u64 {
        self.file.length()
    }

    fn backend(&self) -> &'static str {
        self.file.backend()
    }

    fn note(&self) -> Option<&str> {
        Some(&self.note)
    }

    fn read_at(&self, range: Range<u64>) -> BoxFuture<'static, io::Result<Bytes>> {
        self.file.read_at(range)
    }

    fn rest(&self) {
        self.file.rest();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_back_and_others_are_told() {
        for backend in [Backend::Auto, Backend::Uring, Backend::Threads] {
            assert_eq!(backend.to_string().parse(), Ok(backend));
        }
        let error = "Uring".parse::<Backend>().unwrap_err().to_string();
        assert_eq!(
            error,
            "there is no I/O backend `Uring`; there are auto, uring and threads"
        );
    }

    #[test]
    fn what_is_wrong_with_the_file_is_no_reason_to_fall_back() {
        let folder = tempfile::tempdir().unwrap();
        for backend in [Backend::Auto, Backend::Threads] {
            let error = |path: &Path| open(path, backend).err().map(|error| error.kind());
            assert_eq!(error(&folder.path().join("none")), Some(io::ErrorKind::NotFound));
            assert_eq!(error(folder.path()), Some(io::ErrorKind::IsADirectory));
        }
    }
}
