//! Lines of text and the fields in them, for the formats that have lines.
//!
//! In: a stream of bytes of any kind. Out: rows as byte slices without copies, and their fields, trimmed and without
//! quotes. Why not the `csv` crate: fields apart by runs of blanks are as frequent as commas in point files, and it
//! gathers a field whose quotes are never closed in memory, however long; here a row has [`LONGEST`] bytes at most.

use super::bytes::Buffered;
use super::{InputError, Place};
use memchr::memchr;

/// The longest row. No row of numbers comes near; binary files without line ends do.
pub(super) const LONGEST: usize = 1 << 20;

/// What is between the fields of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Delimiter {
    /// This byte, once; blanks around fields do not count.
    #[cfg_attr(not(feature = "text"), allow(dead_code, reason = "other formats have blanks only"))]
    Byte(u8),
    /// Runs of spaces and tabs.
    Blanks,
}

impl Delimiter {
    #[inline]
    fn matches(self, byte: u8) -> bool {
        match self {
            Self::Byte(delimiter) => byte == delimiter,
            Self::Blanks => is_blank(byte),
        }
    }
}

#[inline]
fn is_blank(byte: u8) -> bool {
    byte == b' ' || byte == b'\t'
}

/// The rows of a stream: its lines, but lines within a quoted field belong together.
pub(super) struct Lines {
    bytes: Buffered,
    /// Line ends passed.
    passed: u64,
    /// The line on which the row given last begins, from 1.
    line: u64,
    /// Its bytes, line end included.
    length: usize,
}

impl Lines {
    /// Passes over a byte order mark.
    pub fn new(mut bytes: Buffered) -> Result<Self, InputError> {
        const MARK: &[u8] = b"\xef\xbb\xbf";
        while bytes.data().len() < MARK.len() && bytes.more()? {}
        if bytes.data().starts_with(MARK) {
            bytes.consume(MARK.len());
        }
        let lines = Self {
            bytes,
            passed: 0,
            line: 0,
            length: 0,
        };
        if lines.bytes.data().starts_with(b"\xff\xfe") || lines.bytes.data().starts_with(b"\xfe\xff") {
            return Err(lines.malformed("this is UTF-16".to_owned(), "convert it to UTF-8"));
        }
        Ok(lines)
    }

    /// The line on which the row given last begins, from 1.
    #[inline]
    pub fn line(&self) -> u64 {
        self.line
    }

    /// An error at the row given last.
    pub fn malformed(&self, problem: String, hint: &'static str) -> InputError {
        InputError::Malformed {
            path: self.bytes.path(),
            place: if self.line > 0 {
                Place::Line(self.line)
            } else {
                Place::File
            },
            problem,
            hint,
            source: None,
        }
    }

    /// The next row without its line end; `None` at the end. With a delimiter, quoted fields may contain line ends.
    #[inline]
    pub fn next_row(&mut self, quotes: Option<Delimiter>) -> Result<Option<&[u8]>, InputError> {
        self.line = self.passed + 1;
        // The part up to here is whole lines; no line end is before there.
        let mut scanned = 0;
        let mut searched = 0;
        let mut quoting = Quoting::FieldStart;
        loop {
            let data = self.bytes.data();
            match memchr(b'\n', &data[searched..]) {
                Some(n) => {
                    let end = searched + n;
                    self.passed += 1;
                    if let Some(delimiter) = quotes {
                        quoting = quoting.after_line(&data[..end], scanned, delimiter);
                    }
                    scanned = end + 1;
                    searched = scanned;
                    if quoting == Quoting::Inside && scanned <= LONGEST {
                        continue;
                    }
                    if scanned > LONGEST {
                        return Err(self.too_long());
                    }
                    self.length = scanned;
                    let row = &self.bytes.consume(scanned)[..end];
                    return Ok(Some(row.strip_suffix(b"\r").unwrap_or(row)));
                }
                None if data.len() > LONGEST => return Err(self.too_long()),
                None => {
                    searched = data.len();
                    if self.bytes.more()? {
                        continue;
                    }
                    let rest = self.bytes.data().len();
                    if rest == 0 {
                        return Ok(None);
                    }
                    self.passed += 1;
                    self.length = rest;
                    let row = self.bytes.consume(rest);
                    return Ok(Some(row.strip_suffix(b"\r").unwrap_or(row)));
                }
            }
        }
    }

    fn too_long(&self) -> InputError {
        self.malformed(
            format!("a row of more than {LONGEST} bytes"),
            "is this a text file, and is every quoted field closed?",
        )
    }
}

#[cfg(feature = "text")]
impl Lines {
    /// Takes the row given last back, so that it comes again. Only once, and nothing may be in between.
    pub fn back(&mut self) {
        self.bytes.take_back(self.length);
        self.passed = self.line - 1;
        self.length = 0;
    }

    /// Reads ahead: the coming lines, as far as they are within a window of 64 KiB, but at least one whole.
    pub fn read_ahead(&mut self) -> Result<(), InputError> {
        const WINDOW: usize = 64 << 10;
        while self.bytes.data().len() < WINDOW || memchr(b'\n', self.bytes.data()).is_none() {
            if self.bytes.data().len() > LONGEST {
                return Err(self.too_long());
            }
            if !self.bytes.more()? {
                break;
            }
        }
        Ok(())
    }

    /// The rows at hand that are not void, if this is the delimiter. They are not consumed. The last one may be cut
    /// short.
    pub fn preview(&self, delimiter: Delimiter) -> impl Iterator<Item = &[u8]> {
        let mut rest = self.bytes.data();
        let rows = std::iter::from_fn(move || {
            let mut quoting = Quoting::FieldStart;
            let mut end = 0;
            while end < rest.len() {
                let line = memchr(b'\n', &rest[end..]).map_or(rest.len(), |n| end + n);
                quoting = quoting.after_line(&rest[..line], end, delimiter);
                end = line + 1;
                if quoting != Quoting::Inside {
                    break;
                }
            }
            let row = rest.get(..end.saturating_sub(1)).filter(|_| end > 0)?;
            rest = rest.get(end..).unwrap_or_default();
            Some(row.strip_suffix(b"\r").unwrap_or(row))
        });
        rows.filter(|row| !is_void(row))
    }
}

/// Where in a row with quotes one is (RFC 4180).
#[derive(Clone, Copy, PartialEq, Eq)]
enum Quoting {
    FieldStart,
    Plain,
    Inside,
    /// Behind a quote within quotes: the end, or the first of two that stand for one.
    Quote,
}

impl Quoting {
    /// The state behind a line of `row` that begins at `start`. In comments a quote means nothing.
    #[inline]
    fn after_line(self, row: &[u8], start: usize, delimiter: Delimiter) -> Self {
        let bytes = &row[start..];
        if start == 0 && is_void(row) {
            return Self::Plain;
        }
        if self != Self::Inside && memchr(b'"', bytes).is_none() {
            return Self::Plain;
        }
        bytes.iter().fold(self, |state, &byte| match (state, byte) {
            (Self::FieldStart | Self::Quote, b'"') => Self::Inside,
            (Self::Inside, b'"') => Self::Quote,
            (Self::Inside, _) => Self::Inside,
            _ if delimiter.matches(byte) => Self::FieldStart,
            (Self::FieldStart, b' ' | b'\t') => Self::FieldStart,
            _ => Self::Plain,
        })
    }
}

/// Whether a row has nothing to read: blank, or a comment.
#[inline]
pub(super) fn is_void(row: &[u8]) -> bool {
    match row.first() {
        Some(b'#') | None => true,
        Some(b' ' | b'\t' | b'\r') => matches!(row.trim_ascii_start().first(), Some(b'#') | None),
        Some(_) => false,
    }
}

/// The fields of a row.
pub(super) struct Fields<'a> {
    rest: Option<&'a [u8]>,
    delimiter: Delimiter,
}

impl<'a> Fields<'a> {
    #[inline]
    pub fn new(row: &'a [u8], delimiter: Delimiter) -> Self {
        Self {
            rest: Some(row),
            delimiter,
        }
    }
}

impl<'a> Iterator for Fields<'a> {
    type Item = &'a [u8];

    #[inline]
    fn next(&mut self) -> Option<&'a [u8]> {
        let mut rest = self.rest?;
        while let [first, tail @ ..] = rest
            && is_blank(*first)
            && (self.delimiter == Delimiter::Blanks || !self.delimiter.matches(*first))
        {
            rest = tail;
        }
        if rest.is_empty() && self.delimiter == Delimiter::Blanks {
            self.rest = None;
            return None;
        }
        let (from, inner) = match rest {
            [b'"', quoted @ ..] => {
                let inner = closing_quote(quoted);
                (rest.len().min(inner + 2), Some(&quoted[..inner]))
            }
            _ => (0, None),
        };
        let end = rest[from..].iter().position(|&b| self.delimiter.matches(b));
        let field = match end {
            Some(n) => {
                self.rest = Some(&rest[from + n + 1..]);
                &rest[..from + n]
            }
            None => {
                self.rest = None;
                rest
            }
        };
        Some(match inner {
            Some(inner) => inner.trim_ascii(),
            None if field.last().is_some_and(|&b| is_blank(b)) => field.trim_ascii_end(),
            None => field,
        })
    }
}

/// The position of the quote that ends what is within quotes, or its length if there is none.
fn closing_quote(quoted: &[u8]) -> usize {
    let mut at = 0;
    while let Some(n) = memchr(b'"', &quoted[at..]) {
        if quoted.get(at + n + 1) != Some(&b'"') {
            return at + n;
        }
        at += n + 2;
    }
    quoted.len()
}

/// A field as a number, also `nan` and `inf`.
#[inline]
pub(super) fn number(field: &[u8]) -> Option<f64> {
    std::str::from_utf8(field).ok()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(row: &str, delimiter: Delimiter) -> Vec<&str> {
        Fields::new(row.as_bytes(), delimiter)
            .map(|field| std::str::from_utf8(field).unwrap())
            .collect()
    }

    #[test]
    fn fields_by_byte() {
        let comma = Delimiter::Byte(b',');
        assert_eq!(split("1, 2 ,3", comma), ["1", "2", "3"]);
        assert_eq!(split(",", comma), ["", ""]);
        assert_eq!(split("", comma), [""]);
        assert_eq!(split("1,", comma), ["1", ""]);
        assert_eq!(split(r#""a,b" ,"c ""d"", e",f"#, comma), ["a,b", r#"c ""d"", e"#, "f"]);
        assert_eq!(split(r#""open, 1"#, comma), ["open, 1"]);
        assert_eq!(split(r#"5" pipe,1"#, comma), [r#"5" pipe"#, "1"]);
        assert_eq!(split("1\t\t 2", Delimiter::Byte(b'\t')), ["1", "", "2"]);
    }

    #[test]
    fn fields_by_blanks() {
        assert_eq!(split(" 1 \t 2  3 ", Delimiter::Blanks), ["1", "2", "3"]);
        assert_eq!(split("", Delimiter::Blanks), [""; 0]);
        assert_eq!(split(r#""a b" 2"#, Delimiter::Blanks), ["a b", "2"]);
    }
}
