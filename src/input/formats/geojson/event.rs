//! The events of a GeoJSON document.

use crate::input::error::Location;
use crate::input::flaw::Flaw;
use crate::input::point_z::PointZ;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
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

impl Kind {
    pub fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "FeatureCollection" => Self::FeatureCollection,
            "Feature" => Self::Feature,
            "GeometryCollection" => Self::GeometryCollection,
            "Point" => Self::Point,
            "MultiPoint" => Self::MultiPoint,
            "LineString" => Self::LineString,
            "MultiLineString" => Self::MultiLineString,
            "Polygon" => Self::Polygon,
            "MultiPolygon" => Self::MultiPolygon,
            _ => return None,
        })
    }

    /// Returns the level of the positions: the number of arrays from `coordinates` down to a
    /// position's.
    pub fn level(self) -> usize {
        match self {
            Self::FeatureCollection | Self::Feature | Self::GeometryCollection => 0,
            Self::Point => 1,
            Self::MultiPoint | Self::LineString => 2,
            Self::MultiLineString | Self::Polygon => 3,
            Self::MultiPolygon => 4,
        }
    }
}

/// The next event in a document.
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
#[derive(Clone, Copy, Default)]
pub struct Position {
    pub values: [f64; 3],
    /// The number of elements; may be more than three.
    pub length: usize,
    /// Whether an element is not a number.
    pub has_non_number: bool,
    pub offset: u64,
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

    /// Returns where the position is in the file.
    pub fn location(self) -> Location {
        Location::Byte(self.offset)
    }
}
