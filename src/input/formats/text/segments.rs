//! Rows `x1,y1,x2,y2`.

use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, Place, RecordKind};
use crate::input::flaw::Flaw;
use crate::input::formats::text::columns::Table;
use crate::input::formats::text::rows::Rows;
use crate::input::formats::text_lines::number;
use crate::input::lines::{LineTally, SegmentBatch};
use crate::input::reader::{Reader, Sink};
use crate::input::spot::Spot;

pub struct Segments {
    rows: Rows,
    /// The rows read.
    read: u64,
}

impl Segments {
    /// Passes over a header.
    pub fn new(input: ByteInput) -> Result<Self, InputError> {
        let mut table = Table::open(input)?;
        table.skip_header(4)?;
        Ok(Self {
            rows: table.rows,
            read: 0,
        })
    }
}

impl Reader<SegmentBatch> for Segments {
    fn fill(&mut self, sink: &mut Sink<'_, SegmentBatch>) -> Result<bool, InputError> {
        while !sink.is_full() {
            if !self.rows.next_row()? {
                return Ok(false);
            }
            let place = Place::Line(self.rows.lines.row());
            let ends = ends(&self.rows);
            let ends = ends.map_err(|flaw| sink.wrong(RecordKind::Segment, sink.next(), place, &flaw))?;
            sink.segment(ends, self.read);
            self.read += 1;
        }
        Ok(true)
    }

    fn tally(&self) -> LineTally {
        LineTally {
            lines: self.read,
            polygons: 0,
        }
    }
}

/// The ends that a row gives, or what is wrong with it.
fn ends(row: &Rows) -> Result<[Spot; 2], Flaw> {
    let mut values = [0.0; 4];
    for (n, value) in values.iter_mut().enumerate() {
        let found = row.field(n).and_then(number);
        *value = found.ok_or_else(|| Flaw::SegmentRow { row: row.excerpt() })?;
    }
    let [a, b, c, d] = values;
    Ok([Spot::new(a, b, None)?, Spot::new(c, d, None)?])
}
