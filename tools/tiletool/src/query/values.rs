//! Points, distances, paths and features, as they are printed.

use std::io::{self, Write};

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{Distance, Path};
use serde_json::{Value, json};

/// What comes before all features of GeoJSON, and what behind.
pub const COLLECTION: &str = r#"{"type":"FeatureCollection","features":["#;
pub const COLLECTION_END: &str = "\n]}";

/// Writes a feature behind so many.
pub fn write_feature(out: &mut impl Write, before: u64, feature: &Value) -> io::Result<()> {
    let comma = if before == 0 { "" } else { "," };
    write!(out, "{comma}\n{feature}")
}

/// A path as the geometry of a feature.
pub fn line_string(path: &Path) -> Value {
    let points: Vec<Value> = path.points.iter().map(|&point| position(point)).collect();
    json!({"type": "LineString", "coordinates": points})
}

pub fn pair(point: Point) -> String {
    format!("{},{}", point.x, point.y)
}

pub fn bounds(distance: &Distance) -> String {
    format!("{},{},{}", distance.value, distance.lower, distance.upper)
}

pub fn position(point: Point) -> Value {
    json!([point.x, point.y])
}

pub fn with_distance(mut value: Value, distance: &Distance) -> Value {
    value["distance"] = distance.value.into();
    value["lower"] = distance.lower.into();
    value["upper"] = distance.upper.into();
    value
}
