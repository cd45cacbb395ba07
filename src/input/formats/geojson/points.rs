//! The positions of all geometries as points.

use crate::input::bytes::ByteInput;
use crate::input::error::InputError;
use crate::input::formats::geojson::event::Event;
use crate::input::formats::geojson::features::Features;
use crate::input::points::PointBatch;
use crate::input::reader::{Reader, Sink};

pub struct Points {
    features: Features,
}

impl Points {
    /// Reads up to the first position.
    pub fn new(input: ByteInput) -> Result<Self, InputError> {
        Ok(Self {
            features: Features::new(input, None, |_| true)?,
        })
    }
}

impl Reader<PointBatch> for Points {
    fn has_z(&self) -> bool {
        self.features.has_z()
    }

    fn crs(&self) -> Option<&str> {
        self.features.json().crs()
    }

    fn fill(&mut self, sink: &mut Sink<'_, PointBatch>) -> Result<bool, InputError> {
        while !sink.is_full() {
            match self.features.next_event()? {
                Some(Event::Position(position)) => match position.coordinates() {
                    Ok((x, y, z)) => sink.point(x, y, z, || position.location())?,
                    Err(flaw) => sink.invalid(|| position.location(), &flaw)?,
                },
                Some(Event::LineEnd(_) | Event::Geometry(..) | Event::Record(_)) => {}
                None => return Ok(false),
            }
        }
        Ok(true)
    }

    fn notes(&self) -> Vec<String> {
        self.features.json().notes()
    }
}
