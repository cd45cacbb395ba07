//! Parsing of rows on several threads, ahead of the reading.

use crate::input::decoders::Decoders;
use crate::input::error::InputError;
use crate::input::flaw::Flaw;
use crate::input::formats::text::columns::Layout;
use crate::input::formats::text::rows::Rows;
use crate::input::formats::text_lines::{Block, Lines};
use std::vec::IntoIter;

/// The coordinates of a row, or why it has none. Flaws are rare and large.
pub type Coordinates = Result<(f64, f64, Option<f64>), Box<Flaw>>;

/// A row: the line on which it begins, counted from 1, and its coordinates.
pub type Row = (u64, Coordinates);

/// Blocks of rows that are parsed ahead.
pub struct Ahead {
    decoders: Decoders<Block, Result<Vec<Row>, InputError>>,
    /// The rows of the block that is read.
    rows: IntoIter<Row>,
    /// Whether what is left is to be read row by row.
    is_over: bool,
    /// Why no more blocks can be read.
    failure: Option<InputError>,
}

impl Ahead {
    pub fn new(threads: usize, delimiter: u8, layout: Layout) -> Self {
        Self {
            decoders: Decoders::new(threads, move |block| parse(&block, delimiter, layout)),
            rows: Vec::new().into_iter(),
            is_over: false,
            failure: None,
        }
    }

    /// Returns the next row of `lines`; `None` if all that are left are to be read row by row.
    #[inline]
    pub fn next_row(&mut self, lines: &mut Lines) -> Result<Option<Row>, InputError> {
        match self.rows.next() {
            Some(row) => Ok(Some(row)),
            None => self.next_block(lines),
        }
    }

    fn next_block(&mut self, lines: &mut Lines) -> Result<Option<Row>, InputError> {
        loop {
            while !self.is_over && self.decoders.want_more() {
                match lines.block() {
                    Ok(Some(block)) => self.decoders.put(block),
                    Ok(None) => self.is_over = true,
                    Err(failure) => (self.is_over, self.failure) = (true, Some(failure)),
                }
            }
            match self.decoders.take() {
                Some(rows) => self.rows = rows?.into_iter(),
                None => return self.failure.take().map_or(Ok(None), Err),
            }
            if let Some(row) = self.rows.next() {
                return Ok(Some(row));
            }
        }
    }
}

fn parse(block: &Block, delimiter: u8, layout: Layout) -> Result<Vec<Row>, InputError> {
    let mut rows = Rows::new(block.lines(), delimiter);
    let mut all = Vec::new();
    while rows.next_row()? {
        all.push((rows.lines.row(), layout.read(&rows).map_err(Box::new)));
    }
    Ok(all)
}
