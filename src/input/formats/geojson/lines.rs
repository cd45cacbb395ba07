//! The lines and the rings of polygons of GeoJSON.

use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, RecordKind};
use crate::input::formats::geojson::event::{Event, Kind};
use crate::input::formats::geojson::features::Features;
use crate::input::lines::{LineTally, SegmentBatch};
use crate::input::reader::{Reader, Sink};
use crate::input::spot::Spot;

pub struct Lines {
    features: Features,
    /// The vertices of the geometry at hand, which are kept since only its end tells for sure what it is.
    vertices: Vec<Vertex>,
    /// Whether the geometry is at its end, and its segments are handed out.
    is_due: bool,
    /// The vertices that were handed out.
    given: usize,
    /// Whether the next vertex goes on with a line.
    in_line: bool,
    /// The segments of the geometry so far.
    segments: u64,
}

struct Vertex {
    end: Spot,
    /// Whether a segment leads here from the vertex before.
    is_joined: bool,
}

impl Lines {
    pub fn new(input: ByteInput) -> Result<Self, InputError> {
        Ok(Self {
            features: Features::new(input, None, |_| true)?,
            vertices: Vec::new(),
            is_due: false,
            given: 0,
            in_line: false,
            segments: 0,
        })
    }

    /// Hands out what leads to the next vertex of a geometry at its end.
    fn give(&mut self, sink: &mut Sink<'_, SegmentBatch>) {
        match self.vertices.get(self.given) {
            Some(vertex) if vertex.is_joined => {
                let before = self.vertices[self.given - 1].end;
                sink.segment([before, vertex.end], self.features.ended());
                self.given += 1;
            }
            Some(_) => self.given += 1,
            None => self.drop_geometry(),
        }
    }

    fn drop_geometry(&mut self) {
        self.vertices.clear();
        (self.is_due, self.given, self.segments) = (false, 0, 0);
    }
}

impl Reader<SegmentBatch> for Lines {
    fn has_z(&self) -> bool {
        self.features.has_z()
    }

    fn tally(&self) -> LineTally {
        LineTally {
            lines: self.features.ended(),
            polygons: 0,
        }
    }

    fn fill(&mut self, sink: &mut Sink<'_, SegmentBatch>) -> Result<bool, InputError> {
        while !sink.is_full() {
            if self.is_due {
                self.give(sink);
                continue;
            }
            match self.features.next_event()? {
                None => return Ok(false),
                Some(Event::LineEnd(_)) => self.in_line = false,
                Some(Event::Position(position)) => {
                    let number = sink.next() + self.segments;
                    let end = position.spot();
                    let end = end.map_err(|flaw| sink.wrong(RecordKind::Segment, number, position.place(), &flaw))?;
                    let is_joined = std::mem::replace(&mut self.in_line, true);
                    self.segments += u64::from(is_joined);
                    self.vertices.push(Vertex { end, is_joined });
                }
                Some(Event::Geometry(kind, _)) => {
                    self.in_line = false;
                    if matches!(kind, Kind::Point | Kind::MultiPoint) {
                        self.drop_geometry();
                    }
                    self.is_due = !self.vertices.is_empty();
                }
                Some(Event::Record(_)) => {}
            }
        }
        Ok(true)
    }
}
