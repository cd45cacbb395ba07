//! Rows `x1,y1,x2,y2`.

use super::ends::{end, wrong};
use super::{BATCH, Reader, SegmentBatch};
use crate::input::bytes::ByteInput;
use crate::input::lines::{Lines, number};
use crate::input::rows::Rows;
use crate::input::text::{find_delimiter, is_name};
use crate::input::{InputError, Place};
use std::path::Path;
use std::sync::Arc;

pub(super) struct Text {
    path: Arc<Path>,
    rows: Rows,
}

impl Text {
    /// Passes over a header.
    pub fn new(input: ByteInput) -> Result<Self, InputError> {
        let path = Arc::clone(&input.path);
        let mut lines = Lines::new(input)?;
        let sample = lines.sample()?;
        let delimiter = find_delimiter(&sample);
        let mut first = Rows::new(sample.lines(), delimiter);
        let mut rows = Rows::new(lines, delimiter);
        if first.next_row()? && first.fields().iter().take(4).all(|field| is_name(field)) {
            rows.next_row()?;
        }
        Ok(Self { path, rows })
    }
}

impl Reader for Text {
    fn fill(&mut self, first: u64, batch: &mut SegmentBatch) -> Result<bool, InputError> {
        while batch.len() < BATCH {
            if !self.rows.next_row()? {
                return Ok(false);
            }
            let (rows, path) = (&self.rows, &self.path);
            let segment = first + batch.len() as u64;
            let place = || Place::Line(rows.lines.row());
            let mut values = [0.0; 4];
            for (n, value) in values.iter_mut().enumerate() {
                let found = rows.field(n).and_then(number);
                *value = found.ok_or_else(|| {
                    let found = format!("four numbers x1,y1,x2,y2 are due, and the row is `{}`", rows.excerpt());
                    wrong(path, segment, place(), found)
                })?;
            }
            let [a, b, c, d] = values;
            let ends = [end(path, segment, (a, b), place)?, end(path, segment, (c, d), place)?];
            batch.ends.push(ends);
        }
        Ok(true)
    }
}
