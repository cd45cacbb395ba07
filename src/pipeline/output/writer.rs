//! The writing side of a build: appends extents to the file in the order in which they arrive, and
//! finished blocks to the journal.
//!
//! A block is entered in the journal once its cores are written and both the file and the border
//! log are synced. Without a journal, only the file is synced, at intervals. Syncs run in the
//! background: writing does not wait for them, and they keep the disk busy all the time, so that
//! little is left to sync at the end.

use std::collections::VecDeque;
use std::fs::File;
use std::path::PathBuf;
use std::sync::Arc;
use std::{fs, io};

use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use tracing::Instrument;

use crate::io::{ThreadsFile, WriteAt, blocking};
use crate::pipeline::error::BuildError;
use crate::pipeline::plan::Block;
use crate::pipeline::records::Seam;
use crate::pipeline::resume::journal;
use crate::pipeline::resume::journal::FinishedBlock;
use crate::pipeline::resume::plan::sync_inputs;
use crate::pipeline::work_folder::WorkFolder;
use crate::store::{Directory, Extent, InForce, StoredPart, TablePlace, TileWriter};

/// A message to the writing task.
#[derive(Debug)]
pub(crate) enum ToWrite {
    Core(StoredPart),
    /// The border of the next tile; `None` for a number that no tile has.
    Border(Option<BorderToWrite>),
    /// A block is done, except that some of its cores may still be in the channel.
    Finished(Box<(FinishedBlock, Seam)>),
}

/// A border, and the component table of its tile.
#[derive(Debug)]
pub(crate) struct BorderToWrite {
    pub(crate) border: StoredPart,
    pub(crate) table: Vec<u8>,
}

pub(crate) type Sender = mpsc::Sender<ToWrite>;

/// Bytes of the file between two syncs, if there is no journal.
const SYNC_BYTES: u64 = 32 << 20;

/// The journal, and the files and folder that an entry depends on.
#[derive(Debug)]
pub(crate) struct Journal {
    pub(crate) file: Arc<File>,
    /// Bytes of the entries in the journal.
    pub(crate) length: u64,
    pub(crate) border_log: Arc<File>,
    /// The blocks, whose runs are deleted when they are entered, and their folder, whose lock an
    /// entry keeps until it is done.
    pub(crate) blocks: Arc<Vec<Block>>,
    pub(crate) folder: Arc<WorkFolder>,
}

/// The file that is written.
pub(crate) struct Output {
    writer: TileWriter<ThreadsFile>,
    file: ThreadsFile,
    path: PathBuf,
    cores: Vec<Extent>,
    borders: Vec<(Extent, TablePlace)>,
    journal: Option<Journal>,
    /// Blocks that are done and not in the journal yet, in order.
    finished: VecDeque<(FinishedBlock, Seam)>,
    next_block: u32,
    /// Number of tiles of the blocks that are in the journal or being entered.
    entered_tiles: usize,
    /// The entry or sync in progress.
    background: Option<JoinHandle<io::Result<()>>>,
    /// Bytes of the file at the start of the last sync.
    synced: u64,
    journal_bytes: u64,
}

impl Output {
    /// Continues a file after the cores that are in it. Its cores start at `front_end`.
    pub(crate) fn new(
        file: ThreadsFile,
        path: PathBuf,
        front_end: u64,
        cores: Vec<Extent>,
        journal: Option<Journal>,
        next_block: u32,
    ) -> Self {
        let writer = match cores.last() {
            Some(last) => TileWriter::behind(file.clone(), last.range().end).front_end(front_end),
            None => TileWriter::new(file.clone(), front_end),
        };
        Self {
            writer,
            file,
            path,
            entered_tiles: cores.len(),
            cores,
            borders: Vec::new(),
            journal,
            finished: VecDeque::new(),
            next_block,
            background: None,
            synced: 0,
            journal_bytes: 0,
        }
    }

    /// Writes all extents that arrive.
    pub(crate) async fn write_all(&mut self, mut extents: mpsc::Receiver<ToWrite>) -> Result<(), BuildError> {
        while let Some(extent) = extents.recv().await {
            let span = tracing::trace_span!("write");
            let written = self.take(extent).instrument(span).await;
            written.map_err(|error| BuildError::io(&self.path, "write", error))?;
            // Entries and syncs run one at a time. The next one starts after a later extent.
            if self
                .background
                .as_ref()
                .is_some_and(|background| !background.is_finished())
            {
                continue;
            }
            self.join_background().await?;
            match self.journal {
                Some(_) => self.enter_block().await?,
                None => self.start_sync(),
            }
        }
        self.join_background().await
    }

    async fn take(&mut self, extent: ToWrite) -> io::Result<()> {
        match extent {
            ToWrite::Core(core) => self.cores.push(self.writer.append_core(core).await?),
            ToWrite::Border(None) => self.borders.push((Extent::raw(0, 0, 0), TablePlace::Nowhere)),
            ToWrite::Border(Some(BorderToWrite { border, table })) => {
                // Tables that lie apart lie behind the border, to be read with it.
                let border = self.writer.append_border(border).await?;
                self.borders.push((border, self.writer.place_table(table).await?));
            }
            ToWrite::Finished(block) => {
                let index = self.finished.partition_point(|other| other.0.number < block.0.number);
                self.finished.insert(index, *block);
            }
        }
        Ok(())
    }

    /// Starts a sync if at least `SYNC_BYTES` bytes were written since the last one.
    fn start_sync(&mut self) {
        let length = self.writer.length();
        if length - self.synced >= SYNC_BYTES {
            self.synced = length;
            let file = self.file.clone();
            self.background = Some(tokio::spawn(file.sync_and_release()));
        }
    }

    /// Starts to enter the next block if its cores are written.
    async fn enter_block(&mut self) -> Result<(), BuildError> {
        let next = self
            .finished
            .front()
            .filter(|(block, _)| block.number == self.next_block);
        let Some(end) = next.map(|(block, _)| self.entered_tiles + block.state.tiles.len()) else {
            return Ok(());
        };
        if end > self.cores.len() {
            return Ok(());
        }
        let (Some((mut block, seam)), Some(journal)) = (self.finished.pop_front(), &mut self.journal) else {
            return Ok(());
        };
        self.writer
            .flush()
            .await
            .map_err(|error| BuildError::io(&self.path, "write", error))?;
        block.cores = self.cores[self.entered_tiles..end].to_vec();
        self.entered_tiles = end;
        self.next_block += 1;
        let entry = journal::encode(&block, &seam);
        let (offset, is_first) = (journal.length, journal.length == 0);
        journal.length += entry.len() as u64;
        self.journal_bytes += entry.len() as u64;
        let (tiles, border_log, file) = (
            self.file.clone(),
            ThreadsFile::from(Arc::clone(&journal.border_log)),
            ThreadsFile::from(Arc::clone(&journal.file)),
        );
        let (blocks, folder) = (Arc::clone(&journal.blocks), Arc::clone(&journal.folder));
        let span = tracing::debug_span!("enter", block = block.number);
        let enter = async move {
            if is_first {
                // An entry makes a build go on from it, after a power cut too: so that must find the rest.
                let (blocks, folder) = (Arc::clone(&blocks), Arc::clone(&folder));
                blocking(move || sync_inputs(&folder, &blocks)).await??;
            }
            tiles.sync_and_release().await?;
            border_log.sync().await?;
            file.write_at(offset, entry.into()).await?;
            file.sync().await?;
            // The runs are no longer needed. A run that cannot be deleted is deleted with the
            // folder.
            let removed = blocking(move || {
                for run in &blocks[block.number as usize].runs {
                    let _ = fs::remove_file(run.path(folder.spill()));
                }
            });
            removed.await
        };
        self.background = Some(tokio::spawn(enter.instrument(span)));
        Ok(())
    }

    /// Waits for the entry or sync in progress.
    async fn join_background(&mut self) -> Result<(), BuildError> {
        let Some(background) = self.background.take() else {
            return Ok(());
        };
        let done = background.await.map_err(io::Error::other).and_then(|done| done);
        let what = match self.journal {
            Some(_) => "enter a finished block in the journal beside",
            None => "sync",
        };
        done.map_err(|error| BuildError::io(&self.path, what, error))
    }

    /// Returns the extents of cores, and of borders with the places of the component tables.
    pub(crate) fn extents(&self) -> (&[Extent], &[(Extent, TablePlace)]) {
        (&self.cores, &self.borders)
    }

    /// Returns the bytes written to the journal.
    pub(crate) fn journal_bytes(&self) -> u64 {
        self.journal_bytes
    }

    /// Completes the file, as a new one or in the place of another one. A draft will be edited before
    /// it is published and need not be synced. Returns its length, and the number of bytes that this
    /// added.
    pub(crate) async fn finish(
        self,
        directory: &Directory,
        replaced: Option<&InForce>,
        is_draft: bool,
    ) -> Result<(u64, u64), BuildError> {
        let before = self.writer.length();
        let writer = self.writer.draft(is_draft);
        let finished = match replaced {
            None => writer.finish(directory).await,
            Some(replaced) => writer.finish_next(directory, replaced).await,
        };
        let length = finished.map_err(|error| BuildError::io(&self.path, "finish", error))?;
        Ok((length, length.saturating_sub(before)))
    }
}
