//! The segments of lines and of the rings of polygons.

use crate::input::error::{InputError, RecordKind};
use crate::input::formats::shapes::Shapes;
use crate::input::formats::shapes::event::{Event, Kind};
use crate::input::formats::shapes::features::Features;
use crate::input::lines::{LineTally, SegmentBatch};
use crate::input::point_z::PointZ;
use crate::input::reader::{Reader, Sink};

pub struct Lines {
    features: Features,
    /// The vertices of the current geometry. They are kept because its type is certain only at its
    /// end.
    vertices: Vec<Vertex>,
    /// Whether the geometry has ended, so that its segments are handed out.
    is_ended: bool,
    /// The number of vertices that were handed out.
    emitted: usize,
    /// Whether the next vertex continues a line.
    in_line: bool,
    /// The number of segments of the geometry so far.
    segments: u64,
}

struct Vertex {
    end: PointZ,
    /// Whether a segment leads here from the vertex before.
    is_joined: bool,
}

impl Lines {
    pub fn new(shapes: Box<dyn Shapes>) -> Result<Self, InputError> {
        Ok(Self {
            features: Features::new(shapes, None, |_| true)?,
            vertices: Vec::new(),
            is_ended: false,
            emitted: 0,
            in_line: false,
            segments: 0,
        })
    }

    /// Hands out the segment to the next vertex, if there is one, of a geometry that has ended.
    fn emit(&mut self, sink: &mut Sink<'_, SegmentBatch>) {
        match self.vertices.get(self.emitted) {
            Some(vertex) if vertex.is_joined => {
                let before = self.vertices[self.emitted - 1].end;
                sink.segment([before, vertex.end], self.features.ended());
                self.emitted += 1;
            }
            Some(_) => self.emitted += 1,
            None => self.drop_geometry(),
        }
    }

    fn drop_geometry(&mut self) {
        self.vertices.clear();
        (self.is_ended, self.emitted, self.segments) = (false, 0, 0);
    }
}

impl Reader<SegmentBatch> for Lines {
    fn has_z(&self) -> bool {
        self.features.has_z()
    }

    fn crs(&self) -> Option<&str> {
        self.features.crs()
    }

    fn tally(&self) -> LineTally {
        LineTally {
            lines: self.features.ended(),
            polygons: 0,
        }
    }

    fn notes(&self) -> Vec<String> {
        self.features.notes()
    }

    fn fill(&mut self, sink: &mut Sink<'_, SegmentBatch>) -> Result<bool, InputError> {
        while !sink.is_full() {
            if self.is_ended {
                self.emit(sink);
                continue;
            }
            match self.features.next_event()? {
                None => return Ok(false),
                Some(Event::LineEnd(_)) => self.in_line = false,
                Some(Event::Position(position)) => {
                    let number = sink.next() + self.segments;
                    let end = position.point_z();
                    let end = end.map_err(|flaw| sink.wrong(RecordKind::Segment, number, position.location, &flaw))?;
                    let is_joined = std::mem::replace(&mut self.in_line, true);
                    self.segments += u64::from(is_joined);
                    self.vertices.push(Vertex { end, is_joined });
                }
                Some(Event::Geometry(kind, _)) => {
                    self.in_line = false;
                    if matches!(kind, Kind::Point | Kind::MultiPoint) {
                        self.drop_geometry();
                    }
                    self.is_ended = !self.vertices.is_empty();
                }
                Some(Event::Record(_)) => {}
            }
        }
        Ok(true)
    }
}
