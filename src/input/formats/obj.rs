//! Wavefront OBJ: lines of text, each with a keyword.
//!
//! ```text
//! v 1.5 2.5 0.25           a vertex: x, y, z; what follows is not read
//! f 1 2 3                  a face: vertices numbered from 1, or from the last one back (-1)
//! f 1/7/3 2//4 3/8         with numbers of textures and normals, which are not read
//! l 1 2                    a line
//! ```
//!
//! In: lines. Out: the points; or the edges of faces and lines. All other keywords are passed over.
//! Source: Wavefront Technologies, Advanced Visualizer Manual, appendix B1.

use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, Location};
use crate::input::flaw::Flaw;
use crate::input::formats::edges::Faces;
use crate::input::formats::node::fields;
use crate::input::formats::text_lines::{Lines, number};
use crate::input::lines::{LineTally, SegmentBatch};
use crate::input::points::PointBatch;
use crate::input::reader::{Reader, Sink};
use crate::shown;

/// Rows of an OBJ file.
struct Rows(Lines);

/// The keyword of a row.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Keyword {
    Vertex,
    Face,
    Line,
    Other,
}

impl Rows {
    /// Reads the next row; `None` at the end.
    fn next(&mut self) -> Result<Option<Keyword>, InputError> {
        if !self.0.next_row()? {
            return Ok(None);
        }
        let text = self.0.text();
        let keyword = match fields(text).next() {
            Some(b"v") => Keyword::Vertex,
            Some(b"f") => Keyword::Face,
            Some(b"l") => Keyword::Line,
            _ if text.contains(&0) => {
                let problem = format!("the row `{}`", self.0.excerpt());
                return Err(self.0.malformed(problem, "this is not a text file, and so not OBJ"));
            }
            _ => return Ok(Some(Keyword::Other)),
        };
        if text.trim_ascii_end().ends_with(b"\\") {
            let problem = format!("a row that continues on the next line: `{}`", self.0.excerpt());
            return Err(self.0.malformed(problem, "write each vertex and each face on one line"));
        }
        Ok(Some(keyword))
    }

    fn location(&self) -> Location {
        Location::Line(self.0.row())
    }
}

pub struct Points {
    rows: Rows,
    read: u64,
    name: String,
}

impl Points {
    pub fn new(input: ByteInput) -> Result<Self, InputError> {
        let name = shown::path(&input.path);
        let rows = Rows(Lines::new(input)?);
        Ok(Self { rows, read: 0, name })
    }

    /// Reads the current row, which is one of a vertex.
    fn vertex(&self) -> Result<(f64, f64, f64), Flaw> {
        let mut numbers = fields(self.rows.0.text()).skip(1).map(number);
        let mut next = || numbers.next().flatten();
        match (next(), next(), next()) {
            (Some(x), Some(y), Some(z)) => Ok((x, y, z)),
            _ => Err(Flaw::ObjVertex {
                row: self.rows.0.excerpt(),
            }),
        }
    }
}

impl Reader<PointBatch> for Points {
    fn has_z(&self) -> bool {
        true
    }

    fn fill(&mut self, sink: &mut Sink<'_, PointBatch>) -> Result<bool, InputError> {
        while !sink.is_full() {
            match self.rows.next()? {
                None => return Ok(false),
                Some(Keyword::Vertex) => {
                    self.read += 1;
                    let location = || self.rows.location();
                    match self.vertex() {
                        Ok((x, y, z)) => sink.point(x, y, Some(z), location)?,
                        Err(flaw) => sink.invalid(location, &flaw)?,
                    }
                }
                Some(_) => {}
            }
        }
        Ok(true)
    }

    fn notes(&self) -> Vec<String> {
        let is_empty = self.read == 0;
        is_empty
            .then(|| format!("{}: no row begins with `v`, so there are no vertices", self.name))
            .into_iter()
            .collect()
    }
}

/// Reads the whole file, and returns the number of its vertices.
pub fn vertices(input: ByteInput) -> Result<u64, InputError> {
    let (mut rows, mut vertices) = (Rows(Lines::new(input)?), 0);
    while let Some(keyword) = rows.next()? {
        vertices += u64::from(keyword == Keyword::Vertex);
    }
    Ok(vertices)
}

pub struct Edges {
    rows: Rows,
    /// The number of vertices so far, from which negative numbers count.
    vertices: u64,
    faces: Faces,
    name: String,
}

impl Edges {
    pub fn new(input: ByteInput, vertices: u64) -> Result<Self, InputError> {
        let name = shown::path(&input.path);
        Ok(Self {
            rows: Rows(Lines::new(input)?),
            vertices: 0,
            faces: Faces::new(1, vertices),
            name,
        })
    }

    /// Reads the current row, which is one of a face or line.
    fn corners(&self) -> Result<Vec<u64>, Flaw> {
        let corner = |field: &[u8]| {
            let index = field.split(|b| *b == b'/').next()?;
            let index: i64 = std::str::from_utf8(index).ok()?.parse().ok()?;
            match u64::try_from(index) {
                Ok(index) => Some(index),
                Err(_) => (self.vertices + 1).checked_sub(index.unsigned_abs()),
            }
        };
        let corners: Option<Vec<u64>> = fields(self.rows.0.text()).skip(1).map(corner).collect();
        let corners = corners.filter(|corners| corners.len() > 1);
        corners.ok_or_else(|| Flaw::ObjFace {
            row: self.rows.0.excerpt(),
        })
    }
}

impl Reader<SegmentBatch> for Edges {
    fn fill(&mut self, sink: &mut Sink<'_, SegmentBatch>) -> Result<bool, InputError> {
        while self.faces.drain(sink) {
            let taken = match self.rows.next()? {
                None => return Ok(false),
                Some(Keyword::Vertex) => {
                    self.vertices += 1;
                    continue;
                }
                Some(Keyword::Face) => self.corners().and_then(|corners| self.faces.face(corners)),
                Some(Keyword::Line) => self.corners().and_then(|corners| self.faces.line(corners)),
                Some(Keyword::Other) => continue,
            };
            taken.map_err(|flaw| self.faces.wrong(sink, self.rows.location(), &flaw))?;
        }
        Ok(true)
    }

    fn tally(&self) -> LineTally {
        self.faces.tally()
    }

    fn notes(&self) -> Vec<String> {
        let is_empty = self.faces.tally().lines == 0;
        is_empty
            .then(|| format!("{}: there are no faces, and so no edges", self.name))
            .into_iter()
            .collect()
    }
}
