//! The output of a task: two files with all that a build needs of a block.
//!
//! ```text
//! cores-N    the cores of its tiles, as they are in the tile file
//! block-N    log        its part of the border log
//!            entry      its results and its seam, as in the journal; extents count from the start of cores and log
//!            lengths    of cores, log and entry, u64 each
//!            id         of the tasks, u64
//!            magic      8 bytes
//! ```
//!
//! The second file gets its name when the first one has it, and so says that both are complete.
//!
//! A task of an earlier build may end while another one of this name is under way. Its output has another
//! id, and counts for nothing.

use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::os::unix::fs::FileExt;
use std::sync::Arc;

use tempfile::NamedTempFile;

use crate::io::ThreadsFile;
use crate::pipeline::records::Seam;
use crate::pipeline::resume::codec::decoded;
use crate::pipeline::resume::journal::{self, FinishedBlock};
use crate::pipeline::work_folder::WorkFolder;
use crate::store::Extent;

const MAGIC: &[u8; 8] = b"dtblok02";
const FOOTER: u64 = 40;

/// A block that a task conquered.
#[derive(Debug)]
pub(crate) struct BlockFile {
    file: File,
    /// The cores; `None` if they are not in the folder.
    cores: Option<File>,
    pub(crate) finished: FinishedBlock,
    pub(crate) seam: Seam,
    pub(crate) cores_length: u64,
    log_length: u64,
}

impl BlockFile {
    /// Opens the file of a block of the tasks `id`. Returns `None` if there is none, or if it is damaged.
    pub(crate) fn open(folder: &WorkFolder, block: u32, id: u64) -> io::Result<Option<Self>> {
        let file = match File::open(folder.block(block)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            opened => opened?,
        };
        let Some([cores_length, log_length, entry]) = lengths(&file, id)? else {
            return Ok(None);
        };
        let cores = match File::open(folder.cores_of(block)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            opened => Some(opened?),
        };
        let are_there = match &cores {
            Some(cores) => cores.metadata()?.len() == cores_length,
            None => folder.has_cores_elsewhere(),
        };
        if !are_there {
            return Ok(None);
        }
        let mut bytes = vec![0; entry as usize];
        file.read_exact_at(&mut bytes, log_length)?;
        let decoded = journal::decode(&bytes);
        Ok(decoded.map(|(finished, seam)| Self {
            file,
            cores,
            finished,
            seam,
            cores_length,
            log_length,
        }))
    }

    /// Returns whether there is a file of a block of the tasks `id`.
    pub(crate) fn is_of(folder: &WorkFolder, block: u32, id: u64) -> bool {
        let file = File::open(folder.block(block));
        file.is_ok_and(|file| lengths(&file, id).is_ok_and(|lengths| lengths.is_some()))
    }

    /// Returns the bytes of both files.
    pub(crate) fn length(&self) -> u64 {
        self.cores_length + self.file.metadata().map_or(0, |metadata| metadata.len())
    }

    /// Reads the bytes of a core.
    ///
    /// # Errors
    /// Fails with [`io::ErrorKind::InvalidData`] if there are no such bytes, or others.
    pub(crate) fn read_core(&self, bytes: &mut [u8], core: &Extent) -> io::Result<()> {
        let cores = self.cores.as_ref().ok_or(io::ErrorKind::InvalidData)?;
        read(cores, bytes, core, self.cores_length)
    }

    /// Reads the bytes of a chunk of the border log; fails as [`read_core`](Self::read_core).
    pub(crate) fn read_log(&self, bytes: &mut [u8], chunk: &Extent) -> io::Result<()> {
        read(&self.file, bytes, chunk, self.log_length)
    }
}

/// Reads an extent, which must end before `end`.
fn read(file: &File, bytes: &mut [u8], extent: &Extent, end: u64) -> io::Result<()> {
    if extent.range().end > end {
        return Err(io::ErrorKind::InvalidData.into());
    }
    file.read_exact_at(bytes, extent.offset)?;
    match crc32c::crc32c(bytes) == extent.crc {
        true => Ok(()),
        false => Err(io::ErrorKind::InvalidData.into()),
    }
}

/// Returns the lengths of cores, log and entry; `None` if it is no complete block of the tasks `id`.
fn lengths(file: &File, id: u64) -> io::Result<Option<[u64; 3]>> {
    let Some(at) = file.metadata()?.len().checked_sub(FOOTER) else {
        return Ok(None);
    };
    let mut footer = [0; FOOTER as usize];
    file.read_exact_at(&mut footer, at)?;
    let (footer, magic) = footer.split_at(FOOTER as usize - MAGIC.len());
    let Some([cores, log, entry, of]) = decoded::<[u64; 4]>(footer) else {
        return Ok(None);
    };
    let is_whole = magic == MAGIC && of == id && log.checked_add(entry) == Some(at);
    Ok(is_whole.then_some([cores, log, entry]))
}

/// The files of a block while its task is in progress. They are removed on drop, unless it is finished.
pub(crate) struct UnfinishedBlockFile {
    cores: NamedTempFile,
    file: NamedTempFile,
}

impl UnfinishedBlockFile {
    pub(crate) fn create(folder: &WorkFolder, block: u32) -> io::Result<Self> {
        Ok(Self {
            cores: WorkFolder::replace(&folder.cores_of(block))?,
            file: WorkFolder::replace(&folder.block(block))?,
        })
    }

    /// Returns the file for cores, from its start on.
    pub(crate) fn cores(&self) -> io::Result<ThreadsFile> {
        Ok(ThreadsFile::from(Arc::new(self.cores.as_file().try_clone()?)))
    }

    /// Returns the file for the border log, from its start on.
    pub(crate) fn log(&self) -> io::Result<File> {
        self.file.as_file().try_clone()
    }

    /// Completes the files, and gives them their names. Others of the same block, which have the same
    /// content, are replaced. Whoever gathers the block checks all bytes that are copied, and what a power
    /// cut took is conquered anew; so only cores that stay in their file are synced.
    pub(crate) fn finish(self, folder: &WorkFolder, finished: &FinishedBlock, seam: &Seam, id: u64) -> io::Result<()> {
        let Self { cores, mut file } = self;
        let (cores_length, log) = (cores.as_file().metadata()?.len(), file.seek(SeekFrom::End(0))?);
        if folder.is_in_parts() {
            cores.as_file().sync_all()?;
        }
        let entry = journal::encode(finished, seam);
        let footer = [cores_length, log, entry.len() as u64, id].map(u64::to_le_bytes);
        file.write_all(&entry)?;
        file.write_all(footer.as_flattened())?;
        file.write_all(MAGIC)?;
        cores.persist(folder.cores_of(finished.number))?;
        file.persist(folder.block(finished.number))?;
        Ok(())
    }
}
