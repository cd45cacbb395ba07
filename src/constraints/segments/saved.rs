//! All segments of a build in a file, for a build that may be resumed.
//!
//! ```text
//! chunk   length u32, CRC-32C u32, segments
//! ```

use std::fs::File;
use std::io;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::Path;

use crate::constraints::error::ConstraintError;
use crate::constraints::segments::chunk_store::damaged;
use crate::constraints::segments::codec::{SegmentChunk, encode_segments};
use crate::constraints::segments::spool::SegmentSpool;

impl SegmentSpool {
    /// Writes all segments of nonzero length to a file, once all points have arrived, and syncs it.
    /// Returns their number. Errors are those of [`for_each_chunk`](Self::for_each_chunk), and
    /// those of the file.
    pub(crate) fn save(&mut self, path: &Path) -> Result<u64, ConstraintError> {
        let cannot = |error| ConstraintError::io(path, "write", error);
        let mut file = BufWriter::new(File::create(path).map_err(cannot)?);
        let (mut bytes, mut count) = (Vec::new(), 0);
        self.for_each_chunk(|segments| {
            count += segments.len() as u64;
            encode_segments(segments, &[], &mut bytes);
            let header = [bytes.len() as u32, crc32c::crc32c(&bytes)].map(u32::to_le_bytes);
            let written = file.write_all(header.as_flattened());
            written.and_then(|()| file.write_all(&bytes)).map_err(cannot)
        })?;
        let file = file.into_inner().map_err(|error| cannot(error.into_error()))?;
        file.sync_all().map_err(cannot)?;
        Ok(count)
    }

    /// Adds the `count` segments that were [saved](Self::save) to a file.
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
