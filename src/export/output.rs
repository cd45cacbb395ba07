//! Writing the bytes of tiles to the outputs of an export.

use std::io::{self, Write};
use std::pin::pin;
use std::sync::Arc;

use futures::future::{BoxFuture, FutureExt};
use futures::stream::{self, Stream, StreamExt};

use super::error::{Contradiction, ExportError};
use super::numbering::Numbering;
use super::options::ExportOptions;
use super::tile_part::{CHUNK_BYTES, TilePart};
use super::tiles_done::TilesDone;
use super::what::CutBy;
use crate::store::{Needs, PassPlan, PassReader, ReadError, TileId, spawn};
use crate::terrain::FileSurface;

/// The least number of bytes per write, except the last one.
const BUFFER: usize = 1 << 20;
/// The number of chunks of output that wait to be written, beside those being formatted.
const CHUNKS_AHEAD: usize = 2;

/// Runs long work on a thread for blocking work.
pub(super) async fn blocking<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Result<T, ExportError> {
    Ok(spawn(work).await?)
}

/// What takes the chunks of a pass, in order.
pub(super) trait Sink: Send {
    /// Takes the output of one part, which is not empty.
    fn push(&mut self, chunk: Vec<u8>) -> BoxFuture<'_, Result<(), ExportError>>;
}

impl<W: Write + Send + 'static> Sink for Output<W> {
    fn push(&mut self, chunk: Vec<u8>) -> BoxFuture<'_, Result<(), ExportError>> {
        Self::push(self, chunk).boxed()
    }
}

/// Formats a part of a tile. Passes call it through a pointer, so that they are compiled once and not
/// for each format.
type Format = Arc<dyn Fn(&Numbering, &TilePart, &mut Vec<u8>) -> Result<(), Contradiction> + Send + Sync>;

/// An output, and the bytes waiting to be written to it.
pub(super) struct Output<W> {
    /// `None` while a thread writes to it.
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

    /// Appends bytes.
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

    /// Writes the remaining bytes. Returns the output and the number of bytes that it got.
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

    /// Runs `write` with the output on a thread for blocking work.
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

/// The state of an export.
pub(super) struct ExportJob<'a> {
    pub(super) numbering: Arc<Numbering>,
    /// The numbers of elements that surveys and passes found.
    found: Vec<(CutBy, u64)>,
    /// The number of elements that were written: triangles and edges.
    pub(super) written: Written,
    /// What the user should know about the output.
    pub(super) notes: Vec<String>,
    progress: TilesDone<'a>,
}

impl<'a> ExportJob<'a> {
    /// Prepares an export.
    ///
    /// # Errors
    /// As [`FileSurface::of`].
    pub(super) async fn new(
        reader: PassReader,
        options: ExportOptions,
        progress: &'a mut (dyn FnMut(u64, u64) + Send),
    ) -> Result<Self, ExportError> {
        let mut progress = TilesDone::new(progress, &reader);
        let surface = FileSurface::of(&reader, options.surface, || progress.advance()).await?;
        progress.end_of_surface();
        Ok(Self {
            numbering: Arc::new(Numbering::new(reader, options, surface)),
            found: Vec::new(),
            written: Written::default(),
            notes: Vec::new(),
            progress,
        })
    }

    pub(super) fn reader(&self) -> &PassReader {
        self.numbering.reader()
    }

    /// Returns the memory that a pass needs beside its tiles, if each part is formatted without
    /// further data.
    pub(super) fn needs() -> Needs {
        Needs {
            // Beside the waiting chunks, one chunk is being written, and one is being appended to
            // the last write. Chunks are allocated by one thread and freed by another, so the
            // allocator keeps several times as much.
            fixed: 4 * (CHUNKS_AHEAD as u64 + 2) * CHUNK_BYTES,
            per_thread: CHUNK_BYTES,
            per_vertex: 0,
        }
    }

    /// Adds to the number of passes over all tiles, for the progress.
    pub(super) fn passes(&mut self, passes: u64) {
        self.progress.add(passes * u64::from(self.reader().metadata().tiles));
    }

    /// Reports that a tile is done.
    pub(super) fn advance(&mut self) {
        self.progress.advance();
    }

    /// Returns the number of elements that will be written: the directory's or that of the survey,
    /// without which some are unknown.
    pub(super) fn count(&self, by: CutBy) -> Option<u64> {
        let found = self
            .found
            .iter()
            .find(|&&(what, _)| what == by)
            .map(|&(_, count)| count);
        self.numbering.count(by).or(found)
    }

    /// Takes the number of elements that a survey or a pass found. Fails unless it is the one that is
    /// known, and that a header may say.
    pub(super) fn expect(&mut self, by: CutBy, found: u64) -> Result<(), ExportError> {
        let Some(expected) = self.count(by).filter(|&expected| expected != found) else {
            self.found.push((by, found));
            return Ok(());
        };
        let reason = match by {
            // The number of triangles per tile was checked, so the number of those in holes is wrong.
            CutBy::Triangles => format!("{found} triangles are in no hole, but the directory says {expected}"),
            CutBy::Edges => format!("the tiles have {found} constraint edges, but the directory says {expected}"),
            CutBy::Vertices | CutBy::Points => {
                format!("the tiles have {found} vertices, but the directory says {expected}")
            }
        };
        Err(self.reader().damaged(TileId(0), reason).into())
    }

    /// Writes the output of `format` for each part of each tile, in order. An error of `format` is
    /// reported as damage of the tile.
    pub(super) async fn pass<W, F>(&mut self, output: &mut Output<W>, cut: CutBy, format: F) -> Result<(), ExportError>
    where
        W: Write + Send + 'static,
        F: Fn(&Numbering, &TilePart, &mut Vec<u8>) -> Result<(), Contradiction> + Send + Sync + 'static,
    {
        self.pass_to(output, cut, Self::needs(), format).await
    }

    /// Passes the output of `format` to a sink, as [`pass`](Self::pass) does, with other needs of
    /// memory.
    pub(super) fn pass_to<'b, F>(
        &'b mut self,
        sink: &'b mut dyn Sink,
        cut: CutBy,
        needs: Needs,
        format: F,
    ) -> BoxFuture<'b, Result<(), ExportError>>
    where
        F: Fn(&Numbering, &TilePart, &mut Vec<u8>) -> Result<(), Contradiction> + Send + Sync + 'static,
    {
        self.pass_by(sink, cut, needs, Arc::new(format)).boxed()
    }

    async fn pass_by(
        &mut self,
        sink: &mut dyn Sink,
        cut: CutBy,
        needs: Needs,
        format: Format,
    ) -> Result<(), ExportError> {
        let plan = self.reader().plan(needs.and(self.numbering.surface().needs()))?;
        let tiles = self.reader().pass(self.reader().tile_ids(), plan);
        let numbering = Arc::clone(&self.numbering);
        let tiles = tiles.map(move |tile| {
            let numbering = Arc::clone(&numbering);
            async move {
                let tile = tile?;
                spawn(move || numbering.cut(&Arc::new(tile), cut)).await?
            }
        });
        let written = self
            .write_parts(sink, tiles.buffered(plan.threads), plan, format)
            .await?;
        self.expect(cut, written)?;
        self.written.count(cut, written);
        Ok(())
    }

    /// Passes the output of `format` for each part to the sink. Returns the number of elements
    /// written.
    async fn write_parts(
        &mut self,
        sink: &mut dyn Sink,
        tiles: impl Stream<Item = Result<Vec<TilePart>, ReadError>> + Unpin,
        plan: PassPlan,
        format: Format,
    ) -> Result<u64, ExportError> {
        let numbering = Arc::clone(&self.numbering);
        let parts = tiles.flat_map(|parts| match parts {
            Ok(parts) => stream::iter(parts).map(Ok).left_stream(),
            Err(error) => stream::iter([Err(error)]).right_stream(),
        });
        let mut before = 0;
        let chunks = parts.map(|part| {
            let (numbering, format) = (Arc::clone(&numbering), Arc::clone(&format));
            let chunk = part.map(|mut part| {
                part.written_before = before;
                before += u64::from(part.written);
                spawn(move || {
                    let mut bytes = Vec::new();
                    let damaged = |fault| numbering.damaged(part.tile.id(), fault);
                    format(&numbering, &part, &mut bytes).map_err(damaged)?;
                    Ok::<_, ReadError>((bytes, part.written, part.is_last))
                })
            });
            async move { chunk?.await? }
        });
        let mut chunks = pin!(chunks.buffered(plan.threads + CHUNKS_AHEAD));
        let mut written = 0;
        while let Some(chunk) = chunks.next().await {
            let (chunk, elements, ends_tile) = chunk?;
            written += u64::from(elements);
            if !chunk.is_empty() {
                sink.push(chunk).await?;
            }
            if ends_tile {
                self.advance();
            }
        }
        Ok(written)
    }
}

/// The numbers of elements that were written.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Written {
    pub(super) points: u64,
    pub(super) triangles: u64,
    pub(super) edges: u64,
}

impl Written {
    fn count(&mut self, by: CutBy, written: u64) {
        match by {
            CutBy::Vertices | CutBy::Points => self.points += written,
            CutBy::Triangles => self.triangles += written,
            CutBy::Edges => self.edges += written,
        }
    }
}
