//! The backend that reads files on disk, chosen by name, by an environment variable, or by what the
//! system permits.

use std::ops::Range;
use std::path::Path;
use std::str::FromStr;
use std::sync::{Arc, Once};
use std::{fmt, io};

use bytes::Bytes;
use futures::future::BoxFuture;

use crate::io::file::ReadAt;
use crate::io::threads::ThreadsFile;

/// The environment variable that names the backend if the program does not.
pub const BACKEND_VARIABLE: &str = "DELAUNAY_TILES_IO";

/// The method of reading files on disk.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Backend {
    /// An io_uring; threads where the system refuses one.
    #[default]
    Auto,
    /// An io_uring, on Linux only. Opening fails where the system refuses one.
    Uring,
    /// A few threads that block.
    Threads,
}

impl Backend {
    const NAMES: [(&'static str, Self); 3] = [("auto", Self::Auto), ("uring", Self::Uring), ("threads", Self::Threads)];

    /// Returns the backend that the environment variable [`BACKEND_VARIABLE`] names, or
    /// [`Auto`](Self::Auto) if it is not set or empty.
    ///
    /// # Errors
    /// Fails if the variable has any other value.
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

/// The error of a name that no backend has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown I/O backend `{0}`: expected auto, uring or threads")]
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

/// Opens a file on disk for reading, as [`open`](crate::io::open) does, which is not in parts.
pub(super) fn open_whole(path: &Path, backend: Backend) -> io::Result<Arc<dyn ReadAt>> {
    if backend == Backend::Threads {
        return Ok(Arc::new(ThreadsFile::open(path)?.for_tiles()));
    }
    match open_on_ring(path) {
        Ok(file) => file,
        Err(error) if backend == Backend::Uring => {
            let message = format!("the system refuses an io_uring: {error}; the backends threads and auto need none");
            Err(io::Error::new(error.kind(), message))
        }
        Err(error) => {
            static TOLD: Once = Once::new();
            TOLD.call_once(|| tracing::info!(%error, "the system refuses an io_uring; threads do the I/O"));
            Ok(Arc::new(FallenBack {
                file: ThreadsFile::open(path)?.for_tiles(),
                note: format!("the system refuses an io_uring: {error}"),
            }))
        }
    }
}

/// Opens a file on the ring. The outer error is that of the ring, the inner one that of the file.
#[cfg(target_os = "linux")]
fn open_on_ring(path: &Path) -> io::Result<io::Result<Arc<dyn ReadAt>>> {
    let ring = crate::io::uring::ring::Ring::shared()?;
    Ok(crate::io::uring::UringFile::open_on(ring, path).map(|file| Arc::new(file) as Arc<dyn ReadAt>))
}

#[cfg(not(target_os = "linux"))]
fn open_on_ring(_: &Path) -> io::Result<io::Result<Arc<dyn ReadAt>>> {
    Err(io::Error::new(io::ErrorKind::Unsupported, "only Linux has it"))
}

/// A file that threads read because there is no ring, with the reason.
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

    fn lock_shared(&self, number: u64) -> io::Result<()> {
        self.file.lock_shared(number)
    }

    fn rest(&self) {
        self.file.rest();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backend_names_parse_and_others_are_errors() {
        for backend in [Backend::Auto, Backend::Uring, Backend::Threads] {
            assert_eq!(backend.to_string().parse(), Ok(backend));
        }
        let error = "Uring".parse::<Backend>().unwrap_err().to_string();
        assert_eq!(error, "unknown I/O backend `Uring`: expected auto, uring or threads");
    }

    #[test]
    fn a_bad_file_is_an_error_and_no_reason_to_fall_back() {
        let folder = tempfile::tempdir().unwrap();
        for backend in [Backend::Auto, Backend::Threads] {
            let error = |path: &Path| open_whole(path, backend).err().map(|error| error.kind());
            assert_eq!(error(&folder.path().join("none")), Some(io::ErrorKind::NotFound));
            assert_eq!(error(folder.path()), Some(io::ErrorKind::IsADirectory));
        }
    }
}
