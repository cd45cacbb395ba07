//! Lines of text, for the formats that have lines.
//!
//! In: a stream of bytes of any kind. Out: rows, which are lines that are neither blank nor a comment, as byte slices;
//! the format may add further lines to a row, as quoted fields need it. A row has [`LONGEST`] bytes at most.

use crate::input::bytes::{BUFFER, ByteInput};
use crate::input::error::{InputError, Place};
use crate::shown::excerpt;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::sync::Arc;

/// The longest row. No row of numbers comes near; binary files without line ends do.
const LONGEST: usize = 1 << 20;

pub struct Lines {
    path: Arc<Path>,
    read: Box<dyn BufRead + Send>,
    /// The line read last, with its line end.
    text: Vec<u8>,
    /// Its number, from 1.
    line: u64,
    /// The line on which the row begins, and the row's bytes so far.
    row: u64,
    length: usize,
    /// Bytes read.
    offset: u64,
}

impl Lines {
    /// Passes over a byte order mark.
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

    /// The line on which the row given last begins, from 1.
    #[inline]
    pub fn row(&self) -> u64 {
        self.row
    }

    /// The row given last for a message, of formats that have rows of one line.
    pub fn excerpt(&self) -> String {
        excerpt(self.text.trim_ascii_end())
    }

    /// An error at the row given last.
    pub fn malformed(&self, problem: impl Into<String>, hint: &'static str) -> InputError {
        let place = match self.row {
            0 => Place::File,
            row => Place::Line(row),
        };
        InputError::malformed(&self.path, place, problem, hint)
    }

    /// The line read last, with its line end; empty at the end.
    #[inline]
    pub fn text(&self) -> &[u8] {
        &self.text
    }

    /// Goes to the next row; false at the end.
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

    /// Reads the next line, whatever it has, as a further one of the row.
    #[inline]
    pub fn read_line(&mut self) -> Result<(), InputError> {
        self.text.clear();
        // One byte more than may be, to tell.
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
    /// The line read last, to change.
    #[inline]
    pub fn text_mut(&mut self) -> &mut [u8] {
        &mut self.text
    }

    /// The coming lines from the next row on, 64 KiB and a little more, or all. They come again.
    pub fn sample(&mut self) -> Result<Sample, InputError> {
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
        let text: Arc<[u8]> = text.into();
        let rest = std::mem::replace(&mut self.read, Box::new(std::io::empty()));
        self.read = Box::new(std::io::Cursor::new(text.clone()).chain(rest));
        (self.line, self.offset) = (line, offset);
        Ok(Sample {
            path: self.path.clone(),
            text,
            line,
        })
    }
}

/// Lines that were read ahead.
#[cfg(feature = "text")]
pub struct Sample {
    path: Arc<Path>,
    text: Arc<[u8]>,
    /// The lines before.
    line: u64,
}

#[cfg(feature = "text")]
impl Sample {
    pub fn lines(&self) -> Lines {
        let text = Box::new(std::io::Cursor::new(self.text.clone()));
        Lines {
            line: self.line,
            ..Lines::over(self.path.clone(), text, 0)
        }
    }
}

/// Whether a line has nothing to read: blank, or a comment.
#[inline]
fn is_void(line: &[u8]) -> bool {
    match line.first() {
        Some(b'#') | None => true,
        Some(b' ' | b'\t' | b'\r' | b'\n') => matches!(line.trim_ascii_start().first(), Some(b'#') | None),
        Some(_) => false,
    }
}

/// A field as a number, also `nan` and `inf`.
#[inline]
pub fn number(field: &[u8]) -> Option<f64> {
    std::str::from_utf8(field).ok()?.parse().ok()
}
