//! Opens files on disk, which may be in parts.

use std::io;
use std::path::Path;
use std::sync::Arc;

use crate::io::backend::{Backend, open_whole};
use crate::io::file::ReadAt;
use crate::io::parts;
use crate::io::parts::manifest::is_manifest;

/// Opens a file on disk for reading; a file in parts by its manifest, whose name ends with `.parts`.
/// [`ReadAt::backend`] and [`ReadAt::note`] tell which backend reads it and why.
///
/// # Errors
/// Fails with the system's error for the file, and with its refusal of an io_uring if
/// [`Backend::Uring`] is requested.
pub fn open(path: &Path, backend: Backend) -> io::Result<Arc<dyn ReadAt>> {
    match is_manifest(path) {
        true => parts::open(path, backend),
        false => open_whole(path, backend),
    }
}
