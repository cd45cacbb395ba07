//! All segments of a build in a file, for a build that may be resumed.
//!
//! ```text
//! chunk   length u32, CRC-32C u32, segments
//! ```

use std::fs::File;
use std::io;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use crate::constraints::error::ConstraintError;
use crate::constraints::segment::Segment;
use crate::constraints::segments::chunk_store::damaged;
use crate::constraints::segments::codec::{SegmentChunk, encode_segments};
use crate::constraints::segments::spool::SegmentSpool;

/// A file that all segments of a build are written to.
#[derive(Debug)]
pub(super) struct SegmentFile {
    path: PathBuf,
    file: BufWriter<File>,
    count: u64,
    /// A buffer for the bytes of a chunk.
    bytes: Vec<u8>,
}

impl SegmentFile {
    pub(super) fn create(path: &Path) -> Result<Self, ConstraintError> {
        let file = File::create(path).map_err(|error| ConstraintError::io(path, "write", error))?;
        Ok(Self {
            path: path.to_owned(),
            file: BufWriter::new(file),
            count: 0,
            bytes: Vec::new(),
        })
    }

    /// Writes a chunk of segments.
    pub(super) fn push(&mut self, segments: &[Segment]) -> Result<(), ConstraintError> {
        encode_segments(segments, &[], &mut self.bytes);
        let header = [self.bytes.len() as u32, crc32c::crc32c(&self.bytes)].map(u32::to_le_bytes);
        let written = self.file.write_all(header.as_flattened());
        let written = written.and_then(|()| self.file.write_all(&self.bytes));
        self.count += segments.len() as u64;
        written.map_err(|error| ConstraintError::io(&self.path, "write", error))
    }

    /// Syncs the file. Returns the number of segments in it.
    pub(super) fn finish(self) -> Result<u64, ConstraintError> {
        let file = self.file.into_inner().map_err(io::IntoInnerError::into_error);
        let synced = file.and_then(|file| file.sync_all());
        synced.map_err(|error| ConstraintError::io(&self.path, "write", error))?;
        Ok(self.count)
    }
}

impl SegmentSpool {
    /// Adds the `count` segments that were [saved](Self::distribute) to a file.
    ///
    /// # Errors
    /// Fails if they cannot be read, or spilled.
    pub(crate) fn restore(&mut self, path: &Path, count: u64) -> Result<(), ConstraintError> {
        let cannot = |error| ConstraintError::io(path, "read", error);
        let file = File::open(path).map_err(cannot)?;
        let mut left = file.metadata().map_err(cannot)?.len();
        let mut file = BufReader::new(file);
        let (mut bytes, before) = (Vec::new(), self.len());
        while self.len() - before < count {
            read_chunk(&mut file, &mut left, &mut bytes).map_err(cannot)?;
            let chunk = SegmentChunk::decode(&bytes).ok_or_else(|| cannot(damaged("a chunk is not of segments")))?;
            self.push_parts(chunk.segments())?;
        }
        Ok(())
    }
}

/// Reads the next chunk of a file of which `left` bytes were not read yet.
fn read_chunk(file: &mut impl Read, left: &mut u64, bytes: &mut Vec<u8>) -> io::Result<()> {
    let mut header = [[0; 4]; 2];
    file.read_exact(header.as_flattened_mut())?;
    let [length, crc] = header.map(u32::from_le_bytes);
    *left = left.saturating_sub(8);
    if u64::from(length) > *left {
        return Err(damaged("segments are missing"));
    }
    *left -= u64::from(length);
    bytes.resize(length as usize, 0);
    file.read_exact(bytes)?;
    match crc32c::crc32c(bytes) == crc {
        true => Ok(()),
        false => Err(damaged("the checksum of segments is wrong")),
    }
}
