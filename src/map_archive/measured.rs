//! An output that tells how long it is.

use std::io::{self, Seek, SeekFrom, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// An output of which the last byte written is known after it was given away.
pub(super) struct Measured<W> {
    output: W,
    at: u64,
    length: Arc<AtomicU64>,
}

impl<W: Seek> Measured<W> {
    /// Creates an output, and the place where its length will be. Fails if the output is a pipe.
    pub(super) fn new(mut output: W) -> io::Result<(Self, Arc<AtomicU64>)> {
        let length = Arc::default();
        let at = output.stream_position()?;
        let this = Self {
            output,
            at,
            length: Arc::clone(&length),
        };
        Ok((this, length))
    }
}

impl<W: Write> Write for Measured<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.output.write(bytes)?;
        self.at += written as u64;
        self.length.fetch_max(self.at, Ordering::Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.output.flush()
    }
}

impl<W: Seek> Seek for Measured<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.at = self.output.seek(to)?;
        Ok(self.at)
    }
}
