//! The output of a task: a file with all that a build needs of a block.
//!
//! ```text
//! cores      of its tiles, as they are in the tile file
//! log        its part of the border log
//! entry      its results and its seam, as in the journal; extents count from the start of cores and log
//! lengths    of the three, u64 each
//! id         of the tasks, u64
//! magic      8 bytes
//! ```
//!
//! A task of an earlier build may end while another one of this name is under way. Its output has another
//! id, and counts for nothing.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::os::unix::fs::FileExt;

use tempfile::NamedTempFile;

use crate::io::ThreadsFile;
use crate::pipeline::records::Seam;
use crate::pipeline::resume::codec::decoded;
use crate::pipeline::resume::journal::{self, FinishedBlock};
use crate::pipeline::work_folder::WorkFolder;
use crate::store::Extent;

const MAGIC: &[u8; 8] = b"dtblok01";
const FOOTER: u64 = 40;

/// A block that a task conquered.
#[derive(Debug)]
pub(crate) struct BlockFile {
    file: File,
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
        let Some([cores, log, entry]) = lengths(&file, id)? else {
            return Ok(None);
        };
        let mut bytes = vec![0; entry as usize];
        file.read_exact_at(&mut bytes, cores + log)?;
        let decoded = journal::decode(&bytes);
        Ok(decoded.map(|(finished, seam)| Self {
            file,
            finished,
            seam,
            cores_length: cores,
            log_length: log,
        }))
    }

    /// Returns whether there is a file of a block of the tasks `id`.
    pub(crate) fn is_of(folder: &WorkFolder, block: u32, id: u64) -> bool {
        let file = File::open(folder.block(block));
        file.is_ok_and(|file| lengths(&file, id).is_ok_and(|lengths| lengths.is_some()))
    }

    /// Returns the bytes of the file.
    pub(crate) fn length(&self) -> u64 {
        self.file.metadata().map_or(0, |metadata| metadata.len())
    }

    /// Reads the bytes of a core.
    ///
    /// # Errors
    /// Fails with [`io::ErrorKind::InvalidData`] if there are no such bytes, or others.
    pub(crate) fn read_core(&self, bytes: &mut [u8], core: &Extent) -> io::Result<()> {
        self.read(bytes, core, 0..self.cores_length)
    }

    /// Reads the bytes of a chunk of the border log; fails as [`read_core`](Self::read_core).
    pub(crate) fn read_log(&self, bytes: &mut [u8], chunk: &Extent) -> io::Result<()> {
        self.read(bytes, chunk, self.cores_length..self.cores_length + self.log_length)
    }

    /// Reads an extent, which counts from the start of a part of the file.
    fn read(&self, bytes: &mut [u8], extent: &Extent, part: Range<u64>) -> io::Result<()> {
        let end = part.start.saturating_add(extent.range().end);
        if end > part.end {
            return Err(io::ErrorKind::InvalidData.into());
        }
        self.file.read_exact_at(bytes, part.start + extent.offset)?;
        match crc32c::crc32c(bytes) == extent.crc {
            true => Ok(()),
            false => Err(io::ErrorKind::InvalidData.into()),
        }
    }
}

/// Returns the lengths of the parts of a file; `None` if it is no complete block of the tasks `id`.
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
    let sum = cores.checked_add(log).and_then(|before| before.checked_add(entry));
    let is_whole = magic == MAGIC && of == id && sum == Some(at);
    Ok(is_whole.then_some([cores, log, entry]))
}

/// The file of a block while its task is in progress. It is removed on drop, unless it is finished.
pub(crate) struct UnfinishedBlockFile {
    file: NamedTempFile,
    /// The border log, without a name.
    log: File,
}

impl UnfinishedBlockFile {
    pub(crate) fn create(folder: &WorkFolder, block: u32) -> io::Result<Self> {
        Ok(Self {
            file: WorkFolder::replace(&folder.block(block))?,
            log: tempfile::tempfile_in(folder.spill())?,
        })
    }

    /// Returns the file for cores, from its start on.
    pub(crate) fn cores(&self) -> io::Result<ThreadsFile> {
        Ok(ThreadsFile::from(std::sync::Arc::new(self.file.as_file().try_clone()?)))
    }

    /// Returns the file for the border log.
    pub(crate) fn log(&self) -> io::Result<File> {
        self.log.try_clone()
    }

    /// Completes the file, and gives it its name. Another one of the same block, which has the same
    /// content, is replaced. Nothing is synced: whoever gathers the block checks all its bytes, and what a
    /// power cut took is conquered anew.
    pub(crate) fn finish(self, folder: &WorkFolder, finished: &FinishedBlock, seam: &Seam, id: u64) -> io::Result<()> {
        let Self { mut file, mut log } = self;
        let cores = file.seek(SeekFrom::End(0))?;
        log.rewind()?;
        let copied = io::copy(&mut Read::by_ref(&mut log), file.as_file_mut())?;
        let entry = journal::encode(finished, seam);
        let footer = [cores, copied, entry.len() as u64, id].map(u64::to_le_bytes);
        file.seek(SeekFrom::End(0))?;
        file.write_all(&entry)?;
        file.write_all(footer.as_flattened())?;
        file.write_all(MAGIC)?;
        file.persist(folder.block(finished.number))?;
        Ok(())
    }
}
