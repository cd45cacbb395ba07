//! Puts conquered blocks where a resumed build finds them: their cores into the tile file, their parts of
//! the border log one behind the other, and their results and seams into the journal.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::os::unix::fs::FileExt;
use std::sync::Arc;

use crate::io::blocking;
use crate::pipeline::error::BuildError;
use crate::pipeline::output::border_log::renumber;
use crate::pipeline::records::FinishedBlocks;
use crate::pipeline::resume::journal;
use crate::pipeline::tasks::block_file::BlockFile;
use crate::pipeline::tasks::block_tasks::BlockTasks;
use crate::pipeline::tasks::conquer::TaskOptions;
use crate::pipeline::work_folder::{WorkFolder, open_at};
use crate::store::{Extent, front_end_for};

/// The alignment of the cores of a block.
const ALIGNMENT: u64 = 4096;

impl BlockTasks {
    /// Gathers all blocks but those that were gathered before, and conquers those that are missing.
    pub(crate) async fn gather(&self, finished: &FinishedBlocks, options: TaskOptions) -> Result<(), BuildError> {
        let mut gathering = Gathering::new(self, finished)?;
        for number in finished.blocks..self.blocks() {
            if self.progress().is_cancelled() {
                return Err(BuildError::Cancelled);
            }
            self.conquer(number, options).await?;
            let folder = Arc::clone(&self.folder);
            let added = blocking(move || gathering.add(number, &folder).map(|()| gathering)).await;
            gathering = added.flatten().map_err(self.cannot("gather a block in"))?;
        }
        Ok(())
    }
}

/// The files of a build that goes on from its journal, while blocks come.
struct Gathering {
    tiles: File,
    tiles_length: u64,
    borders: File,
    borders_length: u64,
    journal: File,
    next_number: u64,
    has_z: bool,
}

impl Gathering {
    /// Opens the files behind the blocks that were gathered before.
    fn new(tasks: &BlockTasks, finished: &FinishedBlocks) -> Result<Self, BuildError> {
        let folder = &tasks.folder;
        let expected_tiles = 2 * tasks.plan.points.div_ceil(tasks.options.tile_vertices as u64);
        Ok(Self {
            tiles: open_at(&folder.file(), finished.file_length, "make the file")?,
            tiles_length: finished.file_length.max(front_end_for(expected_tiles)),
            borders: open_at(&folder.borders(), finished.log_length, "make the border log")?,
            borders_length: finished.log_length,
            journal: open_at(&folder.journal(), finished.journal_length, "make the journal")?,
            next_number: finished.next_number,
            has_z: tasks.plan.has_z,
        })
    }

    /// Adds the next block. Its file is removed once the journal has it.
    fn add(&mut self, number: u32, folder: &WorkFolder) -> io::Result<()> {
        let block = BlockFile::open(folder, number)?.ok_or(io::ErrorKind::NotFound)?;
        let mut finished = block.finished.clone();
        let base = self.tiles_length.next_multiple_of(ALIGNMENT);
        (&block.file).rewind()?;
        self.tiles.seek(SeekFrom::Start(base))?;
        let copied = io::copy(&mut (&block.file).take(block.cores_length), &mut self.tiles)?;
        if copied != block.cores_length {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        self.tiles_length = base + copied;
        for core in &mut finished.cores {
            core.offset += base;
        }
        let mut bytes = Vec::new();
        for group in &mut finished.chunks {
            for (kind, chunks) in group.iter_mut().enumerate() {
                for chunk in chunks {
                    bytes.resize(chunk.length as usize, 0);
                    block.read_log(&mut bytes, chunk.offset)?;
                    if crc32c::crc32c(&bytes) != chunk.crc {
                        return Err(io::Error::new(
                            io::ErrorKind::InvalidData,
                            "the border log of a block is damaged",
                        ));
                    }
                    renumber(&mut bytes, kind, self.has_z, self.next_number as u32);
                    self.borders.write_all_at(&bytes, self.borders_length)?;
                    *chunk = Extent::raw(self.borders_length, chunk.length, crc32c::crc32c(&bytes));
                    self.borders_length += u64::from(chunk.length);
                }
            }
        }
        self.next_number += finished.next_number;
        finished.next_number = self.next_number;
        self.tiles.sync_all()?;
        self.borders.sync_all()?;
        self.journal.seek(SeekFrom::End(0))?;
        self.journal.write_all(&journal::encode(&finished, &block.seam))?;
        self.journal.sync_all()?;
        std::fs::remove_file(folder.block(number))
    }
}
