//! The journal of finished blocks, from which an interrupted build continues.
//!
//! ```text
//! journal   for each finished block, in order: length u32, CRC-32C u32, block, seam
//! ```
//!
//! A block is written to the journal once its cores and its part of the border log are synced. An
//! entry is either complete or ignored: reading stops at the first invalid entry.

use std::fs::File;
use std::io;
use std::io::Read;
use std::path::Path;

use crate::pipeline::error::BuildError;
use crate::pipeline::records::{BlockState, FinishedBlocks, GroupChunks, Seam};
use crate::pipeline::resume::codec::{Stored, decoded, stored};
use crate::pipeline::work_folder::WorkFolder;
use crate::store::Extent;

/// The results of a finished block.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct FinishedBlock {
    pub(crate) number: u32,
    pub(crate) state: BlockState,
    /// Extents of the cores of its tiles.
    pub(crate) cores: Vec<Extent>,
    /// Extents of its part of the border log.
    pub(crate) chunks: Vec<GroupChunks>,
    /// More than the number of any triangle there.
    pub(crate) next_number: u64,
}

stored! {
    FinishedBlock { number, state, cores, chunks, next_number }
}

/// Returns the bytes of a journal entry.
pub(crate) fn encode(block: &FinishedBlock, seam: &Seam) -> Vec<u8> {
    let mut out = vec![0; 8];
    block.put(&mut out);
    seam.put(&mut out);
    let (length, crc) = (out.len() as u32 - 8, crc32c::crc32c(&out[8..]));
    out[..4].copy_from_slice(&length.to_le_bytes());
    out[4..8].copy_from_slice(&crc.to_le_bytes());
    out
}

/// Returns the block and the seam of a journal entry; `None` if it is damaged.
pub(crate) fn decode(entry: &[u8]) -> Option<(FinishedBlock, Seam)> {
    let (header, body) = entry.split_first_chunk::<8>()?;
    let length = u32::from_le_bytes(*header.first_chunk()?) as usize;
    let is_intact = body.len() == length && header[4..] == crc32c::crc32c(body).to_le_bytes();
    is_intact.then(|| decoded(body)).flatten()
}

/// Reads the entries of a journal, one at a time.
#[derive(Debug)]
pub(crate) struct JournalReader {
    file: File,
    left: u64,
    /// Bytes of the valid entries read so far.
    pub(crate) good: u64,
}

impl JournalReader {
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        let file = File::open(path)?;
        Ok(Self {
            left: file.metadata()?.len(),
            file,
            good: 0,
        })
    }

    /// Reads the next entry. Returns `None` at the end or at an invalid entry.
    pub(crate) fn next(&mut self) -> io::Result<Option<(FinishedBlock, Seam)>> {
        let mut header = [0; 8];
        let Some(left) = self.left.checked_sub(8) else {
            return Ok(None);
        };
        self.file.read_exact(&mut header)?;
        let length = u32::from_le_bytes([header[0], header[1], header[2], header[3]]);
        let Some(left) = left.checked_sub(length.into()) else {
            return Ok(None);
        };
        let mut entry = header.to_vec();
        entry.resize(8 + length as usize, 0);
        self.file.read_exact(&mut entry[8..])?;
        self.left = left;
        let entry = decode(&entry);
        if entry.is_some() {
            self.good += 8 + u64::from(length);
        }
        Ok(entry)
    }
}

impl FinishedBlocks {
    /// Reads the journal. Stops at the first entry that is out of sequence or whose extents reach
    /// beyond the tile file or the border log.
    pub(crate) fn read(folder: &WorkFolder) -> Result<Self, BuildError> {
        let path = folder.journal();
        let cannot = |error| BuildError::io(&path, "read", error);
        let mut this = Self::default();
        let mut reader = match JournalReader::open(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(this),
            opened => opened.map_err(cannot)?,
        };
        let length = |path: &Path| path.metadata().map_or(0, |metadata| metadata.len());
        let (file_length, log_length) = (length(&folder.file()), length(&folder.borders()));
        while let Some((block, seam)) = reader.next().map_err(cannot)? {
            let end_of_cores = block.cores.last().map_or(0, |core| core.range().end);
            let chunks = block.chunks.iter().flatten().flatten();
            let end_of_log = chunks.map(|chunk| chunk.range().end).max().unwrap_or(0);
            if block.number != this.blocks || end_of_cores > file_length || end_of_log > log_length {
                break;
            }
            this.blocks += 1;
            this.points += seam.below + block.state.duplicates;
            this.cores.extend(block.cores);
            this.ends.push(end_of_cores);
            this.file_length = end_of_cores;
            this.log_length = this.log_length.max(end_of_log);
            this.next_number = this.next_number.max(block.next_number);
            this.journal_length = reader.good;
        }
        Ok(this)
    }
}
