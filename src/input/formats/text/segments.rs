//! Rows `x1,y1,x2,y2`.

use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, Location, RecordKind};
use crate::input::flaw::Flaw;
use crate::input::formats::text::columns::Table;
use crate::input::formats::text::rows::Rows;
use crate::input::formats::text_lines::number;
use crate::input::lines::{LineTally, SegmentBatch};
use crate::input::point_z::PointZ;
use crate::input::reader::{Reader, Sink};

pub struct Segments {
    rows: Rows,
    /// The number of rows read.
    read: u64,
}

impl Segments {
    /// Skips the header, if there is one.
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
            let location = Location::Line(self.rows.lines.row());
            let ends = ends(&self.rows);
            let ends = ends.map_err(|flaw| sink.wrong(RecordKind::Segment, sink.next(), location, &flaw))?;
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

/// Parses the ends that a row gives.
fn ends(row: &Rows) -> Result<[PointZ; 2], Flaw> {
    let mut values = [0.0; 4];
    for (n, value) in values.iter_mut().enumerate() {
        let found = row.field(n).and_then(number);
        *value = found.ok_or_else(|| Flaw::SegmentRow { row: row.excerpt() })?;
    }
    let [a, b, c, d] = values;
    Ok([PointZ::new(a, b, None)?, PointZ::new(c, d, None)?])
}
