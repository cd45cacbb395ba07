//! The `.node` files of Triangle, and of TetGen, which have a third coordinate.
//!
//! In: lines. The first one has the number of points, the dimension (2, or TetGen's 3), the number of attributes per
//! point and the number of boundary markers (0 or 1); each other one has a point: its index, from 0 or 1, its
//! coordinates, attributes, marker. `#` begins a comment, on a line of its own or behind the fields. Out: points,
//! with z if the dimension is 3. Attributes and markers are not read, which a note tells.
//! Source: <https://www.cs.cmu.edu/~quake/triangle.node.html>. The number of points is believed by nobody: the rows
//! are counted.

use super::bytes::ByteInput;
use super::error::excerpt;
use super::lines::{Lines, number};
use super::reader::Reader;
use super::sink::Sink;
use super::{InputError, Place};

const HINT: &str = "the first line is: number of points, dimension (2 or 3), attributes, markers (0 or 1)";

pub(super) struct Node {
    lines: Lines,
    /// The number of points that the first line claims.
    claimed: u64,
    /// The rows read.
    rows: u64,
    /// The first row's index, when it is known.
    base: Option<u64>,
    dims: usize,
    attributes: u64,
    name: String,
}

impl Node {
    pub fn new(input: ByteInput) -> Result<Self, InputError> {
        let name = input.path.display().to_string();
        let mut lines = Lines::new(input)?;
        let mut first = Vec::new();
        let mut found = String::from("nothing");
        if lines.next_row()? {
            let row = lines.text().trim_ascii_end();
            found = format!("`{}`", excerpt(row));
            first = fields(row)
                .map(|field| std::str::from_utf8(field).ok()?.parse::<u64>().ok())
                .collect();
        }
        match first[..] {
            [Some(claimed), Some(dims @ (2 | 3)), ..] if first.iter().all(Option::is_some) => Ok(Self {
                lines,
                claimed,
                rows: 0,
                base: None,
                dims: dims as usize,
                attributes: first.get(2).copied().flatten().unwrap_or(0),
                name,
            }),
            _ => Err(lines.malformed(format!("the first line is {found}"), HINT)),
        }
    }
}

/// The fields of a row up to a comment.
fn fields(row: &[u8]) -> impl Iterator<Item = &[u8]> {
    row.split(|b| *b == b'#')
        .take(1)
        .flat_map(|row| row.split(u8::is_ascii_whitespace))
        .filter(|field| !field.is_empty())
}

impl Reader for Node {
    fn has_z(&self) -> bool {
        self.dims == 3
    }

    fn expected_points(&self) -> Option<u64> {
        Some(self.claimed.saturating_sub(self.rows))
    }

    fn fill(&mut self, sink: &mut Sink<'_>) -> Result<bool, InputError> {
        while !sink.is_full() {
            if !self.lines.next_row()? {
                if self.rows < self.claimed {
                    let problem = format!("the file ends after {} of {} points", self.rows, self.claimed);
                    return Err(self
                        .lines
                        .malformed(problem, "it is cut short, or its first line is wrong"));
                }
                return Ok(false);
            }
            let row = self.lines.text().trim_ascii_end();
            if self.rows == self.claimed {
                let problem = format!("a row behind the last of {} points: `{}`", self.claimed, excerpt(row));
                return Err(self.lines.malformed(problem, HINT));
            }
            let mut fields = fields(row);
            let index = fields.next().unwrap_or_default();
            let index: Option<u64> = std::str::from_utf8(index).ok().and_then(|text| text.parse().ok());
            let base = *self.base.get_or_insert(index.unwrap_or(u64::MAX).min(2));
            if base > 1 || index != base.checked_add(self.rows) {
                let problem = match base {
                    2 => format!("the first point's index is neither 0 nor 1: `{}`", excerpt(row)),
                    _ => format!("the index is not {}: `{}`", base + self.rows, excerpt(row)),
                };
                return Err(self
                    .lines
                    .malformed(problem, "points are numbered from 0 or 1 without gaps"));
            }
            self.rows += 1;
            let mut next = || fields.next().and_then(number);
            let (x, y, z) = (next(), next(), if self.dims == 3 { next() } else { None });
            let found = match (x, y) {
                (Some(x), Some(y)) if z.is_some() || self.dims == 2 => Ok((x, y)),
                _ => Err(format!("`{}` has not an index and {} numbers", excerpt(row), self.dims)),
            };
            let line = self.lines.row();
            match found {
                Ok((x, y)) => sink.point(x, y, z, || Place::Line(line))?,
                Err(found) => sink.invalid(|| Place::Line(line), || found)?,
            }
        }
        Ok(true)
    }

    fn notes(&self) -> Vec<String> {
        match self.attributes {
            0 => Vec::new(),
            n => vec![format!("{}: {n} attributes per point are not read", self.name)],
        }
    }
}
