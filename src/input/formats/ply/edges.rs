//! The edges of the element `face`; if there are no faces, the element `edge`.

use crate::input::bytes::ByteInput;
use crate::input::error::InputError;
use crate::input::flaw::Flaw;
use crate::input::formats::edges::Faces;
use crate::input::formats::ply::body::{Body, open};
use crate::input::formats::ply::header::Element;
use crate::input::formats::ply::points::split;
use crate::input::formats::ply::rows::Rows;
use crate::input::lines::{LineTally, SegmentBatch};
use crate::input::reader::{Reader, Sink};

/// The names of the list of a face's corners.
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Returns the number of vertices that the header claims.
pub fn vertices(input: ByteInput) -> Result<u64, InputError> {
    let (elements, body) = open(input)?;
    let (_, vertex, _) = split(elements, &body)?;
    Ok(vertex.rows)
}

pub struct Edges {
    body: Body,
    /// The elements before the faces that were not passed over yet.
    before: Vec<Element>,
    /// The faces or edges; `None` if there are none.
    rows: Option<Rows>,
    after: Vec<Element>,
    faces: Faces,
    note: Option<String>,
}

impl Edges {
    pub fn new(input: ByteInput, vertices: u64) -> Result<Self, InputError> {
        let path = crate::shown::path(&input.path);
        let (mut elements, body) = open(input)?;
        let find = |name| {
            elements
                .iter()
                .position(|element: &Element| element.name == name && element.rows > 0)
        };
        let Some(at) = find("face").or_else(|| find("edge")) else {
            return Ok(Self {
                body,
                before: elements,
                rows: None,
                after: Vec::new(),
                faces: Faces::new(0, vertices),
                note: Some(format!("{path}: there are no faces, and so no edges")),
            });
        };
        let after = elements.split_off(at + 1);
        let rows = Some(of_element(elements.remove(at), &body)?);
        Ok(Self {
            body,
            before: elements,
            rows,
            after,
            faces: Faces::new(0, vertices),
            note: None,
        })
    }
}

/// Returns the rows of faces or of edges.
fn of_element(element: Element, body: &Body) -> Result<Rows, InputError> {
    if element.name == "face" {
        let Some(list) = element.property(&CORNERS, true) else {
            let problem = "the element `face` has no list of corners";
            return Err(body.malformed(problem, "its name must be vertex_indices or vertex_index"));
        };
        return Ok(Rows::new(element, Vec::new(), Some(list)));
    }
    match ["vertex1", "vertex2"].map(|name| element.property(&[name], false)) {
        [Some(one), Some(other)] => Ok(Rows::new(element, vec![one, other], None)),
        _ => {
            let problem = "the element `edge` has no properties vertex1 and vertex2";
            Err(body.malformed(problem, "an edge needs both, as numbers"))
        }
    }
}

impl Reader<SegmentBatch> for Edges {
    fn fill(&mut self, sink: &mut Sink<'_, SegmentBatch>) -> Result<bool, InputError> {
        for element in self.before.drain(..) {
            Rows::skip(element, &mut self.body)?;
        }
        while self.faces.drain(sink) {
            let Some(rows) = &mut self.rows else {
                return Ok(false);
            };
            let Some(row) = rows.next(&mut self.body)? else {
                for element in self.after.drain(..) {
                    Rows::skip(element, &mut self.body)?;
                }
                return Ok(false);
            };
            let is_edge = rows.values.len() == 2;
            let taken = row.and_then(|()| {
                let corners = if is_edge { &rows.values } else { &rows.items };
                if let Some(&value) = corners.iter().find(|value| !is_index(**value)) {
                    return Err(Flaw::NoIndex { value });
                }
                let corners = corners.iter().map(|value| *value as u64);
                match is_edge {
                    true => self.faces.line(corners),
                    false => self.faces.face(corners),
                }
            });
            taken.map_err(|flaw| self.faces.wrong(sink, self.body.location(), &flaw))?;
        }
        Ok(true)
    }

    fn tally(&self) -> LineTally {
        self.faces.tally()
    }

    fn notes(&self) -> Vec<String> {
        self.note.clone().into_iter().collect()
    }
}

fn is_index(value: f64) -> bool {
    value.fract() == 0.0 && (0.0..9e15).contains(&value)
}
