//! What a GeoJSON document has, piece by piece.

use crate::input::error::Place;
use crate::input::flaw::Flaw;
use crate::input::spot::Spot;

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

    /// The level of its positions.
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

/// What comes next in a document.
#[derive(Clone, Copy)]
pub enum Event {
    Position(Position),
    /// A line or a ring is at its end, if the geometry has any: which one of its array, from 0. A polygon's outer ring is 0.
    LineEnd(u64),
    /// A geometry with coordinates is at its end; it began there.
    Geometry(Kind, Place),
    /// A feature, or a geometry outside of all, is at its end; it began there.
    Record(Place),
}

/// A position, good or not.
#[derive(Clone, Copy, Default)]
pub struct Position {
    pub values: [f64; 3],
    /// Its elements, more than three too.
    pub length: usize,
    /// Whether all elements are numbers.
    pub strange: bool,
    pub offset: u64,
}

impl Position {
    /// Its coordinates, or what is wrong with it.
    pub fn coordinates(self) -> Result<(f64, f64, Option<f64>), Flaw> {
        let [x, y, z] = self.values;
        if self.strange {
            Err(Flaw::StrangePosition)
        } else if self.length < 2 {
            Err(Flaw::ShortPosition { length: self.length })
        } else {
            Ok((x, y, (self.length > 2).then_some(z)))
        }
    }

    /// The place that it tells, or what is wrong with it.
    pub fn spot(self) -> Result<Spot, Flaw> {
        let (x, y, z) = self.coordinates()?;
        Spot::new(x, y, z)
    }

    /// Where it stands.
    pub fn place(self) -> Place {
        Place::Byte(self.offset)
    }
}
