//! The positions of all geometries as points.

use super::{Event, GeoJson, Position};
use crate::input::InputError;
use crate::input::bytes::ByteInput;
use crate::input::reader::Reader;
use crate::input::sink::Sink;

impl GeoJson {
    /// A reader of points, which has looked at the first one.
    pub fn of_points(input: ByteInput) -> Result<Self, InputError> {
        let mut this = Self::new(input)?;
        this.first = this.next_position()?;
        this.has_z = this.first.is_some_and(|position| position.length > 2);
        Ok(this)
    }

    /// The next position; `None` at the end of the file.
    fn next_position(&mut self) -> Result<Option<Position>, InputError> {
        loop {
            match self.next_event()? {
                Some(Event::Position(position)) => return Ok(Some(position)),
                Some(Event::LineEnd(_) | Event::Geometry(..) | Event::Record(_)) => {}
                None => return Ok(None),
            }
        }
    }
}

impl Position {
    fn put(self, sink: &mut Sink<'_>) -> Result<(), InputError> {
        match self.coordinates() {
            Ok((x, y, z)) => sink.point(x, y, z, || self.place()),
            Err(found) => sink.invalid(|| self.place(), || found),
        }
    }
}

impl Reader for GeoJson {
    fn has_z(&self) -> bool {
        self.has_z
    }

    fn crs(&self) -> Option<&str> {
        self.crs.as_deref()
    }

    fn fill(&mut self, sink: &mut Sink<'_>) -> Result<bool, InputError> {
        while !sink.is_full() {
            let position = match self.first.take() {
                Some(first) => Some(first),
                None => self.next_position()?,
            };
            match position {
                Some(position) => position.put(sink)?,
                None => return Ok(false),
            }
        }
        Ok(true)
    }

    fn notes(&self) -> Vec<String> {
        [("polygons give", &self.polygons), ("lines give", &self.lines)]
            .into_iter()
            .filter(|(_, tally)| tally.geometries > 0)
            .map(|(what, tally)| {
                format!(
                    "{}: {} {what} their {} vertices",
                    self.name, tally.geometries, tally.vertices
                )
            })
            .collect()
    }
}
