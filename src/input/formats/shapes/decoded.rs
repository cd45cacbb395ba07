//! Features that a decoder gives as a whole, as the events that they consist of.
//!
//! In: one feature at a time, as flat lists of positions, ends of lines and geometries. Out: the
//! same events that GeoJSON of these features gives. **Memory**: one feature.

use crate::input::about::Field;
use crate::input::error::{InputError, Location};
use crate::input::formats::shapes::event::{Event, Kind, Position};
use crate::input::formats::shapes::{FoundId, Shapes};

/// The limit on the length in bytes of a feature of a file.
#[cfg(any(feature = "flatgeobuf", feature = "shapefile", feature = "geopackage"))]
pub const LONGEST: u64 = 1 << 29;

/// A format whose features are decoded one at a time.
pub trait Decoder: Send {
    /// Decodes the next feature into `feature`, which is empty; its number is `number`. Returns
    /// false at the end of the file.
    fn decode(&mut self, number: u64, feature: &mut Feature) -> Result<bool, InputError>;

    /// From now on, features must have an id, from the field `field`.
    fn keep_ids(&mut self, field: &str);

    /// Returns the fields of the features. Errors are ignored, since this is only metadata.
    fn fields(&self) -> Vec<Field>;

    /// Returns the coordinate reference system, if the file has one.
    fn crs(&self) -> Option<&str>;

    /// Returns notes for the user, at the end of the file.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}

/// The geometries of a feature.
#[derive(Default)]
pub struct Feature {
    positions: Vec<[f64; 3]>,
    /// The number of positions up to the end of each line or ring, and its number in its geometry
    /// or polygon.
    lines: Vec<(usize, u64)>,
    geometries: Vec<Geometry>,
    pub id: Option<FoundId>,
}

struct Geometry {
    kind: Kind,
    has_z: bool,
    /// The numbers of positions and of lines up to its end.
    positions: usize,
    lines: usize,
}

impl Feature {
    /// Adds a position to the current geometry.
    #[inline]
    pub fn position(&mut self, x: f64, y: f64, z: f64) {
        self.positions.push([x, y, z]);
    }

    /// Ends a line or ring with this number in its array. A polygon's outer ring is number 0.
    pub fn end_line(&mut self, number: u64) {
        self.lines.push((self.positions.len(), number));
    }

    /// Ends a geometry. `has_z` tells whether the z of its positions count.
    pub fn end_geometry(&mut self, kind: Kind, has_z: bool) {
        self.geometries.push(Geometry {
            kind,
            has_z,
            positions: self.positions.len(),
            lines: self.lines.len(),
        });
    }

    fn clear(&mut self) {
        self.positions.clear();
        self.lines.clear();
        self.geometries.clear();
        self.id = None;
    }
}

/// The features of a file, as events.
pub struct Decoded<D> {
    decoder: D,
    feature: Feature,
    /// Whether `feature` has a feature whose events are not all handed out.
    is_open: bool,
    /// The numbers of positions, lines and geometries that were handed out.
    position: usize,
    line: usize,
    geometry: usize,
    /// The number of features that have ended.
    ended: u64,
    id: Option<FoundId>,
}

impl<D: Decoder> Decoded<D> {
    pub fn new(decoder: D) -> Self {
        Self {
            decoder,
            feature: Feature::default(),
            is_open: false,
            position: 0,
            line: 0,
            geometry: 0,
            ended: 0,
            id: None,
        }
    }

    /// Returns the next event of the feature that is open.
    fn step(&mut self) -> Event {
        let location = Location::Feature(self.ended);
        let Some(geometry) = self.feature.geometries.get(self.geometry) else {
            self.is_open = false;
            self.ended += 1;
            self.id = self.feature.id.take();
            return Event::Record(location);
        };
        if self.line < geometry.lines
            && let Some(&(end, number)) = self.feature.lines.get(self.line)
            && end <= self.position
        {
            self.line += 1;
            return Event::LineEnd(number);
        }
        if self.position < geometry.positions
            && let Some(&values) = self.feature.positions.get(self.position)
        {
            self.position += 1;
            return Event::Position(Position {
                values,
                length: if geometry.has_z { 3 } else { 2 },
                has_non_number: false,
                location,
            });
        }
        self.geometry += 1;
        Event::Geometry(geometry.kind, location)
    }
}

impl<D: Decoder> Shapes for Decoded<D> {
    fn next_event(&mut self) -> Result<Option<Event>, InputError> {
        if !self.is_open {
            self.feature.clear();
            (self.position, self.line, self.geometry) = (0, 0, 0);
            if !self.decoder.decode(self.ended, &mut self.feature)? {
                return Ok(None);
            }
            self.is_open = true;
        }
        Ok(Some(self.step()))
    }

    fn kind(&self) -> Option<Kind> {
        let geometry = self.feature.geometries.get(self.geometry).filter(|_| self.is_open)?;
        Some(geometry.kind)
    }

    fn keep_ids(&mut self, field: &str) {
        self.decoder.keep_ids(field);
    }

    fn take_id(&mut self) -> Option<FoundId> {
        self.id.take()
    }

    fn fields(&self) -> Vec<Field> {
        self.decoder.fields()
    }

    fn crs(&self) -> Option<&str> {
        self.decoder.crs()
    }

    fn notes(&self) -> Vec<String> {
        self.decoder.notes()
    }
}
