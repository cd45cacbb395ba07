//! Puts conquered blocks where a resumed build finds them: their cores into the tile file, their parts of
//! the border log one behind the other, and their results and seams into the journal. If the file will be
//! in parts, the cores stay where they are, and the tile file gets gaps in their place.

use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::os::unix::fs::FileExt;
use std::sync::Arc;

use crate::io::blocking;
use crate::pipeline::error::BuildError;
use crate::pipeline::output::border_log::renumber;
use crate::pipeline::records::FinishedBlocks;
use crate::pipeline::resume::journal::{self, FinishedBlock};
use crate::pipeline::tasks::block_file::BlockFile;
use crate::pipeline::tasks::block_tasks::BlockTasks;
use crate::pipeline::tasks::conquer::TaskOptions;
use crate::pipeline::work_folder::{WorkFolder, open_at};
use crate::store::Extent;

/// The alignment of the cores of a block.
pub(super) const ALIGNMENT: u64 = 4096;
/// Bytes of blocks that are synced at once.
const MOST_WAITING: u64 = 4 << 30;

impl BlockTasks {
    /// Gathers all blocks but those that were gathered before, and conquers those that are missing or
    /// damaged.
    pub(crate) async fn gather(&self, finished: &FinishedBlocks, options: TaskOptions) -> Result<(), BuildError> {
        let mut gathering = Gathering::new(self, finished)?;
        let mut gathered = Ok(());
        for number in finished.blocks..self.blocks() {
            (gathering, gathered) = self.gather_block(gathering, number, options).await?;
            if gathered.is_err() {
                break;
            }
        }
        // What was gathered before an error stays.
        let entered = blocking(move || gathering.enter()).await;
        gathered.and(entered.flatten().map_err(self.cannot("gather blocks in")))
    }

    async fn gather_block(
        &self,
        mut gathering: Gathering,
        number: u32,
        options: TaskOptions,
    ) -> Result<(Gathering, Result<(), BuildError>), BuildError> {
        let cannot = self.cannot("gather blocks in");
        for _ in 0..2 {
            if self.progress().is_cancelled() {
                return Ok((gathering, Err(BuildError::Cancelled)));
            }
            if let Err(error) = self.conquer(number, options).await {
                return Ok((gathering, Err(error)));
            }
            let added;
            (gathering, added) = blocking(move || {
                let added = gathering.add(number);
                (gathering, added)
            })
            .await
            .map_err(&cannot)?;
            match added {
                Ok(true) => return Ok((gathering, Ok(()))),
                // It is conquered anew.
                Ok(false) => {}
                Err(error) => return Ok((gathering, Err(cannot(error)))),
            }
        }
        let damaged = io::Error::new(
            io::ErrorKind::InvalidData,
            format!("block {number} is damaged each time"),
        );
        Ok((gathering, Err(cannot(damaged))))
    }
}

/// The files of a build that goes on from its journal, while blocks come.
struct Gathering {
    folder: Arc<WorkFolder>,
    /// The id of the tasks.
    id: u64,
    tiles: File,
    tiles_length: u64,
    borders: File,
    borders_length: u64,
    journal: File,
    next_number: u64,
    has_z: bool,
    /// The blocks that the journal does not have yet, their entries, and the bytes of their files.
    blocks: Vec<u32>,
    entries: Vec<u8>,
    waiting_bytes: u64,
}

impl Gathering {
    /// Opens the files behind the blocks that were gathered before.
    fn new(tasks: &BlockTasks, finished: &FinishedBlocks) -> Result<Self, BuildError> {
        let folder = &tasks.folder;
        Ok(Self {
            folder: Arc::clone(folder),
            id: tasks.id,
            tiles: open_at(&folder.file(), finished.file_length, "make the file")?,
            tiles_length: finished.file_length.max(tasks.front_end()),
            borders: open_at(&folder.borders(), finished.log_length, "make the border log")?,
            borders_length: finished.log_length,
            journal: open_at(&folder.journal(), finished.journal_length, "make the journal")?,
            next_number: finished.next_number,
            has_z: tasks.plan.has_z,
            blocks: Vec::new(),
            entries: Vec::new(),
            waiting_bytes: 0,
        })
    }

    /// Adds the next block. Returns `false` if it is not there, or is damaged; then its file is removed.
    fn add(&mut self, number: u32) -> io::Result<bool> {
        let Some(mut block) = BlockFile::open(&self.folder, number, self.id)? else {
            // A task of an earlier build has just put its own there.
            return Ok(false);
        };
        let mut finished = std::mem::take(&mut block.finished);
        let base = self.tiles_length.next_multiple_of(ALIGNMENT);
        let copied = self.take_cores(&block, &mut finished, base).and_then(|end| {
            let log_end = self.copy_log(&block, &mut finished)?;
            Ok([end, log_end])
        });
        let ends = match copied {
            Err(error) if error.kind() == io::ErrorKind::InvalidData => {
                self.folder.remove_block(number)?;
                return Ok(false);
            }
            copied => copied?,
        };
        [self.tiles_length, self.borders_length] = ends;
        self.next_number += finished.next_number;
        finished.next_number = self.next_number;
        self.entries.extend(journal::encode(&finished, &block.seam));
        self.blocks.push(number);
        self.waiting_bytes += block.length();
        if self.waiting_bytes >= MOST_WAITING {
            self.enter()?;
        }
        Ok(true)
    }

    /// Copies the cores of a block to `base`, or leaves a gap for them there. Returns where they end.
    fn take_cores(&self, block: &BlockFile, finished: &mut FinishedBlock, base: u64) -> io::Result<u64> {
        let (mut bytes, end) = (Vec::new(), base + block.cores_length);
        let are_left = self.folder.is_in_parts();
        if are_left {
            self.tiles.set_len(end)?;
        }
        for core in &mut finished.cores {
            if !are_left {
                bytes.resize(core.length as usize, 0);
                block.read_core(&mut bytes, core)?;
                self.tiles.write_all_at(&bytes, base + core.offset)?;
            }
            core.offset += base;
        }
        Ok(end)
    }

    /// Copies the border log of a block behind the others, and numbers its late triangles anew. Returns
    /// where it ends.
    fn copy_log(&self, block: &BlockFile, finished: &mut FinishedBlock) -> io::Result<u64> {
        let (mut bytes, mut end) = (Vec::new(), self.borders_length);
        for group in &mut finished.chunks {
            for (kind, chunks) in group.iter_mut().enumerate() {
                for chunk in chunks {
                    bytes.resize(chunk.length as usize, 0);
                    block.read_log(&mut bytes, chunk)?;
                    renumber(&mut bytes, kind, self.has_z, self.next_number as u32);
                    self.borders.write_all_at(&bytes, end)?;
                    *chunk = Extent::raw(end, chunk.length, crc32c::crc32c(&bytes));
                    end += u64::from(chunk.length);
                }
            }
        }
        Ok(end)
    }

    /// Enters the blocks that wait in the journal, once their bytes are on the medium. Then their files are
    /// removed.
    fn enter(&mut self) -> io::Result<()> {
        if self.blocks.is_empty() {
            return Ok(());
        }
        self.tiles.sync_all()?;
        self.borders.sync_all()?;
        self.journal.seek(SeekFrom::End(0))?;
        self.journal.write_all(&self.entries)?;
        self.journal.sync_all()?;
        (self.entries, self.waiting_bytes) = (Vec::new(), 0);
        let mut blocks = self.blocks.drain(..);
        match self.folder.is_in_parts() {
            // Their cores are needed.
            true => Ok(()),
            false => blocks.try_for_each(|block| self.folder.remove_block(block)),
        }
    }
}
