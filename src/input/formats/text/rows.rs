//! Rows of delimited text (RFC 4180) and their fields, parsed by `csv-core`.
//!
//! In: [`Lines`]. Out: row by row the fields, trimmed and without quotes. A quote counts only at
//! the beginning of a field. The library gets a row line by line, and the next line only while a
//! quote is open. Thus lines are counted, comments skipped and the length of rows limited before
//! anything is stored.
//!
//! `csv-core` is used and not `csv`, which is built on it: `csv` gathers a field whose quotes are
//! never closed in memory, however long the field is.

use crate::input::error::InputError;
use crate::input::formats::text_lines::Lines;
use crate::shown::excerpt;
use csv_core::{ReadRecordResult, Reader, ReaderBuilder, Terminator};

/// The delimiter that means runs of spaces and tabs.
pub const BLANKS: u8 = b' ';

pub struct Rows {
    pub lines: Lines,
    delimiter: u8,
    csv: Reader,
    /// The row's fields, concatenated, and the end of each. Both vectors may be longer than the
    /// part in use.
    text: Vec<u8>,
    ends: Vec<usize>,
    /// The number of fields.
    count: usize,
}

impl Rows {
    pub fn new(lines: Lines, delimiter: u8) -> Self {
        let csv = ReaderBuilder::new()
            .delimiter(delimiter)
            .terminator(Terminator::Any(b'\n'))
            .build();
        Self {
            lines,
            delimiter,
            csv,
            text: Vec::new(),
            ends: Vec::new(),
            count: 0,
        }
    }

    /// Returns the byte between fields.
    pub fn delimiter(&self) -> u8 {
        self.delimiter
    }

    /// Reads the next row; returns false at the end.
    #[inline]
    pub fn next_row(&mut self) -> Result<bool, InputError> {
        self.count = 0;
        let mut used = 0;
        if !self.lines.next_row()? {
            return Ok(false);
        }
        loop {
            let line = self.lines.text_mut();
            if self.delimiter == BLANKS {
                for byte in &mut *line {
                    *byte = if *byte == b'\t' { BLANKS } else { *byte };
                }
            }
            // This is always enough room, so the library never asks for more.
            let (bytes, ends) = (used + line.len() + 1, self.count + line.len() + 1);
            if self.text.len() < bytes || self.ends.len() < ends {
                self.text.resize(bytes.max(self.text.len()), 0);
                self.ends.resize(ends.max(self.ends.len()), 0);
            }
            // A last line without a line end gives no record. The empty line read after it then
            // tells the library that the input has ended.
            let (result, _, bytes, fields) =
                self.csv
                    .read_record(line, &mut self.text[used..], &mut self.ends[self.count..]);
            used += bytes;
            self.count += fields;
            if result != ReadRecordResult::InputEmpty {
                break;
            }
            self.lines.read_line()?;
        }
        if self.delimiter == BLANKS {
            self.drop_empty();
        }
        Ok(true)
    }

    /// Removes the empty fields, which come from between the blanks of a run.
    fn drop_empty(&mut self) {
        let (mut kept, mut last) = (0, 0);
        for n in 0..self.count {
            let end = self.ends[n];
            if end > last {
                self.ends[kept] = end;
                kept += 1;
                last = end;
            }
        }
        self.count = kept;
    }

    /// Returns the number of fields.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Returns field `n`, counted from 0.
    #[inline]
    pub fn field(&self, n: usize) -> Option<&[u8]> {
        let end = *self.ends[..self.count].get(n)?;
        let start = if n == 0 { 0 } else { self.ends[n - 1] };
        Some(self.text[start..end].trim_ascii())
    }

    /// Returns all fields.
    pub fn fields(&self) -> Vec<&[u8]> {
        (0..self.count).filter_map(|n| self.field(n)).collect()
    }

    /// Returns the row as text for a message.
    pub fn excerpt(&self) -> String {
        excerpt(&self.fields().join(&self.delimiter))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::bytes::ByteInput;
    use crate::input::watch::{Reading, Watched};
    use std::io::Cursor;
    use std::path::Path;

    fn rows(text: &str, delimiter: u8) -> Vec<Vec<String>> {
        let read = Cursor::new(text.as_bytes().to_vec());
        let read = Watched::stream(read, Path::new("test"), &Reading::default());
        let input = ByteInput::new(read, false).unwrap();
        let mut rows = Rows::new(Lines::new(input).unwrap(), delimiter);
        let mut all = Vec::new();
        while rows.next_row().unwrap() {
            let fields = rows.fields();
            all.push(fields.iter().map(|f| String::from_utf8_lossy(f).into_owned()).collect());
        }
        all
    }

    #[test]
    fn a_byte_separates_fields_and_quotes_protect_it() {
        assert_eq!(rows("1, 2 ,3", b','), [["1", "2", "3"]]);
        assert_eq!(rows(",\n\n1,\r\n", b','), [["", ""], ["1", ""]]);
        assert_eq!(rows(r#""a,b" ,"c ""d"", e",f"#, b','), [["a,b", r#"c "d", e"#, "f"]]);
        assert_eq!(rows("\"open, 1\n\n#2", b','), [["open, 1\n\n#2"]]);
        assert_eq!(rows(r#"5" pipe,1"#, b','), [[r#"5" pipe"#, "1"]]);
        assert_eq!(rows("1\t\t 2", b'\t'), [["1", "", "2"]]);
    }

    #[test]
    fn runs_of_blanks_separate_fields() {
        assert_eq!(rows(" 1 \t 2  3 \n\t4 5 6", BLANKS), [["1", "2", "3"], ["4", "5", "6"]]);
        assert_eq!(rows("\"a b\" 2\r\n # \"c\n3 4\r\n", BLANKS), [["a b", "2"], ["3", "4"]]);
    }
}
