//! Records of one length each, one behind the other.

use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, Place};
use std::io::{ErrorKind, Read};
use std::path::Path;

/// A stream of such records.
pub struct Records {
    input: ByteInput,
    /// Bytes of a record.
    pub stride: usize,
    /// Room for the records that are read at once, and kept for that alone.
    buffer: Vec<u8>,
    /// The bytes read so far.
    pub offset: u64,
}

/// Bytes that were read at once.
pub struct Part<'a> {
    /// Where they begin in the stream.
    pub offset: u64,
    /// Whole records.
    pub records: &'a [u8],
    /// What is left over of a last one, at the stream's end.
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

    /// The number of the stream's bytes, if known.
    pub fn size(&self) -> Option<u64> {
        self.input.size
    }

    /// Reads so many records, but for the stream's end. Not `read_to_end`, which cannot know that the buffer is large
    /// enough and takes several reads where one does.
    pub fn read(&mut self, records: usize) -> Result<Part<'_>, InputError> {
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
        Ok(Part {
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

/// The error of `rest` bytes from `offset` on that are no whole record of `stride` bytes.
pub fn left_over(path: &Path, offset: u64, rest: usize, record: &str, stride: usize, hint: &'static str) -> InputError {
    let problem = format!("{rest} bytes are left over behind the last whole {record} of {stride} bytes");
    InputError::malformed(path, Place::Byte(offset), problem, hint)
}
