//! Raw pairs of record numbers: little-endian, of 4 or 8 bytes each.

use super::{BATCH, Reader, SegmentBatch};
use crate::input::bytes::ByteInput;
use crate::input::{InputError, Place};
use std::io::{ErrorKind, Read};
use std::path::Path;
use std::sync::Arc;

/// Raw pairs of record numbers.
pub(super) struct Pairs {
    path: Arc<Path>,
    read: Box<dyn Read + Send>,
    /// Bytes of a number.
    bytes: usize,
    offset: u64,
}

impl Pairs {
    pub fn new(input: ByteInput, bytes: usize) -> Self {
        Self {
            path: input.path,
            read: input.read,
            bytes,
            offset: 0,
        }
    }
}

impl Reader for Pairs {
    fn fill(&mut self, _: u64, batch: &mut SegmentBatch) -> Result<bool, InputError> {
        let stride = 2 * self.bytes;
        let mut buffer = vec![0; (BATCH - batch.len()) * stride];
        let mut filled = 0;
        while filled < buffer.len() {
            match self.read.read(&mut buffer[filled..]) {
                Ok(0) => break,
                Ok(n) => filled += n,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(source) => {
                    return Err(InputError::Read {
                        path: self.path.to_path_buf(),
                        offset: self.offset + filled as u64,
                        source,
                    });
                }
            }
        }
        let whole = filled - filled % stride;
        if whole < filled {
            return Err(InputError::Malformed {
                path: self.path.to_path_buf(),
                place: Place::Byte(self.offset + whole as u64),
                problem: format!(
                    "{} bytes are left over behind the last whole pair of {stride} bytes",
                    filled - whole
                ),
                hint: "the file is cut short, or its numbers have another width",
                source: None,
            });
        }
        self.offset += filled as u64;
        let number = |bytes: &[u8]| {
            let mut wide = [0; 8];
            wide[..bytes.len()].copy_from_slice(bytes);
            u64::from_le_bytes(wide)
        };
        let pairs = buffer[..whole].chunks_exact(stride);
        batch
            .records
            .extend(pairs.map(|pair| [number(&pair[..self.bytes]), number(&pair[self.bytes..])]));
        Ok(filled == buffer.len())
    }
}
