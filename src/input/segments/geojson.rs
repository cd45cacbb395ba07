//! The lines and the rings of polygons of GeoJSON.

use super::ends::{end, wrong};
use super::{BATCH, Reader, SegmentBatch};
use crate::geometry::Point;
use crate::input::InputError;
use crate::input::bytes::ByteInput;
use crate::input::geojson::{Event, GeoJson, Kind};
use std::path::Path;
use std::sync::Arc;

pub(super) struct Lines {
    path: Arc<Path>,
    json: GeoJson,
    /// The segments of the geometry so far.
    geometry: Vec<[Point; 2]>,
    /// The last position of the line.
    at: Option<Point>,
}

impl Lines {
    pub fn new(input: ByteInput) -> Result<Self, InputError> {
        Ok(Self {
            path: Arc::clone(&input.path),
            json: GeoJson::new(input)?,
            geometry: Vec::new(),
            at: None,
        })
    }
}

impl Reader for Lines {
    fn fill(&mut self, first: u64, batch: &mut SegmentBatch) -> Result<bool, InputError> {
        while batch.len() < BATCH {
            match self.json.next_event()? {
                None => return Ok(false),
                Some(Event::LineEnd) => self.at = None,
                Some(Event::Position(position)) => {
                    let segment = first + (batch.len() + self.geometry.len()) as u64;
                    let (x, y, _) = position
                        .coordinates()
                        .map_err(|found| wrong(&self.path, segment, position.place(), found))?;
                    let point = end(&self.path, segment, (x, y), || position.place())?;
                    if let Some(before) = self.at.replace(point) {
                        self.geometry.push([before, point]);
                    }
                }
                Some(Event::Geometry(kind)) => {
                    self.at = None;
                    if !matches!(kind, Kind::Point | Kind::MultiPoint) {
                        batch.ends.extend_from_slice(&self.geometry);
                    }
                    self.geometry.clear();
                }
            }
        }
        Ok(true)
    }
}
