//! Rows of text: what a spreadsheet, a database or a survey program writes.
//!
//! In: bytes, of which the first lines tell the layout. Out: points. What is found out, and how:
//!
//! - **Delimiter**: the first of semicolon, tab and comma that at least half of the first rows have (outside quotes; tabs
//!   more than half), else runs of blanks. Not all, so that a broken row there is found to be one.
//! - **Header**: the first row is one if none of the fields that the coordinates would come from begins like a number.
//!   The columns are then found by name, in the order of [`X`], [`Y`] and [`Z`], capitals notwithstanding.
//! - **No header**: the first two columns are x and y. The third is z if it is the last one, or the file is an `.xyz`,
//!   and it is a number in the first row. Further columns are not read, which a note tells.
//! - **`--columns`** overrides: by number from 1, or by a header's name. Without a third one there is no z.
//!
//! Lines that are blank or begin with `#` do not count. Decimal commas are an error and never guessed at: `1,234` may
//! be either number.

use super::bytes::ByteInput;
use super::lines::{Lines, Sample, number};
use super::reader::Reader;
use super::rows::{BLANKS, Rows};
use super::sink::Sink;
use super::{Column, Columns, InputError, InputOptions, Place};
use crate::shown;
use crate::shown::excerpt;

/// Names of a column with x, the better first.
const X: &[&str] = &["x", "lon", "longitude", "lng", "long", "easting", "east", "e"];
/// Names of a column with y.
const Y: &[&str] = &["y", "lat", "latitude", "northing", "north", "n"];
/// Names of a column with z.
const Z: &[&str] = &["z", "elevation", "elev", "height", "altitude", "alt"];

/// The rows that tell the delimiter.
const SAMPLE: usize = 20;

pub(super) struct Text {
    rows: Rows,
    layout: Layout,
    notes: Vec<String>,
}

/// Where the coordinates are in a row.
#[derive(Clone, Copy)]
pub(super) struct Layout {
    /// Columns from 0.
    pub x: usize,
    pub y: usize,
    pub z: Option<usize>,
}

impl Text {
    pub fn new(input: ByteInput, options: &InputOptions) -> Result<Self, InputError> {
        let is_xyz = input
            .path
            .file_name()
            .and_then(|name| name.to_str())
            .map(str::to_ascii_lowercase)
            .is_some_and(|name| name.ends_with(".xyz") || name.ends_with(".xyz.gz"));
        let path = input.path.clone();
        let mut lines = Lines::new(input)?;
        let mut notes = Vec::new();
        let sample = lines.sample()?;
        let delimiter = find_delimiter(&sample);
        let mut rows = Rows::new(lines, delimiter);
        let mut first = Rows::new(sample.lines(), delimiter);
        if !first.next_row()? {
            // No rows: any layout will do.
            let layout = Layout { x: 0, y: 1, z: None };
            return Ok(Self { rows, layout, notes });
        }
        let fields = first.fields();
        let chosen = match &options.columns {
            Some(columns) => Chosen::by_option(columns),
            None => Chosen::by_place(&fields, is_xyz),
        };
        let mut at_hand = chosen.numbers().filter_map(|n| fields.get(n)).peekable();
        let is_header = chosen.named || (at_hand.peek().is_some() && at_hand.all(|field| is_name(field)));
        let layout = if is_header {
            rows.next_row()?;
            header_layout(&fields, options.columns.as_ref())
                .map_err(|problem| rows.lines.malformed(problem, HEADER_HINT))?
        } else {
            if options.columns.is_none() && fields.len() > chosen.count() {
                notes.push(format!(
                    "{}: no header; columns 1 to {} of {} are read, choose others with --columns",
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
        Ok(Self { rows, layout, notes })
    }
}

pub(super) const HEADER_HINT: &str =
    "name the columns, or give their numbers from 1, with --columns x,y or --columns x,y,z";

/// The columns that hold coordinates if the first row is no header.
struct Chosen {
    x: usize,
    y: usize,
    z: Option<usize>,
    /// They have names, so there must be a header.
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

    fn by_place(fields: &[&[u8]], is_xyz: bool) -> Self {
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

impl Layout {
    /// The coordinates of a row, or what is wrong with it.
    #[inline]
    pub fn read(&self, row: &Rows) -> Result<(f64, f64, Option<f64>), String> {
        let value = |n| row.field(n).and_then(number);
        match (value(self.x), value(self.y), self.z.and_then(value)) {
            (Some(x), Some(y), z) if z.is_some() || self.z.is_none() => Ok((x, y, z)),
            _ => Err(self.describe(row)),
        }
    }

    #[cold]
    fn describe(&self, row: &Rows) -> String {
        for (name, column) in [("x", Some(self.x)), ("y", Some(self.y)), ("z", self.z)] {
            let Some(n) = column else { continue };
            let Some(field) = row.field(n) else {
                let needed = 1 + self.x.max(self.y).max(self.z.unwrap_or(0));
                return format!("the row has {} of {needed} fields: `{}`", row.count(), row.excerpt());
            };
            if number(field).is_none() {
                let pointed: Vec<u8> = field.iter().map(|&b| if b == b',' { b'.' } else { b }).collect();
                let remark = match number(&pointed) {
                    Some(_) => " (a decimal comma? write decimal points)",
                    None => "",
                };
                return format!("{name} is `{}`, not a number{remark}", excerpt(field));
            }
        }
        format!("no point: `{}`", row.excerpt())
    }
}

/// Whether a field may be a column's name: it neither is nor begins like a number.
pub(super) fn is_name(field: &[u8]) -> bool {
    let digits = field.trim_ascii_start();
    let digits = digits
        .strip_prefix(b"-")
        .or(digits.strip_prefix(b"+"))
        .unwrap_or(digits);
    let digits = digits.strip_prefix(b".").unwrap_or(digits);
    !field.is_empty() && !digits.first().is_some_and(u8::is_ascii_digit) && number(field).is_none()
}

/// Finds the columns in a header.
pub(super) fn header_layout(fields: &[&[u8]], columns: Option<&Columns>) -> Result<Layout, String> {
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
    let header = || excerpt(&fields.join(&b", "[..]));
    let find = |wanted: &str| names.iter().position(|name| *name == wanted.to_lowercase());
    let any = |wanted: &[&str]| wanted.iter().find_map(|name| find(name));
    let need = |found: Option<usize>, wanted: &str| {
        found.ok_or_else(|| format!("no column {wanted} in the header `{}`", header()))
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

/// The delimiter that the first rows tell.
pub(super) fn find_delimiter(sample: &Sample) -> u8 {
    let in_most = |delimiter: &u8| {
        let mut rows = Rows::new(sample.lines(), *delimiter);
        let (mut with, mut without) = (0, 0);
        // With a wrong delimiter a quote may be open for too long: no matter.
        while with + without < SAMPLE && matches!(rows.next_row(), Ok(true)) {
            *(if rows.count() > 1 { &mut with } else { &mut without }) += 1;
        }
        // Tabs may be mere blanks.
        with > 0 && with >= without + usize::from(*delimiter == b'\t')
    };
    b";\t,".iter().copied().find(in_most).unwrap_or(BLANKS)
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
            let place = || Place::Line(self.rows.lines.row());
            match self.layout.read(&self.rows) {
                Ok((x, y, z)) => sink.point(x, y, z, place)?,
                Err(found) => sink.invalid(place, || found)?,
            }
        }
        Ok(true)
    }

    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }
}
