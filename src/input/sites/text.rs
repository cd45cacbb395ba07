//! Rows `x,y` or `x,y,id`, or with the columns that a header names.

use super::sink::Sink;
use super::{Reader, SiteId};
use crate::input::bytes::ByteInput;
use crate::input::lines::Lines;
use crate::input::rows::Rows;
use crate::input::spot::Spot;
use crate::input::text::{HEADER_HINT, Layout, find_delimiter, header_layout, is_name};
use crate::input::{InputError, Place};

pub(super) struct Text {
    rows: Rows,
    layout: Layout,
    /// The column of the id, from 0.
    id: Option<usize>,
}

const ID_HINT: &str = "give the name of a column, or its number from 1, with --site-id";

impl Text {
    /// Passes over a header.
    pub fn new(input: ByteInput, id_field: Option<&str>) -> Result<Self, InputError> {
        let mut lines = Lines::new(input)?;
        let sample = lines.sample()?;
        let delimiter = find_delimiter(&sample);
        let mut rows = Rows::new(lines, delimiter);
        let mut first = Rows::new(sample.lines(), delimiter);
        let has_rows = first.next_row()?;
        let fields = first.fields();
        let has_header = has_rows && fields.iter().take(2).all(|field| is_name(field));
        let mut layout = Layout { x: 0, y: 1, z: None };
        if has_header {
            rows.next_row()?;
            layout = header_layout(&fields, None).map_err(|problem| first.lines.malformed(problem, HEADER_HINT))?;
        }
        let header = if has_header { &fields[..] } else { &[] };
        let id = match id_field {
            // No rows: any column will do.
            Some(_) if !has_rows => None,
            Some(field) => {
                let problem = || format!("no column `{field}` in the first row, `{}`", first.excerpt());
                let column = named(header, field).or_else(|| numbered(field, fields.len()));
                Some(column.ok_or_else(|| first.lines.malformed(problem(), ID_HINT))?)
            }
            None => named(header, "id").or_else(|| {
                let third = fields.get(2)?;
                (!has_header || third.is_empty()).then_some(2)
            }),
        };
        Ok(Self { rows, layout, id })
    }

    fn read(&self) -> Result<(Spot, Option<SiteId>), String> {
        let (x, y, z) = self.layout.read(&self.rows)?;
        let spot = Spot::new(x, y, z)?;
        let Some(column) = self.id else {
            return Ok((spot, None));
        };
        let Some(field) = self.rows.field(column) else {
            let row = self.rows.excerpt();
            return Err(format!("the row has no column {} for the id: `{row}`", column + 1));
        };
        Ok((spot, Some(SiteId::from_field(field)?)))
    }
}

/// The column of this name, capitals notwithstanding.
fn named(header: &[&[u8]], name: &str) -> Option<usize> {
    let name = name.trim().to_lowercase();
    header
        .iter()
        .position(|field| String::from_utf8_lossy(field).to_lowercase() == name)
}

/// The column of this number from 1, if there is one.
fn numbered(number: &str, columns: usize) -> Option<usize> {
    number.parse::<usize>().ok()?.checked_sub(1).filter(|&n| n < columns)
}

impl Reader for Text {
    fn has_z(&self) -> bool {
        self.layout.z.is_some()
    }

    fn fill(&mut self, sink: &mut Sink<'_>) -> Result<bool, InputError> {
        while !sink.is_full() {
            if !self.rows.next_row()? {
                return Ok(false);
            }
            let place = Place::Line(self.rows.lines.row());
            let (spot, id) = self.read().map_err(|found| sink.wrong(0, place, found))?;
            sink.site(spot, id);
        }
        Ok(true)
    }
}
