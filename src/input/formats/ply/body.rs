//! The part of a PLY file behind its header: lines, or bytes.

use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, Location};
use crate::input::formats::ply::header::{Element, Encoding, Header};
use crate::input::formats::text_lines::Lines;
use std::io;
use std::io::{BufRead, ErrorKind};
use std::path::Path;
use std::sync::Arc;

const CUT_SHORT: &str = "the file is cut short, or its header is wrong";

/// The rows of all elements.
pub struct Body {
    path: Arc<Path>,
    pub content: Content,
}

pub enum Content {
    Lines(Lines),
    Bytes(Bytes),
}

pub struct Bytes {
    read: Box<dyn BufRead + Send>,
    /// The number of bytes read, the header included.
    pub offset: u64,
    /// The number of all bytes, if known.
    pub size: Option<u64>,
    pub encoding: Encoding,
    /// The offset at which the current row begins.
    pub row: u64,
}

/// Reads the header, and returns the elements and what follows. A binary file of a known size must
/// be as long as its header claims.
pub fn open(input: ByteInput) -> Result<(Vec<Element>, Body), InputError> {
    let (path, size) = (Arc::clone(&input.path), input.size);
    let mut lines = Lines::new(input)?;
    let Header { encoding, elements } = Header::read(&mut lines)?;
    if encoding == Encoding::Text {
        let content = Content::Lines(lines);
        return Ok((elements, Body { path, content }));
    }
    let (read, offset) = lines.into_rest();
    let mut bytes = elements.iter().map(Element::least_bytes);
    let end = bytes.try_fold(offset, |sum, bytes| sum.checked_add(bytes?));
    if let Some(size) = size.filter(|size| end.is_none_or(|end| end > *size)) {
        let problem = match end {
            Some(end) => format!("by its header the file has at least {end} bytes; it has {size}"),
            None => format!("by its header the file has more than 2^64 bytes; it has {size}"),
        };
        return Err(InputError::malformed(&path, Location::File, problem, CUT_SHORT));
    }
    let content = Content::Bytes(Bytes {
        read,
        offset,
        size,
        encoding,
        row: offset,
    });
    Ok((elements, Body { path, content }))
}

impl Body {
    /// Returns where the current row is.
    pub fn location(&self) -> Location {
        match &self.content {
            Content::Lines(lines) => Location::Line(lines.row()),
            Content::Bytes(bytes) => Location::Byte(bytes.row),
        }
    }

    /// Returns an error at the current row.
    pub fn malformed(&self, problem: impl Into<String>, hint: &'static str) -> InputError {
        InputError::malformed(&self.path, self.location(), problem, hint)
    }

    /// Returns the error of a file that ends after `read` rows of `element`.
    pub fn ended(&self, element: &Element, read: u64) -> InputError {
        let problem = format!(
            "the file ends after {read} of {} rows of the element `{}`",
            element.rows,
            crate::shown::text(&element.name)
        );
        self.malformed(problem, CUT_SHORT)
    }

    /// Returns the error of a failed read of bytes in row `read` of `element`.
    pub fn failed(&self, error: io::Error, element: &Element, read: u64) -> InputError {
        match (&self.content, error.kind()) {
            (_, ErrorKind::UnexpectedEof) => self.ended(element, read),
            (Content::Bytes(bytes), _) => InputError::read(&self.path, bytes.offset, error),
            (Content::Lines(_), _) => InputError::read(&self.path, 0, error),
        }
    }

    /// Returns a note about what follows the last element, if anything does.
    pub fn rest(&mut self) -> Result<Option<String>, InputError> {
        let rest = match &mut self.content {
            Content::Lines(lines) => match lines.next_row()? {
                true => format!("from line {} on", lines.row()),
                false => return Ok(None),
            },
            Content::Bytes(bytes) => match bytes.size.map_or(0, |size| size.saturating_sub(bytes.offset)) {
                0 => return Ok(None),
                rest => format!("{rest} bytes"),
            },
        };
        let path = crate::shown::path(&self.path);
        Ok(Some(format!(
            "{path}: what follows the last element is not read: {rest}"
        )))
    }
}

impl Bytes {
    pub fn read(&mut self, buffer: &mut [u8]) -> io::Result<()> {
        self.read.read_exact(buffer)?;
        self.offset += buffer.len() as u64;
        Ok(())
    }

    pub fn skip(&mut self, mut count: u64) -> io::Result<()> {
        if self.size.is_some_and(|size| count > size.saturating_sub(self.offset)) {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        while count > 0 {
            let ready = match self.read.fill_buf() {
                Ok([]) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(ready) => count.min(ready.len() as u64),
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(error) => return Err(error),
            };
            self.read.consume(ready as usize);
            self.offset += ready;
            count -= ready;
        }
        Ok(())
    }
}
