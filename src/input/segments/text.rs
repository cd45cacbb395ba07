//! Rows `x1,y1,x2,y2`.

use super::Reader;
use super::sink::Sink;
use crate::input::bytes::ByteInput;
use crate::input::lines::{Lines, number};
use crate::input::rows::Rows;
use crate::input::spot::Spot;
use crate::input::text::{find_delimiter, is_name};
use crate::input::{InputError, Place};

pub(super) struct Text {
    rows: Rows,
    /// The rows read.
    read: u64,
}

impl Text {
    /// Passes over a header.
    pub fn new(input: ByteInput) -> Result<Self, InputError> {
        let mut lines = Lines::new(input)?;
        let sample = lines.sample()?;
        let delimiter = find_delimiter(&sample);
        let mut first = Rows::new(sample.lines(), delimiter);
        let mut rows = Rows::new(lines, delimiter);
        if first.next_row()? && first.fields().iter().take(4).all(|field| is_name(field)) {
            rows.next_row()?;
        }
        Ok(Self { rows, read: 0 })
    }
}

impl Reader for Text {
    fn lines(&self) -> u64 {
        self.read
    }

    fn fill(&mut self, sink: &mut Sink<'_>) -> Result<bool, InputError> {
        while !sink.is_full() {
            if !self.rows.next_row()? {
                return Ok(false);
            }
            let ends = ends(&self.rows);
            let ends = ends.map_err(|found| sink.wrong_segment(0, Place::Line(self.rows.lines.row()), found))?;
            sink.segment(ends, self.read);
            self.read += 1;
        }
        Ok(true)
    }
}

/// The ends that a row gives, or what is wrong with it.
fn ends(row: &Rows) -> Result<[Spot; 2], String> {
    let mut values = [0.0; 4];
    for (n, value) in values.iter_mut().enumerate() {
        let found = row.field(n).and_then(number);
        *value =
            found.ok_or_else(|| format!("four numbers x1,y1,x2,y2 are due, and the row is `{}`", row.excerpt()))?;
    }
    let [a, b, c, d] = values;
    Ok([Spot::new(a, b, None)?, Spot::new(c, d, None)?])
}
