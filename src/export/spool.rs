//! A temporary file of an export.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::Path;

use super::error::ExportError;
use super::output::{Output, blocking};

/// The number of bytes that are copied at once.
const COPIED: usize = 1 << 20;

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

    /// Copies a part of the file to an output.
    pub(super) async fn copy<W: Write + Send + 'static>(
        &mut self,
        mut part: Range<u64>,
        output: &mut Output<W>,
    ) -> Result<(), ExportError> {
        while !part.is_empty() {
            let length = (part.end - part.start).min(COPIED as u64);
            let start = part.start;
            let bytes = self.with(move |file| {
                let mut bytes = vec![0; length as usize];
                file.seek(SeekFrom::Start(start))?;
                file.read_exact(&mut bytes)?;
                Ok(bytes)
            });
            output.push(bytes.await?).await?;
            part.start += length;
        }
        Ok(())
    }
}
