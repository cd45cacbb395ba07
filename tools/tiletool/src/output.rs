//! Where commands write: files that appear under their name when they are complete, and devices and pipes, which are written as they are.

use std::fs::{self, File, FileType};
use std::io::{self, Write};
use std::os::unix::fs::FileTypeExt;
use std::path::Path;

use delaunay_tiles::io::OutputFile;

/// An output that is written from front to back.
pub struct Output {
    file: File,
    /// None for a device or a pipe.
    unfinished: Option<OutputFile>,
}

impl Output {
    /// Opens an output. A file that has the name stays as it is until [`publish`](Self::publish).
    ///
    /// Fails for a folder or a socket, and if another process is writing the same output.
    pub fn create(path: &Path) -> io::Result<Self> {
        let is_stream = |kind: FileType| kind.is_fifo() || kind.is_char_device() || kind.is_block_device();
        if fs::metadata(path).is_ok_and(|found| is_stream(found.file_type())) {
            let file = File::options().write(true).open(path)?;
            return Ok(Self { file, unfinished: None });
        }
        let unfinished = OutputFile::create(path)?;
        Ok(Self {
            file: unfinished.file().try_clone()?,
            unfinished: Some(unfinished),
        })
    }

    /// What to write to.
    pub fn file(&mut self) -> &mut File {
        &mut self.file
    }

    /// Waits until everything is on the disk: a full disk may show only then.
    pub fn sync(&self) -> io::Result<()> {
        match &self.unfinished {
            Some(unfinished) => unfinished.file().sync_all(),
            None => Ok(()),
        }
    }

    /// Gives the file its name.
    pub fn publish(self) -> io::Result<()> {
        self.unfinished.map_or(Ok(()), OutputFile::publish)
    }
}

/// Writes a whole file, which replaces what has the name. Fails if that is no file.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let output = OutputFile::create(path)?;
    output.file().write_all(bytes)?;
    output.publish()
}
