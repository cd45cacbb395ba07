//! The types of GeoJSON's objects.

use crate::input::formats::shapes::Kind;

/// Returns the type with this name.
pub fn kind_of(name: &str) -> Option<Kind> {
    Some(match name {
        "FeatureCollection" => Kind::FeatureCollection,
        "Feature" => Kind::Feature,
        "GeometryCollection" => Kind::GeometryCollection,
        "Point" => Kind::Point,
        "MultiPoint" => Kind::MultiPoint,
        "LineString" => Kind::LineString,
        "MultiLineString" => Kind::MultiLineString,
        "Polygon" => Kind::Polygon,
        "MultiPolygon" => Kind::MultiPolygon,
        _ => return None,
    })
}

/// Returns the level of the positions: the number of arrays from `coordinates` down to a
/// position's.
pub fn level_of(kind: Kind) -> usize {
    match kind {
        Kind::FeatureCollection | Kind::Feature | Kind::GeometryCollection => 0,
        Kind::Point => 1,
        Kind::MultiPoint | Kind::LineString => 2,
        Kind::MultiLineString | Kind::Polygon => 3,
        Kind::MultiPolygon => 4,
    }
}
