//! Bytes in blocks whose lengths the file tells.
//!
//! No length is trusted: where the size of the input is known, a block must fit into the rest of
//! it; elsewhere, as much memory is used as there are bytes. A block has at most [`LONGEST`] bytes.

use crate::input::bytes::{BUFFER, ByteInput};
use crate::input::error::{InputError, Location};
use crate::input::formats::shapes::decoded::LONGEST;
use std::error::Error;
use std::fmt::Display;
use std::io;
use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::path::Path;
use std::sync::Arc;

const DAMAGED: &str = "the file is damaged";
const CUT_SHORT: &str = "the file is cut short, or damaged";

/// An input that is read block by block.
pub struct Blocks {
    read: BufReader<Box<dyn Read + Send>>,
    pub path: Arc<Path>,
    /// The number of bytes read so far.
    pub position: u64,
    size: Option<u64>,
}

impl Blocks {
    pub fn new(input: ByteInput) -> Self {
        Self {
            read: BufReader::with_capacity(BUFFER, input.read),
            path: input.path,
            position: 0,
            size: input.size,
        }
    }

    /// Returns the number of bytes that are left, if it is known.
    pub fn left(&self) -> Option<u64> {
        self.size.map(|size| size.saturating_sub(self.position))
    }

    /// Returns whether there are no more bytes.
    pub fn is_at_end(&mut self) -> Result<bool, InputError> {
        match self.read.fill_buf() {
            Ok(bytes) => Ok(bytes.is_empty()),
            Err(error) => Err(InputError::read(&self.path, self.position, error)),
        }
    }

    /// Appends `length` bytes to `block`; `what` names them in messages.
    pub fn read(&mut self, length: u64, block: &mut Vec<u8>, what: impl Display) -> Result<(), InputError> {
        self.check(length, &what)?;
        if length > LONGEST {
            return Err(self.damaged(format!("{what} has {length} bytes; {LONGEST} is the limit"), None));
        }
        let read = self.read.by_ref().take(length).read_to_end(block);
        self.count(length, read.map(|n| n as u64), what)
    }

    /// Skips `length` bytes.
    #[cfg(feature = "flatgeobuf")]
    pub fn skip(&mut self, length: u64, what: impl Display) -> Result<(), InputError> {
        self.check(length, &what)?;
        let read = io::copy(&mut self.read.by_ref().take(length), &mut io::sink());
        self.count(length, read, what)
    }

    fn check(&self, length: u64, what: &impl Display) -> Result<(), InputError> {
        match self.left() {
            Some(left) if left < length => Err(self.cut_short(format!("{what} has {length} bytes, and {left} follow"))),
            _ => Ok(()),
        }
    }

    fn count(&mut self, length: u64, read: io::Result<u64>, what: impl Display) -> Result<(), InputError> {
        match read {
            Ok(read) if read == length => {
                self.position += length;
                Ok(())
            }
            Ok(read) => Err(self.cut_short(format!("{what} has {length} bytes, and {read} follow"))),
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
                Err(self.cut_short(format!("the file ends within {what}")))
            }
            Err(error) => Err(InputError::read(&self.path, self.position, error)),
        }
    }

    /// Returns the error of a file that ends too early.
    pub fn cut_short(&self, problem: String) -> InputError {
        InputError::malformed(&self.path, Location::Byte(self.position), problem, CUT_SHORT)
    }

    /// Returns the error of a file whose bytes before this position are wrong.
    pub fn damaged(&self, problem: String, source: Option<Box<dyn Error + Send + Sync>>) -> InputError {
        InputError::Malformed {
            path: self.path.to_path_buf(),
            location: Location::Byte(self.position),
            problem,
            hint: DAMAGED,
            source,
        }
    }
}
