//! Lines of text, for the formats that consist of lines.
//!
//! In: a stream of bytes of any kind. Out: rows as byte slices. A row is a line that is neither
//! blank nor a comment; the format may add further lines to a row, for example within quoted
//! fields. A row has at most [`LONGEST`] bytes.

use crate::input::bytes::{BUFFER, ByteInput};
use crate::input::error::{InputError, Location};
use crate::shown::excerpt;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::sync::Arc;

/// The length limit of a row. Rows of numbers stay far below it; binary files without line ends
/// exceed it.
const LONGEST: usize = 1 << 20;

pub struct Lines {
    path: Arc<Path>,
    read: Box<dyn BufRead + Send>,
    /// The last line read, with its line end.
    text: Vec<u8>,
    /// The number of that line, counted from 1.
    line: u64,
    /// The line on which the row begins, and the number of the row's bytes so far.
    row: u64,
    length: usize,
    /// The number of bytes read.
    offset: u64,
}

impl Lines {
    /// Skips a byte order mark.
    pub fn new(mut input: ByteInput) -> Result<Self, InputError> {
        let offset = input.skip_mark();
        let lines = Self::over(
            input.path,
            Box::new(BufReader::with_capacity(BUFFER, input.read)),
            offset,
        );
        if input.head.starts_with(b"\xff\xfe") || input.head.starts_with(b"\xfe\xff") {
            return Err(lines.malformed("this is UTF-16", "convert it to UTF-8"));
        }
        Ok(lines)
    }

    fn over(path: Arc<Path>, read: Box<dyn BufRead + Send>, offset: u64) -> Self {
        Self {
            path,
            read,
            text: Vec::new(),
            line: 0,
            row: 0,
            length: 0,
            offset,
        }
    }

    /// Returns the line, counted from 1, on which the current row begins.
    #[inline]
    pub fn row(&self) -> u64 {
        self.row
    }

    /// Returns the current row as text for a message, for formats whose rows have one line.
    pub fn excerpt(&self) -> String {
        excerpt(self.text.trim_ascii_end())
    }

    /// Returns an error at the current row.
    pub fn malformed(&self, problem: impl Into<String>, hint: &'static str) -> InputError {
        let location = match self.row {
            0 => Location::File,
            row => Location::Line(row),
        };
        InputError::malformed(&self.path, location, problem, hint)
    }

    /// Returns the bytes behind the last line read, and their offset; for files of which only the
    /// beginning is text.
    pub fn into_rest(self) -> (Box<dyn BufRead + Send>, u64) {
        (self.read, self.offset)
    }

    /// Returns the last line read, with its line end; empty at the end.
    #[inline]
    pub fn text(&self) -> &[u8] {
        &self.text
    }

    /// Reads the next row; returns false at the end.
    #[inline]
    pub fn next_row(&mut self) -> Result<bool, InputError> {
        loop {
            self.row = self.line + 1;
            self.length = 0;
            self.read_line()?;
            if self.text.is_empty() || !is_void(&self.text) {
                return Ok(!self.text.is_empty());
            }
        }
    }

    /// Reads the next line, whatever it contains, as a further line of the row.
    #[inline]
    pub fn read_line(&mut self) -> Result<(), InputError> {
        self.text.clear();
        // Read one byte more than allowed, to detect a row that is too long.
        let most = (LONGEST + 1 - self.length) as u64;
        let read = self.read.by_ref().take(most).read_until(b'\n', &mut self.text);
        self.offset += self.text.len() as u64;
        let n = read.map_err(|source| InputError::read(&self.path, self.offset, source))?;
        self.line += 1;
        self.length += n;
        if self.length > LONGEST {
            return Err(self.malformed(
                format!("a row of more than {LONGEST} bytes"),
                "is this a text file, and is every quoted field closed?",
            ));
        }
        Ok(())
    }
}

#[cfg(feature = "text")]
impl Lines {
    /// Returns the last line read, for changes in location.
    #[inline]
    pub fn text_mut(&mut self) -> &mut [u8] {
        &mut self.text
    }

    /// Reads ahead: returns the lines from the next row on, slightly more than 64 KiB or all that
    /// are left. They will be read again.
    pub fn sample(&mut self) -> Result<Block, InputError> {
        const ENOUGH: usize = 64 << 10;
        self.next_row()?;
        let (line, offset) = (self.row - 1, self.offset - self.text.len() as u64);
        let mut text = Vec::new();
        while !self.text.is_empty() && text.len() < ENOUGH {
            text.append(&mut self.text);
            self.row = self.line + 1;
            self.length = 0;
            self.read_line()?;
        }
        text.append(&mut self.text);
        let block = Block {
            path: self.path.clone(),
            text: text.into(),
            line,
        };
        self.put_back(&block, offset);
        Ok(block)
    }

    /// Returns the next lines, about 256 KiB, each of which is a row or void. Returns `None`, and
    /// reads nothing, if fewer are left or if there is a quote or a very long line among them.
    pub fn block(&mut self) -> Result<Option<Block>, InputError> {
        let (offset, mut text) = (self.offset, Vec::with_capacity(2 * BUFFER));
        let is_whole = loop {
            let read = match self.read.fill_buf() {
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => continue,
                read => read.map_err(|source| InputError::read(&self.path, self.offset, source))?,
            };
            let is_enough = text.len() + read.len() >= BUFFER;
            let end = read.iter().rposition(|&byte| byte == b'\n').filter(|_| is_enough);
            let taken = end.map_or(read.len(), |end| end + 1);
            text.extend_from_slice(&read[..taken]);
            self.read.consume(taken);
            self.offset += taken as u64;
            if end.is_some() || taken == 0 || text.len() > LONGEST {
                // In a block of at most this size, no line is too long.
                break end.is_some() && text.len() <= LONGEST;
            }
        };
        let block = Block {
            path: self.path.clone(),
            line: self.line,
            text: text.into(),
        };
        if !is_whole || block.text.contains(&b'"') {
            self.put_back(&block, offset);
            return Ok(None);
        }
        self.line += block.text.iter().filter(|&&byte| byte == b'\n').count() as u64;
        Ok(Some(block))
    }

    /// Puts lines back, which begin at this offset.
    fn put_back(&mut self, block: &Block, offset: u64) {
        let rest = std::mem::replace(&mut self.read, Box::new(std::io::empty()));
        self.read = Box::new(std::io::Cursor::new(block.text.clone()).chain(rest));
        (self.line, self.offset) = (block.line, offset);
    }
}

/// Lines that were read ahead.
#[cfg(feature = "text")]
pub struct Block {
    path: Arc<Path>,
    text: bytes::Bytes,
    /// The number of lines before these.
    line: u64,
}

#[cfg(feature = "text")]
impl Block {
    pub fn lines(&self) -> Lines {
        let text = Box::new(std::io::Cursor::new(self.text.clone()));
        Lines {
            line: self.line,
            ..Lines::over(self.path.clone(), text, 0)
        }
    }
}

/// Returns whether a line is blank or a comment.
#[inline]
fn is_void(line: &[u8]) -> bool {
    match line.first() {
        Some(b'#') | None => true,
        Some(b' ' | b'\t' | b'\r' | b'\n') => matches!(line.trim_ascii_start().first(), Some(b'#') | None),
        Some(_) => false,
    }
}

/// Parses a field as a number; `nan` and `inf` are numbers too.
#[inline]
pub fn number(field: &[u8]) -> Option<f64> {
    std::str::from_utf8(field).ok()?.parse().ok()
}
