//! Rows `x,y` or `x,y,id`, or rows with the columns that a header names.

use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, Location, RecordKind};
use crate::input::flaw::Flaw;
use crate::input::formats::text::columns::{Layout, Table, header_layout};
use crate::input::formats::text::rows::Rows;
use crate::input::point_z::PointZ;
use crate::input::reader::{Reader, Sink};
use crate::input::sites::{SiteBatch, SiteId};

pub struct Sites {
    rows: Rows,
    layout: Layout,
    /// The column of the id, counted from 0.
    id: Option<usize>,
}

const ID_HINT: &str = "the id field is the name of a column, or its number from 1";

impl Sites {
    /// Skips the header, if there is one.
    pub fn new(input: ByteInput, id_field: Option<&str>) -> Result<Self, InputError> {
        let mut table = Table::open(input)?;
        let has_header = table.skip_header(2)?;
        let Table { rows, first, has_rows } = table;
        let fields = first.fields();
        let (layout, header) = match has_header {
            true => (header_layout(&first, None)?, &fields[..]),
            false => (Layout { x: 0, y: 1, z: None }, &[][..]),
        };
        let id = match id_field {
            // There are no rows, so any column will do.
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

    fn read(&self) -> Result<(PointZ, Option<SiteId>), Flaw> {
        let (x, y, z) = self.layout.read(&self.rows)?;
        let point_z = PointZ::new(x, y, z)?;
        let Some(column) = self.id else {
            return Ok((point_z, None));
        };
        let Some(field) = self.rows.field(column) else {
            return Err(Flaw::NoIdColumn {
                column: column + 1,
                row: self.rows.excerpt(),
            });
        };
        Ok((point_z, Some(SiteId::from_field(field)?)))
    }
}

/// Returns the column with this name, ignoring case.
fn named(header: &[&[u8]], name: &str) -> Option<usize> {
    let name = name.trim().to_lowercase();
    header
        .iter()
        .position(|field| String::from_utf8_lossy(field).to_lowercase() == name)
}

/// Returns the column with this number, counted from 1, if there is one.
fn numbered(number: &str, columns: usize) -> Option<usize> {
    number.parse::<usize>().ok()?.checked_sub(1).filter(|&n| n < columns)
}

impl Reader<SiteBatch> for Sites {
    fn has_z(&self) -> bool {
        self.layout.z.is_some()
    }

    fn fill(&mut self, sink: &mut Sink<'_, SiteBatch>) -> Result<bool, InputError> {
        while !sink.is_full() {
            if !self.rows.next_row()? {
                return Ok(false);
            }
            let location = Location::Line(self.rows.lines.row());
            let site = self.read();
            let (point_z, id) = site.map_err(|flaw| sink.wrong(RecordKind::Site, sink.next(), location, &flaw))?;
            sink.site(point_z, id);
        }
        Ok(true)
    }
}
