//! The `.node` files of Triangle and of TetGen, whose points have a third coordinate, and the
//! vertices of Triangle's `.poly` files.
//!
//! In: lines. The first line has the number of points, the dimension (2, or TetGen's 3), the number
//! of attributes per point and the number of boundary markers (0 or 1). Every other line has a
//! point: its index, counted from 0 or 1, then its coordinates, attributes and marker. `#` begins a
//! comment, on a line of its own or after the fields. Out: points, with z if the dimension is 3.
//! Attributes and markers are not read; a note reports attributes. Source:
//! <https://www.cs.cmu.edu/~quake/triangle.node.html>. The number of points is not trusted: the
//! rows are counted. A `.poly` file begins in the same way and continues after the points, where
//! `poly` reads it.

use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, Location};
use crate::input::flaw::Flaw;
use crate::input::formats::text_lines::{Lines, number};
use crate::input::points::PointBatch;
use crate::input::reader::{Reader, Sink};
use crate::shown;

const HINT: &str = "the first line is: number of points, dimension (2 or 3), attributes, markers (0 or 1)";

/// The points of a `.node` or `.poly` file.
pub struct Node {
    vertices: Vertices,
    /// Whether other sections may follow the points.
    is_poly: bool,
    name: String,
}

impl Node {
    pub fn new(input: ByteInput) -> Result<Self, InputError> {
        Self::over(input, false)
    }

    /// Reads the points of a `.poly` file; none if they are in the `.node` file beside it.
    pub fn of_poly(input: ByteInput) -> Result<Self, InputError> {
        Self::over(input, true)
    }

    fn over(input: ByteInput, is_poly: bool) -> Result<Self, InputError> {
        let name = shown::path(&input.path);
        let lines = Lines::new(input)?;
        Ok(Self {
            vertices: Vertices::new(lines, is_poly)?,
            is_poly,
            name,
        })
    }
}

/// The first line, and the rows of points that follow it.
pub struct Vertices {
    pub lines: Lines,
    /// The number of points that the first line claims.
    pub claimed: u64,
    /// The number of rows read.
    rows: u64,
    /// The index of the first row, once it is known.
    base: Option<u64>,
    dims: usize,
    attributes: u64,
}

/// The coordinates of a row, or what is wrong with them.
type Row = Result<(f64, f64, Option<f64>), Flaw>;

impl Vertices {
    /// Reads the first line. The dimension must be 2 if `flat` is set.
    pub fn new(mut lines: Lines, flat: bool) -> Result<Self, InputError> {
        let mut first = Vec::new();
        let mut found = String::from("nothing");
        if lines.next_row()? {
            found = format!("`{}`", lines.excerpt());
            first = fields(lines.text()).map(whole_number).collect();
        }
        match first[..] {
            [Some(_), Some(3), ..] if flat => Err(lines.malformed(
                format!("the first line is {found}: points with three coordinates"),
                "the dimension of a .poly file is 2; TetGen's .poly files, which have facets, cannot be read",
            )),
            [Some(claimed), Some(dims @ (2 | 3)), ..] if first.iter().all(Option::is_some) => Ok(Self {
                lines,
                claimed,
                rows: 0,
                base: None,
                dims: dims as usize,
                attributes: first.get(2).copied().flatten().unwrap_or(0),
            }),
            _ => Err(lines.malformed(format!("the first line is {found}"), HINT)),
        }
    }

    /// Returns the next row; `None` after the last point that the first line claims.
    pub fn next_row(&mut self) -> Result<Option<Row>, InputError> {
        if self.rows == self.claimed {
            return Ok(None);
        }
        if !self.lines.next_row()? {
            let problem = format!("the file ends after {} of {} points", self.rows, self.claimed);
            let hint = "it is cut short, or its first line is wrong";
            return Err(self.lines.malformed(problem, hint));
        }
        let mut fields = fields(self.lines.text());
        let index = fields.next().and_then(whole_number);
        let base = *self.base.get_or_insert(index.unwrap_or(u64::MAX).min(2));
        if base > 1 || index != base.checked_add(self.rows) {
            let problem = match base {
                2 => format!("the first point's index is neither 0 nor 1: `{}`", self.lines.excerpt()),
                _ => format!("the index is not {}: `{}`", base + self.rows, self.lines.excerpt()),
            };
            let hint = "points are numbered from 0 or 1 without gaps";
            return Err(self.lines.malformed(problem, hint));
        }
        self.rows += 1;
        let mut next = || fields.next().and_then(number);
        let (x, y, z) = (next(), next(), if self.dims == 3 { next() } else { None });
        Ok(Some(match (x, y) {
            (Some(x), Some(y)) if z.is_some() || self.dims == 2 => Ok((x, y, z)),
            _ => Err(Flaw::NodeRow {
                row: self.lines.excerpt(),
                dims: self.dims,
            }),
        }))
    }

    /// Returns the index of the first point, 0 or 1; known once a row was read.
    pub fn base(&self) -> Option<u64> {
        self.base
    }
}

/// Returns the fields of a row up to a comment.
pub fn fields(row: &[u8]) -> impl Iterator<Item = &[u8]> {
    row.split(|b| *b == b'#')
        .take(1)
        .flat_map(|row| row.split(u8::is_ascii_whitespace))
        .filter(|field| !field.is_empty())
}

/// Parses a field as an unsigned integer.
pub fn whole_number(field: &[u8]) -> Option<u64> {
    std::str::from_utf8(field).ok()?.parse().ok()
}

impl Reader<PointBatch> for Node {
    fn has_z(&self) -> bool {
        self.vertices.dims == 3
    }

    fn expected(&self) -> Option<u64> {
        Some(self.vertices.claimed.saturating_sub(self.vertices.rows))
    }

    fn fill(&mut self, sink: &mut Sink<'_, PointBatch>) -> Result<bool, InputError> {
        while !sink.is_full() {
            let row = self.vertices.next_row()?;
            let lines = &mut self.vertices.lines;
            let location = Location::Line(lines.row());
            match row {
                Some(Ok((x, y, z))) => sink.point(x, y, z, || location)?,
                Some(Err(flaw)) => sink.invalid(|| location, &flaw)?,
                None if !self.is_poly && lines.next_row()? => {
                    let (row, claimed) = (lines.excerpt(), self.vertices.claimed);
                    let problem = format!("a row after the last of {claimed} points: `{row}`");
                    return Err(lines.malformed(problem, HINT));
                }
                None => return Ok(false),
            }
        }
        Ok(true)
    }

    fn notes(&self) -> Vec<String> {
        match self.vertices.attributes {
            0 => Vec::new(),
            n => vec![format!(
                "{}: {n} attributes per point are not read{}",
                self.name,
                // The tool's export writes z as an attribute, which nothing in the file tells.
                if self.has_z() {
                    ""
                } else {
                    ", even if one is z; for points with z, give CSV, PLY or OBJ"
                }
            )],
        }
    }
}
