//! The way of a tile's bytes to where they are written.

use std::io::{self, Write};
use std::sync::Arc;

use futures::stream::{Stream, StreamExt};

use super::ExportError;
use super::numbering::Numbering;
use crate::store::{Tile, TileReader};

/// Bytes that are written at once, if tiles are small.
const BUFFER: usize = 1 << 20;

/// Runs what takes long on a thread for blocking work.
pub(super) async fn blocking<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Result<T, ExportError> {
    match tokio::task::spawn_blocking(work).await {
        Ok(done) => Ok(done),
        Err(error) => match error.try_into_panic() {
            Ok(panic) => std::panic::resume_unwind(panic),
            Err(_) => Err(ExportError::Cancelled),
        },
    }
}

/// One output and what it is about to get.
pub(super) struct Output<W> {
    /// None while a thread writes to it.
    writer: Option<W>,
    suffix: &'static str,
    buffer: Vec<u8>,
    bytes: u64,
}

impl<W: Write + Send + 'static> Output<W> {
    pub(super) fn new(writer: W, suffix: &'static str) -> Self {
        Self {
            writer: Some(writer),
            suffix,
            buffer: Vec::new(),
            bytes: 0,
        }
    }

    /// Takes bytes.
    pub(super) async fn push(&mut self, bytes: Vec<u8>) -> Result<(), ExportError> {
        if self.buffer.is_empty() {
            self.buffer = bytes;
        } else {
            self.buffer.extend_from_slice(&bytes);
        }
        if self.buffer.len() < BUFFER {
            return Ok(());
        }
        let bytes = std::mem::take(&mut self.buffer);
        self.write(move |writer| writer.write_all(&bytes).map(|()| bytes.len()))
            .await
    }

    /// Writes the rest. Returns the output and the bytes that it got.
    pub(super) async fn finish(mut self) -> Result<(W, u64), ExportError> {
        let bytes = std::mem::take(&mut self.buffer);
        self.write(move |writer| {
            writer.write_all(&bytes)?;
            writer.flush()?;
            Ok(bytes.len())
        })
        .await?;
        Ok((self.writer.expect("it came back from writing"), self.bytes))
    }

    /// Lends the output to a thread for blocking work.
    async fn write(
        &mut self,
        write: impl FnOnce(&mut W) -> io::Result<usize> + Send + 'static,
    ) -> Result<(), ExportError> {
        let mut writer = self.writer.take().expect("it came back from writing");
        let (writer, written) = blocking(move || {
            let written = write(&mut writer);
            (writer, written)
        })
        .await?;
        self.writer = Some(writer);
        let suffix = self.suffix;
        self.bytes += written.map_err(|source| ExportError::Write { suffix, source })? as u64;
        Ok(())
    }
}

/// An export under way.
pub(super) struct Job<'a> {
    pub(super) numbering: Arc<Numbering>,
    progress: &'a mut (dyn FnMut(u64, u64) + Send),
    done: u64,
    total: u64,
}

impl<'a> Job<'a> {
    pub(super) fn new(reader: &TileReader, progress: &'a mut (dyn FnMut(u64, u64) + Send)) -> Self {
        Self {
            numbering: Arc::new(Numbering::new(reader)),
            progress,
            done: 0,
            total: 0,
        }
    }

    pub(super) fn reader(&self) -> &TileReader {
        self.numbering.reader()
    }

    /// Announces so many passes over all tiles.
    pub(super) fn passes(&mut self, passes: u64) {
        self.total = passes * self.reader().directory().tiles.len() as u64;
    }

    /// Notes that a tile is done.
    pub(super) fn advance(&mut self) {
        self.done += 1;
        (self.progress)(self.done, self.total);
    }

    /// Writes what `format` makes of each tile, in order. An error of `format` says what is wrong with the tile.
    pub(super) async fn pass<W, F>(&mut self, output: &mut Output<W>, format: F) -> Result<(), ExportError>
    where
        W: Write + Send + 'static,
        F: Fn(&Numbering, &Tile, &mut Vec<u8>) -> Result<(), String> + Clone + Send + 'static,
    {
        let numbering = Arc::clone(&self.numbering);
        let pieces = self.reader().for_each_tile(move |tile| {
            let mut bytes = Vec::new();
            let formatted = format(&numbering, tile, &mut bytes);
            let damaged = |reason| ExportError::Read(numbering.reader().damaged(tile.id(), reason));
            formatted.map(|()| bytes).map_err(damaged)
        });
        let pieces = pieces.map(|piece| piece.map_err(ExportError::Read).flatten());
        self.write_all(output, pieces, b"").await
    }

    /// Writes a piece for each tile, with a separator between those that are not empty.
    pub(super) async fn write_all<W: Write + Send + 'static>(
        &mut self,
        output: &mut Output<W>,
        mut pieces: impl Stream<Item = Result<Vec<u8>, ExportError>> + Unpin,
        separator: &[u8],
    ) -> Result<(), ExportError> {
        let mut first = true;
        while let Some(piece) = pieces.next().await {
            let piece = piece?;
            if !piece.is_empty() {
                if !first && !separator.is_empty() {
                    output.push(separator.to_vec()).await?;
                }
                first = false;
                output.push(piece).await?;
            }
            self.advance();
        }
        Ok(())
    }
}
