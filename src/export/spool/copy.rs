//! Copying from a temporary file to an output.

use std::io::{Read, Seek, SeekFrom, Write};
use std::ops::Range;

use super::Spool;
use crate::export::error::ExportError;
use crate::export::output::Output;

/// The number of bytes that are copied at once.
const COPIED: u64 = 1 << 20;

impl Spool {
    /// Copies a part of the file to an output.
    pub(in crate::export) async fn copy<W: Write + Send + 'static>(
        &mut self,
        mut part: Range<u64>,
        output: &mut Output<W>,
    ) -> Result<(), ExportError> {
        while !part.is_empty() {
            let (start, length) = (part.start, (part.end - part.start).min(COPIED));
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
