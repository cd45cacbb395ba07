//! The way of a tile's bytes to where they are written.

use std::io::{self, Write};
use std::pin::pin;
use std::sync::Arc;

use futures::stream::{self, Stream, StreamExt};

use super::error::{Contradiction, ExportError};
use super::numbering::Numbering;
use super::options::ExportOptions;
use super::part::{Cut, PIECE_BYTES, Part};
use crate::store::{Needs, PassPlan, ReadError, TileId, TileReader, spawn};

/// Bytes that are written at once, at least, but for the last.
const BUFFER: usize = 1 << 20;
/// Pieces of output that wait to be written, beside those that are being made.
const PIECES_AHEAD: usize = 2;

/// Runs what takes long on a thread for such work.
pub(super) async fn blocking<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Result<T, ExportError> {
    Ok(spawn(work).await?)
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
    pub(super) fn new(
        reader: &TileReader,
        options: ExportOptions,
        progress: &'a mut (dyn FnMut(u64, u64) + Send),
    ) -> Self {
        Self {
            numbering: Arc::new(Numbering::new(reader, options)),
            progress,
            done: 0,
            total: 0,
        }
    }

    pub(super) fn reader(&self) -> &TileReader {
        self.numbering.reader()
    }

    /// What a pass needs memory for, if tiles are formatted as they are.
    pub(super) fn needs() -> Needs {
        Needs {
            // Beside those that wait, one is being written, and one is being appended to what was written last. Pieces are
            // made by one thread and dropped by another, so the allocator keeps several times as much.
            fixed: 4 * (PIECES_AHEAD as u64 + 2) * PIECE_BYTES,
            per_thread: PIECE_BYTES,
            per_vertex: 0,
        }
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

    /// Writes what `format` makes of each part of each tile, in order. An error of `format` says what is wrong with the tile.
    pub(super) async fn pass<W, F>(&mut self, output: &mut Output<W>, cut: Cut, format: F) -> Result<(), ExportError>
    where
        W: Write + Send + 'static,
        F: Fn(&Numbering, &Part, &mut Vec<u8>) -> Result<(), Contradiction> + Clone + Send + 'static,
    {
        let plan = self.reader().plan(Self::needs())?;
        let tiles = self.reader().pass(self.reader().tile_ids(), plan);
        let numbering = Arc::clone(&self.numbering);
        let tiles = tiles.map(move |tile| {
            let numbering = Arc::clone(&numbering);
            async move {
                let tile = tile?;
                spawn(move || numbering.cut(&Arc::new(tile), cut, &Arc::default())).await?
            }
        });
        let written = self
            .write_parts(output, tiles.buffered(plan.threads), plan, b"", format)
            .await?;
        match cut {
            Cut::Vertices => Ok(()),
            Cut::Triangles => self.check_triangles(written),
            Cut::Edges => self.check_edges(written),
        }
    }

    /// An error unless as many constraint edges were written as the directory, and so a header, says.
    fn check_edges(&self, written: u64) -> Result<(), ExportError> {
        let expected = self.reader().directory().metadata.constraint_edges;
        if written == expected {
            return Ok(());
        }
        let reason = format!("{written} constraint edges are in tiles, and {expected} by the directory");
        Err(self.reader().damaged(TileId(0), reason).into())
    }

    /// An error unless as many triangles were written as the directory, and so a header, says.
    pub(super) fn check_triangles(&self, written: u64) -> Result<(), ExportError> {
        let expected = self.numbering.triangles();
        if written == expected {
            return Ok(());
        }
        // Tiles have as many triangles as the directory says, so it errs on those in holes.
        let reason = format!("{written} triangles are in no hole, and {expected} by the directory");
        Err(self.reader().damaged(TileId(0), reason).into())
    }

    /// Writes what `format` makes of each part, with a separator between those of which it makes anything. Returns how many
    /// triangles were written.
    pub(super) async fn write_parts<W, F>(
        &mut self,
        output: &mut Output<W>,
        tiles: impl Stream<Item = Result<Vec<Part>, ReadError>> + Unpin,
        plan: PassPlan,
        separator: &[u8],
        format: F,
    ) -> Result<u64, ExportError>
    where
        W: Write + Send + 'static,
        F: Fn(&Numbering, &Part, &mut Vec<u8>) -> Result<(), Contradiction> + Clone + Send + 'static,
    {
        let numbering = Arc::clone(&self.numbering);
        let parts = tiles.flat_map(|parts| match parts {
            Ok(parts) => stream::iter(parts).map(Ok).left_stream(),
            Err(error) => stream::iter([Err(error)]).right_stream(),
        });
        let mut before = 0;
        let pieces = parts.map(|part| {
            let (numbering, format) = (Arc::clone(&numbering), format.clone());
            let piece = part.map(|mut part| {
                part.written_before = before;
                before += u64::from(part.triangles);
                spawn(move || {
                    let mut bytes = Vec::new();
                    let damaged = |fault| numbering.damaged(part.tile.id(), fault);
                    format(&numbering, &part, &mut bytes).map_err(damaged)?;
                    Ok::<_, ReadError>((bytes, part.triangles, part.is_last))
                })
            });
            async move { piece?.await? }
        });
        let mut pieces = pin!(pieces.buffered(plan.threads + PIECES_AHEAD));
        let mut first = true;
        let mut written = 0;
        while let Some(piece) = pieces.next().await {
            let (piece, triangles, ends_tile) = piece?;
            written += u64::from(triangles);
            if !piece.is_empty() {
                if !first && !separator.is_empty() {
                    output.push(separator.to_vec()).await?;
                }
                first = false;
                output.push(piece).await?;
            }
            if ends_tile {
                self.advance();
            }
        }
        Ok(written)
    }
}
