//! The edges of the triangles in Triangle's `.ele` files.
//!
//! In: lines. The first one has the number of triangles, the number of nodes of each (3, or 6 with
//! the middles of its edges) and the number of attributes. Every other line has a triangle: its
//! number, then the numbers of its nodes, the three corners first, then attributes. `#` begins a
//! comment. Out: edges. The nodes are in the `.node` file of the same stem beside it, which says
//! whether they are numbered from 0 or 1. Source:
//! <https://www.cs.cmu.edu/~quake/triangle.ele.html>. No count is trusted.

use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, Location};
use crate::input::flaw::Flaw;
use crate::input::formats::edges::Faces;
use crate::input::formats::node::{fields, whole_number};
use crate::input::formats::poly::Section;
use crate::input::formats::text_lines::Lines;
use crate::input::lines::{LineTally, SegmentBatch};
use crate::input::reader::{Reader, Sink};

pub struct Edges {
    lines: Lines,
    section: Section,
    faces: Faces,
}

impl Edges {
    /// Reads the triangles of `nodes` nodes, which are numbered from `base` on.
    pub fn new(input: ByteInput, base: u64, nodes: u64) -> Result<Self, InputError> {
        let mut lines = Lines::new(input)?;
        let section = Section::begin(&mut lines, "triangles", 3)?;
        match fields(lines.text()).nth(1).and_then(whole_number) {
            Some(3 | 6) => {}
            Some(4 | 10) => {
                let problem = format!("the first line is `{}`: tetrahedra", lines.excerpt());
                return Err(lines.malformed(problem, "triangles have 3 nodes, or 6 with the middles of their edges"));
            }
            _ => {
                let problem = format!("the first line is `{}`", lines.excerpt());
                let hint = "it is: number of triangles, nodes per triangle (3 or 6), attributes";
                return Err(lines.malformed(problem, hint));
            }
        }
        Ok(Self {
            lines,
            section,
            faces: Faces::new(base, nodes),
        })
    }

    fn triangle(&mut self) -> Result<(), Flaw> {
        let mut numbers = fields(self.lines.text()).map(whole_number);
        let mut next = || numbers.next().flatten();
        match (next(), next(), next(), next()) {
            (Some(_), Some(a), Some(b), Some(c)) => self.faces.face([a, b, c]),
            _ => Err(Flaw::EleRow {
                row: self.lines.excerpt(),
            }),
        }
    }
}

impl Reader<SegmentBatch> for Edges {
    fn fill(&mut self, sink: &mut Sink<'_, SegmentBatch>) -> Result<bool, InputError> {
        while self.faces.drain(sink) {
            if !self.section.next_row(&mut self.lines)? {
                self.section.end(&mut self.lines)?;
                return Ok(false);
            }
            let taken = self.triangle();
            taken.map_err(|flaw| self.faces.wrong(sink, Location::Line(self.lines.row()), &flaw))?;
        }
        Ok(true)
    }

    fn tally(&self) -> LineTally {
        self.faces.tally()
    }
}
