//! The layout of rows of text, as written by spreadsheets, databases and survey programs.
//!
//! In: bytes, whose first lines determine the layout. Out: a [`Table`], and the coordinates of its
//! rows. The layout has two parts:
//!
//! - **Delimiter**: the first of semicolon, tab and comma that occurs in at least half of the first
//!   rows (outside quotes; tabs in more than half). If there is none, runs of blanks separate the
//!   fields. The delimiter need not occur in all rows, so that a broken row among the first ones is
//!   recognized as broken.
//! - **Header**: the first row is a header if none of the fields that the coordinates would come
//!   from begins like a number. The columns are then found by name, in the order of [`X`], [`Y`]
//!   and [`Z`], ignoring case.
//!
//! Blank lines and lines that begin with `#` do not count. Decimal commas are an error and never
//! guessed: `1,234` may be either number.

use crate::input::bytes::ByteInput;
use crate::input::error::InputError;
use crate::input::flaw::Flaw;
use crate::input::formats::names::{X, Y, Z};
use crate::input::formats::text::rows::{BLANKS, Rows};
use crate::input::formats::text_lines::{Block, Lines, number};
use crate::input::options::{Column, Columns};
use crate::shown::excerpt;

/// The number of rows that determine the delimiter.
const SAMPLE: usize = 20;

/// A text, positioned at its first row.
pub struct Table {
    pub rows: Rows,
    /// The first row, if there is one.
    pub first: Rows,
    pub has_rows: bool,
}

impl Table {
    pub fn open(input: ByteInput) -> Result<Self, InputError> {
        let mut lines = Lines::new(input)?;
        let sample = lines.sample()?;
        let delimiter = find_delimiter(&sample);
        let mut first = Rows::new(sample.lines(), delimiter);
        Ok(Self {
            has_rows: first.next_row()?,
            first,
            rows: Rows::new(lines, delimiter),
        })
    }

    /// Skips the first row if it is a header, judging by its first `columns` fields. Returns
    /// whether it was one.
    pub fn skip_header(&mut self, columns: usize) -> Result<bool, InputError> {
        let is_header = self.has_rows && self.first.fields().iter().take(columns).all(|field| is_name(field));
        if is_header {
            self.rows.next_row()?;
        }
        Ok(is_header)
    }
}

/// The columns of the coordinates in a row.
#[derive(Clone, Copy)]
pub struct Layout {
    /// The columns, counted from 0.
    pub x: usize,
    pub y: usize,
    pub z: Option<usize>,
}

impl Layout {
    /// Reads the coordinates of a row.
    #[inline]
    pub fn read(&self, row: &Rows) -> Result<(f64, f64, Option<f64>), Flaw> {
        let value = |n| row.field(n).and_then(number);
        match (value(self.x), value(self.y), self.z.map(|n| (n, value(n)))) {
            (Some(x), Some(y), None) => Ok((x, y, None)),
            (Some(x), Some(y), Some((_, Some(z)))) => Ok((x, y, Some(z))),
            (None, ..) => Err(self.flaw(row, 'x', self.x)),
            (_, None, _) => Err(self.flaw(row, 'y', self.y)),
            (_, _, Some((n, None))) => Err(self.flaw(row, 'z', n)),
        }
    }

    /// Returns why column `n` of a row is not a number.
    #[cold]
    fn flaw(&self, row: &Rows, axis: char, n: usize) -> Flaw {
        let Some(field) = row.field(n) else {
            return Flaw::TooFewFields {
                count: row.count(),
                needed: 1 + self.x.max(self.y).max(self.z.unwrap_or(0)),
                row: row.excerpt(),
            };
        };
        let pointed: Vec<u8> = field.iter().map(|&b| if b == b',' { b'.' } else { b }).collect();
        Flaw::NoNumber {
            axis,
            field: excerpt(field),
            has_comma: number(&pointed).is_some(),
        }
    }
}

/// Returns whether a field may be a column's name: it is not a number and does not begin like one.
pub fn is_name(field: &[u8]) -> bool {
    let digits = field.trim_ascii_start();
    let digits = digits
        .strip_prefix(b"-")
        .or(digits.strip_prefix(b"+"))
        .unwrap_or(digits);
    let digits = digits.strip_prefix(b".").unwrap_or(digits);
    !field.is_empty() && !digits.first().is_some_and(u8::is_ascii_digit) && number(field).is_none()
}

/// Finds the columns of the coordinates in a header.
pub fn header_layout(header: &Rows, columns: Option<&Columns>) -> Result<Layout, InputError> {
    let fields = header.fields();
    let names: Vec<String> = fields
        .iter()
        // CloudCompare begins its headers with two slashes.
        .map(|field| {
            String::from_utf8_lossy(field)
                .trim_start_matches("//")
                .trim()
                .to_lowercase()
        })
        .collect();
    let find = |wanted: &str| names.iter().position(|name| *name == wanted.to_lowercase());
    let any = |wanted: &[&str]| wanted.iter().find_map(|name| find(name));
    let need = |found: Option<usize>, wanted: &str| {
        found.ok_or_else(|| {
            let shown = excerpt(&fields.join(&b", "[..]));
            let hint = "name the columns, or give their numbers from 1, with the option `columns` (x,y or x,y,z)";
            header
                .lines
                .malformed(format!("no column {wanted} in the header `{shown}`"), hint)
        })
    };
    let Some(columns) = columns else {
        let x = need(any(X), "for x (such as x, lon, easting)")?;
        let y = need(any(Y), "for y (such as y, lat, northing)")?;
        return Ok(Layout { x, y, z: any(Z) });
    };
    let column = |column: &Column| match column {
        Column::Number(n) => need(n.checked_sub(1).filter(|&n| n < names.len()), &n.to_string()),
        Column::Name(name) => need(find(name), &format!("`{name}`")),
    };
    Ok(Layout {
        x: column(&columns.x)?,
        y: column(&columns.y)?,
        z: columns.z.as_ref().map(column).transpose()?,
    })
}

/// Determines the delimiter from the first rows.
fn find_delimiter(sample: &Block) -> u8 {
    let in_most = |delimiter: &u8| {
        let mut rows = Rows::new(sample.lines(), *delimiter);
        let (mut with, mut without) = (0, 0);
        // With a wrong delimiter a quote may stay open for too long; that does not matter.
        while with + without < SAMPLE && matches!(rows.next_row(), Ok(true)) {
            *(if rows.count() > 1 { &mut with } else { &mut without }) += 1;
        }
        // Tabs may stand for blanks.
        with > 0 && with >= without + usize::from(*delimiter == b'\t')
    };
    b";\t,".iter().copied().find(in_most).unwrap_or(BLANKS)
}
