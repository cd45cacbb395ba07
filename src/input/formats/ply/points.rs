//! The points of the element `vertex`.

use crate::geometry::Point;
use crate::input::about::{About, Field, MOST_FIELDS};
use crate::input::bytes::ByteInput;
use crate::input::error::InputError;
use crate::input::formats::ply::body::{Body, Content, open};
use crate::input::formats::ply::header::{Element, Encoding, Property};
use crate::input::formats::ply::rows::Rows;
use crate::input::points::PointBatch;
use crate::input::reader::{Reader, Sink};
use crate::input::sample::RandomAccess;

pub struct Points {
    body: Body,
    rows: Rows,
    /// The elements before and after the vertices that were not passed over yet.
    before: Vec<Element>,
    after: Vec<Element>,
    fields: Vec<Field>,
    note: Option<String>,
}

/// Splits the elements at the vertices.
pub fn split(mut elements: Vec<Element>, body: &Body) -> Result<(Vec<Element>, Element, Vec<Element>), InputError> {
    let is_vertex = |element: &Element| element.name.eq_ignore_ascii_case("vertex");
    let Some(at) = elements.iter().position(is_vertex) else {
        return Err(body.malformed(
            "the header has no element `vertex`",
            "points are read from this element",
        ));
    };
    let after = elements.split_off(at + 1);
    let vertex = elements.remove(at);
    Ok((elements, vertex, after))
}

/// Returns the properties of an element, for a description of the file.
fn fields(element: &Element) -> impl Iterator<Item = Field> {
    let field = |property: &Property| {
        let name = format!("{}.{}", element.name, property.name);
        let scalar = property.scalar.name();
        match property.count {
            None => Field::new(name, scalar),
            Some(count) => Field::new(name, format!("list {} {scalar}", count.name())),
        }
    };
    element.properties.iter().map(field)
}

impl Points {
    pub fn new(input: ByteInput) -> Result<Self, InputError> {
        let (elements, body) = open(input)?;
        let fields = elements.iter().flat_map(fields).take(MOST_FIELDS).collect();
        let (before, vertex, after) = split(elements, &body)?;
        let [x, y, z] = ["x", "y", "z"].map(|name| vertex.property(&[name], false));
        let (Some(x), Some(y)) = (x, y) else {
            let problem = "the element `vertex` has no properties x and y";
            return Err(body.malformed(problem, "points need both, as numbers"));
        };
        let wanted = [x, y].into_iter().chain(z).collect();
        Ok(Self {
            body,
            rows: Rows::new(vertex, wanted, None),
            before,
            after,
            fields,
            note: None,
        })
    }
}

impl Reader<PointBatch> for Points {
    fn has_z(&self) -> bool {
        self.rows.values.len() == 3
    }

    fn expected(&self) -> Option<u64> {
        Some(self.rows.element.rows - self.rows.read)
    }

    fn random_access(&self) -> Option<RandomAccess> {
        let Content::Bytes(bytes) = &self.body.content else {
            return None;
        };
        bytes.size?;
        let strides = self
            .before
            .iter()
            .map(|element| Some((element.rows, element.stride()?)));
        let mut before = strides.map(|stride| stride.and_then(|(rows, stride)| rows.checked_mul(stride as u64)));
        let start = before.try_fold(bytes.offset, |sum, bytes| sum.checked_add(bytes?))?;
        let length = self.rows.element.stride().filter(|stride| *stride > 0)?;
        let (places, encoding) = (self.rows.places(), bytes.encoding);
        Some(RandomAccess {
            start,
            count: self.rows.element.rows,
            length,
            decode: Box::new(move |record| {
                let mut values = places
                    .iter()
                    .map(|(offset, scalar)| scalar.decode(&record[*offset..], encoding));
                let point = Point::new(values.next()?, values.next()?);
                values.all(f64::is_finite).then_some(point)
            }),
        })
    }

    fn fill(&mut self, sink: &mut Sink<'_, PointBatch>) -> Result<bool, InputError> {
        for element in self.before.drain(..) {
            Rows::skip(element, &mut self.body)?;
        }
        while !sink.is_full() {
            let row = self.rows.next(&mut self.body)?;
            let location = || self.body.location();
            match row {
                Some(Ok(())) => match self.rows.values[..] {
                    [x, y] => sink.point(x, y, None, location)?,
                    [x, y, z, ..] => sink.point(x, y, Some(z), location)?,
                    _ => {}
                },
                Some(Err(flaw)) => sink.invalid(location, &flaw)?,
                None => {
                    for element in self.after.drain(..) {
                        Rows::skip(element, &mut self.body)?;
                    }
                    self.note = self.body.rest()?;
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    fn about(&self) -> About {
        let variety = match &self.body.content {
            Content::Lines(_) => "ascii",
            Content::Bytes(bytes) if bytes.encoding == Encoding::BigEndian => "binary, big-endian",
            Content::Bytes(_) => "binary, little-endian",
        };
        About {
            variety: Some(variety.to_owned()),
            fields: self.fields.clone(),
            las: None,
        }
    }

    fn notes(&self) -> Vec<String> {
        self.note.clone().into_iter().collect()
    }
}
