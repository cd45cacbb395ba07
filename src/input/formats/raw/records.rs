//! Consecutive records of a fixed length.

use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, Location};
use std::io::{ErrorKind, Read};
use std::path::Path;

/// A stream of records of a fixed length.
pub struct Records {
    input: ByteInput,
    /// The length of a record in bytes.
    pub stride: usize,
    /// The buffer for the records that are read at once. It is kept only to be used again.
    buffer: Vec<u8>,
    /// The number of bytes read so far.
    pub offset: u64,
}

/// The bytes of one read.
pub struct Chunk<'a> {
    /// The offset of these bytes in the stream.
    pub offset: u64,
    /// The whole records.
    pub records: &'a [u8],
    /// The bytes of an incomplete last record, at the stream's end.
    pub rest: &'a [u8],
    pub is_last: bool,
}

impl Records {
    pub fn new(input: ByteInput, stride: usize) -> Self {
        Self {
            input,
            stride,
            buffer: Vec::new(),
            offset: 0,
        }
    }

    /// Returns the number of the stream's bytes, if known.
    pub fn size(&self) -> Option<u64> {
        self.input.size
    }

    /// Reads up to `records` records; fewer only at the stream's end. This does not use
    /// `read_to_end`, which cannot know that the buffer is large enough and takes several reads
    /// where one suffices.
    pub fn read(&mut self, records: usize) -> Result<Chunk<'_>, InputError> {
        let wanted = records * self.stride;
        self.buffer.resize(wanted, 0);
        let (offset, mut filled) = (self.offset, 0);
        while filled < wanted {
            match self.input.read.read(&mut self.buffer[filled..]) {
                Ok(0) => break,
                Ok(n) => filled += n,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(source) => return Err(InputError::read(&self.input.path, offset + filled as u64, source)),
            }
        }
        self.offset += filled as u64;
        let (records, rest) = self.buffer[..filled].split_at(filled - filled % self.stride);
        Ok(Chunk {
            offset,
            records,
            rest,
            is_last: filled < wanted,
        })
    }

    pub fn path(&self) -> &Path {
        &self.input.path
    }
}

/// Returns the error of `rest` bytes from `offset` on that are not a whole record of `stride`
/// bytes.
pub fn left_over(path: &Path, offset: u64, rest: usize, record: &str, stride: usize, hint: &'static str) -> InputError {
    let problem = format!("{rest} bytes are left over after the last whole {record} of {stride} bytes");
    InputError::malformed(path, Location::Byte(offset), problem, hint)
}
