//! Outputs of commands. A file appears under its name only when it is complete. Devices, pipes and
//! standard output are written directly.

use std::fs::{self, File, FileType};
use std::io::{self, Write};
use std::os::unix::fs::FileTypeExt;
use std::path::Path;

use delaunay_tiles::io::OutputFile;

/// An output that is written sequentially: a file, a device or a pipe.
pub struct StreamOutput {
    file: File,
    /// None for a device or a pipe.
    unfinished: Option<OutputFile>,
}

impl StreamOutput {
    /// Opens an output. An existing file of this name stays unchanged until
    /// [`publish`](Self::publish).
    ///
    /// # Errors
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

    /// Returns the file to write to.
    pub fn file(&mut self) -> &mut File {
        &mut self.file
    }

    /// Flushes the file to the disk. A full disk may show only then.
    pub fn sync(&self) -> io::Result<()> {
        match &self.unfinished {
            Some(unfinished) => unfinished.file().sync_all(),
            None => Ok(()),
        }
    }

    /// Renames the finished file to its final name.
    pub fn publish(self) -> io::Result<()> {
        self.unfinished.map_or(Ok(()), OutputFile::publish)
    }
}

/// Standard output, whose errors say what was being written.
pub struct StandardOutput {
    what: &'static str,
}

impl StandardOutput {
    /// Returns standard output for `what`, such as `the summary`.
    pub const fn of(what: &'static str) -> Self {
        Self { what }
    }

    /// Returns the error with what was being written, and with the same kind.
    fn explained(&self, error: &io::Error) -> io::Error {
        let message = format!("cannot write {} to standard output: {error}", self.what);
        io::Error::new(error.kind(), message)
    }
}

impl Write for StandardOutput {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        io::stdout().write(bytes).map_err(|error| self.explained(&error))
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stdout().flush().map_err(|error| self.explained(&error))
    }
}

/// Writes a whole file, and replaces the file that has the name.
///
/// # Errors
/// Fails if the name belongs to something that is not a file.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let output = OutputFile::create(path)?;
    output.file().write_all(bytes)?;
    output.publish()
}
