//! The events that the geometries of a file give, whatever its format.

use crate::input::error::Location;
use crate::input::flaw::Flaw;
use crate::input::point_z::PointZ;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Only in GeoJSON, as are features and collections.
    FeatureCollection,
    Feature,
    GeometryCollection,
    Point,
    MultiPoint,
    LineString,
    MultiLineString,
    Polygon,
    MultiPolygon,
}

/// The next event of a file.
#[derive(Clone, Copy)]
pub enum Event {
    Position(Position),
    /// The end of a line or a ring, if the geometry has any, with its number in its array, counted
    /// from 0. A polygon's outer ring is number 0.
    LineEnd(u64),
    /// The end of a geometry with coordinates, with the location where it began.
    Geometry(Kind, Location),
    /// The end of a feature, or of a geometry outside of any feature, with the location where it
    /// began.
    Record(Location),
}

/// A position, valid or not.
#[derive(Clone, Copy)]
pub struct Position {
    pub values: [f64; 3],
    /// The number of elements; may be more than three.
    pub length: usize,
    /// Whether an element is not a number.
    pub has_non_number: bool,
    /// Where the position is in the file.
    pub location: Location,
}

impl Position {
    /// Returns the coordinates, or what is wrong with the position.
    pub fn coordinates(self) -> Result<(f64, f64, Option<f64>), Flaw> {
        let [x, y, z] = self.values;
        if self.has_non_number {
            Err(Flaw::NotNumeric)
        } else if self.length < 2 {
            Err(Flaw::ShortPosition { length: self.length })
        } else {
            Ok((x, y, (self.length > 2).then_some(z)))
        }
    }

    /// Returns the point with these coordinates, or what is wrong with it.
    pub fn point_z(self) -> Result<PointZ, Flaw> {
        let (x, y, z) = self.coordinates()?;
        PointZ::new(x, y, z)
    }
}
