//! Raw pairs of record numbers: little-endian, of 4 or 8 bytes each.

use super::Reader;
use super::sink::Sink;
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
    pairs: u64,
}

impl Pairs {
    pub fn new(input: ByteInput, bytes: usize) -> Self {
        Self {
            path: input.path,
            read: input.read,
            bytes,
            offset: 0,
            pairs: 0,
        }
    }
}

impl Reader for Pairs {
    fn lines(&self) -> u64 {
        self.pairs
    }

    fn fill(&mut self, sink: &mut Sink<'_>) -> Result<bool, InputError> {
        let stride = 2 * self.bytes;
        let mut buffer = vec![0; sink.room() * stride];
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
        for pair in buffer[..whole].chunks_exact(stride) {
            let (from, to) = pair.split_at(self.bytes);
            sink.pair([number(from), number(to)], self.pairs);
            self.pairs += 1;
        }
        Ok(filled == buffer.len())
    }
}
