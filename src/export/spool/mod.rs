//! A temporary file of an export.

#[cfg(any(feature = "flatgeobuf", feature = "geotiff"))]
mod copy;

use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;

use super::error::ExportError;
use super::output::blocking;

/// A file without a name, to which bytes are appended, and of which any are read again.
pub(super) struct Spool {
    /// `None` while a thread uses it.
    file: Option<File>,
    length: u64,
}

impl Spool {
    /// Creates a file in a folder.
    pub(super) async fn create(folder: &Path) -> Result<Self, ExportError> {
        let folder = folder.to_owned();
        let file = blocking(move || tempfile::tempfile_in(folder)).await?;
        Ok(Self {
            file: Some(file.map_err(|source| ExportError::Scratch { source })?),
            length: 0,
        })
    }

    /// Returns the number of bytes.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// Appends bytes.
    pub(super) async fn append(&mut self, bytes: Vec<u8>) -> Result<(), ExportError> {
        let end = self.length;
        self.length += bytes.len() as u64;
        self.with(move |file| {
            file.seek(SeekFrom::Start(end))?;
            file.write_all(&bytes)
        })
        .await
    }

    /// Runs `work` with the file on a thread for blocking work.
    pub(super) async fn with<T: Send + 'static>(
        &mut self,
        work: impl FnOnce(&mut File) -> io::Result<T> + Send + 'static,
    ) -> Result<T, ExportError> {
        let mut file = self.file.take().expect("it came back from its thread");
        let (file, done) = blocking(move || {
            let done = work(&mut file);
            (file, done)
        })
        .await?;
        self.file = Some(file);
        done.map_err(|source| ExportError::Scratch { source })
    }
}
