//! Rows `x,y` or `x,y,z`, or rows with the columns that a header names.
//!
//! - **No header**: the first two columns are x and y. The third is z if it is the last one or the
//!   file is an `.xyz`, and if it is a number in the first row. Further columns are not read, and a
//!   note reports this.
//! - **The option `columns`** overrides this, by number from 1 or by a header's name. Without a
//!   third column there is no z.

use crate::input::about::{About, Field, MOST_FIELDS};
use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, Location};
use crate::input::formats::text::ahead::{Ahead, Row};
use crate::input::formats::text::columns::{Layout, Table, header_layout, is_name};
use crate::input::formats::text::rows::Rows;
use crate::input::formats::text_lines::number;
use crate::input::options::{Column, Columns};
use crate::input::points::PointBatch;
use crate::input::reader::{Reader, Sink};
use crate::shown;
use std::path::Path;

pub struct Points {
    rows: Rows,
    /// The rows that are parsed on other threads, before the others.
    ahead: Option<Ahead>,
    layout: Layout,
    fields: Vec<Field>,
    notes: Vec<String>,
}

impl Points {
    pub fn new(input: ByteInput, columns: Option<&Columns>, threads: usize) -> Result<Self, InputError> {
        let path = input.path.clone();
        let Table {
            mut rows,
            first,
            has_rows,
        } = Table::open(input)?;
        let mut notes = Vec::new();
        if !has_rows {
            // There are no rows, so any layout will do.
            let layout = Layout { x: 0, y: 1, z: None };
            let fields = Vec::new();
            return Ok(Self {
                rows,
                ahead: None,
                layout,
                fields,
                notes,
            });
        }
        let fields = first.fields();
        let chosen = match columns {
            Some(columns) => Chosen::by_option(columns),
            None => Chosen::by_position(&fields, is_xyz(&path)),
        };
        let mut coordinate_fields = chosen.numbers().filter_map(|n| fields.get(n)).peekable();
        let is_header =
            chosen.named || (coordinate_fields.peek().is_some() && coordinate_fields.all(|field| is_name(field)));
        let described = described(&fields, is_header);
        let layout = if is_header {
            rows.next_row()?;
            header_layout(&first, columns)?
        } else {
            if columns.is_none() && fields.len() > chosen.count() {
                notes.push(format!(
                    "{}: no header; columns 1 to {} of {} are read, choose others with the option `columns`",
                    shown::path(&path),
                    chosen.count(),
                    fields.len()
                ));
            }
            Layout {
                x: chosen.x,
                y: chosen.y,
                z: chosen.z,
            }
        };
        Ok(Self {
            ahead: (threads > 1).then(|| Ahead::new(threads, rows.delimiter(), layout)),
            rows,
            layout,
            fields: described,
            notes,
        })
    }
}

impl Points {
    #[inline]
    fn next_row(&mut self) -> Result<Option<Row>, InputError> {
        if let Some(ahead) = &mut self.ahead {
            match ahead.next_row(&mut self.rows.lines)? {
                None => self.ahead = None,
                row => return Ok(row),
            }
        }
        let has_row = self.rows.next_row()?;
        Ok(has_row.then(|| (self.rows.lines.row(), self.layout.read(&self.rows).map_err(Box::new))))
    }
}

/// Returns the fields for a description of the file, from its first row.
fn described(first: &[&[u8]], is_header: bool) -> Vec<Field> {
    let field = |field: &&[u8]| match is_header {
        true => Field::new(String::from_utf8_lossy(field), ""),
        false => Field::new("", if number(field).is_some() { "number" } else { "text" }),
    };
    first.iter().take(MOST_FIELDS).map(field).collect()
}

fn is_xyz(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str());
    name.map(str::to_ascii_lowercase)
        .is_some_and(|name| name.ends_with(".xyz") || name.ends_with(".xyz.gz"))
}

/// The columns that hold coordinates if the first row is not a header.
struct Chosen {
    x: usize,
    y: usize,
    z: Option<usize>,
    /// Whether the columns are given by name, so that there must be a header.
    named: bool,
}

impl Chosen {
    fn by_option(columns: &Columns) -> Self {
        let mut named = false;
        let mut number = |column: &Column| match column {
            Column::Number(n) => n.saturating_sub(1),
            Column::Name(_) => {
                named = true;
                0
            }
        };
        let (x, y, z) = (number(&columns.x), number(&columns.y), columns.z.as_ref().map(number));
        Self { x, y, z, named }
    }

    fn by_position(fields: &[&[u8]], is_xyz: bool) -> Self {
        let third = fields.len() == 3 || (is_xyz && fields.len() > 3);
        Self {
            x: 0,
            y: 1,
            z: (third && number(fields[2]).is_some()).then_some(2),
            named: false,
        }
    }

    fn numbers(&self) -> impl Iterator<Item = usize> {
        [self.x, self.y].into_iter().chain(self.z)
    }

    fn count(&self) -> usize {
        self.numbers().count()
    }
}

impl Reader<PointBatch> for Points {
    fn has_z(&self) -> bool {
        self.layout.z.is_some()
    }

    fn fill(&mut self, sink: &mut Sink<'_, PointBatch>) -> Result<bool, InputError> {
        while !sink.is_full() {
            let Some((line, coordinates)) = self.next_row()? else {
                return Ok(false);
            };
            let location = || Location::Line(line);
            match coordinates {
                Ok((x, y, z)) => sink.point(x, y, z, location)?,
                Err(flaw) => sink.invalid(location, &flaw)?,
            }
        }
        Ok(true)
    }

    fn about(&self) -> About {
        About {
            fields: self.fields.clone(),
            ..About::default()
        }
    }

    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }
}
