//! The positions of all geometries as points.

use crate::input::error::InputError;
use crate::input::formats::shapes::Shapes;
use crate::input::formats::shapes::event::{Event, Kind};
use crate::input::formats::shapes::features::Features;
use crate::input::points::PointBatch;
use crate::input::reader::{Reader, Sink};
use crate::shown;
use std::path::Path;

pub struct Points {
    features: Features,
    polygons: Tally,
    lines: Tally,
    /// The numbers of lines or rings, of first lines or outer rings, and of vertices of the current
    /// geometry.
    open: Open,
    name: String,
}

#[derive(Default)]
struct Open {
    lines: u64,
    firsts: u64,
    vertices: u64,
}

/// The number of lines or polygons, and of their vertices.
#[derive(Default)]
struct Tally {
    geometries: u64,
    vertices: u64,
}

impl Points {
    /// Reads up to the first position.
    pub fn new(shapes: Box<dyn Shapes>, path: &Path) -> Result<Self, InputError> {
        Ok(Self {
            features: Features::new(shapes, None, |_| true)?,
            polygons: Tally::default(),
            lines: Tally::default(),
            open: Open::default(),
            name: shown::path(path),
        })
    }

    /// Counts a geometry that has ended, for the notes.
    fn end_geometry(&mut self, kind: Kind) {
        let open = std::mem::take(&mut self.open);
        let (tally, geometries) = match kind {
            Kind::LineString => (&mut self.lines, 1),
            Kind::MultiLineString => (&mut self.lines, open.lines),
            Kind::Polygon => (&mut self.polygons, 1),
            Kind::MultiPolygon => (&mut self.polygons, open.firsts),
            _ => return,
        };
        tally.geometries += geometries;
        tally.vertices += open.vertices;
    }
}

impl Reader<PointBatch> for Points {
    fn has_z(&self) -> bool {
        self.features.has_z()
    }

    fn crs(&self) -> Option<&str> {
        self.features.crs()
    }

    fn fill(&mut self, sink: &mut Sink<'_, PointBatch>) -> Result<bool, InputError> {
        while !sink.is_full() {
            match self.features.next_event()? {
                Some(Event::Position(position)) => {
                    self.open.vertices += 1;
                    match position.coordinates() {
                        Ok((x, y, z)) => sink.point(x, y, z, || position.location)?,
                        Err(flaw) => sink.invalid(|| position.location, &flaw)?,
                    }
                }
                Some(Event::LineEnd(number)) => {
                    self.open.lines += 1;
                    self.open.firsts += u64::from(number == 0);
                }
                Some(Event::Geometry(kind, _)) => self.end_geometry(kind),
                Some(Event::Record(_)) => {}
                None => return Ok(false),
            }
        }
        Ok(true)
    }

    fn notes(&self) -> Vec<String> {
        let tallies = [("polygons give", &self.polygons), ("lines give", &self.lines)];
        let tallies = tallies.into_iter().filter(|(_, tally)| tally.geometries > 0);
        let notes = tallies.map(|(what, tally)| {
            let (name, vertices) = (&self.name, tally.vertices);
            format!("{name}: {} {what} their {vertices} vertices", tally.geometries)
        });
        self.features.notes().into_iter().chain(notes).collect()
    }
}
