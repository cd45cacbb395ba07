//! Output formats of points, distances, paths and features.

use std::io::{self, Write};

use delaunay_tiles::crs::Crs;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{Distance, Path};
use serde_json::{Value, json};

/// Returns the text before all features of GeoJSON. The member `crs` of the former standard, which
/// GIS programs read, tells the system if that is not longitude and latitude.
pub fn collection(crs: Option<&Crs>) -> String {
    collection_with(crs, &Value::Null)
}

/// Returns the text before all features of GeoJSON, with the members of an object before them.
pub fn collection_with(crs: Option<&Crs>, members: &Value) -> String {
    let mut text = r#"{"type":"FeatureCollection","#.to_owned();
    if let Some(urn) = crs.and_then(Crs::urn) {
        let member = json!({"type": "name", "properties": {"name": urn}});
        text += &format!(r#""crs":{member},"#);
    }
    for (key, member) in members.as_object().into_iter().flatten() {
        text += &format!("{}:{member},", json!(key));
    }
    text + r#""features":["#
}

/// The text after all features of GeoJSON.
pub const COLLECTION_END: &str = "\n]}";

/// Writes a feature after `before` others.
pub fn write_feature(out: &mut impl Write, before: u64, feature: &Value) -> io::Result<()> {
    let comma = if before == 0 { "" } else { "," };
    write!(out, "{comma}\n{feature}")
}

/// Returns a path as the geometry of a feature.
pub fn line_string(path: &Path) -> Value {
    let points: Vec<Value> = path.points.iter().map(|&point| position(point)).collect();
    json!({"type": "LineString", "coordinates": points})
}

/// Returns the cells `x,y` of a point.
pub fn pair(point: Point) -> String {
    format!("{},{}", point.x, point.y)
}

/// Returns the cells `distance,lower,upper` of a distance.
pub fn bounds(distance: &Distance) -> String {
    format!("{},{},{}", distance.value, distance.lower, distance.upper)
}

/// Returns the position `[x, y]` of a point.
pub fn position(point: Point) -> Value {
    json!([point.x, point.y])
}

/// Adds a distance and its bounds to an object.
pub fn with_distance(mut value: Value, distance: &Distance) -> Value {
    value["distance"] = distance.value.into();
    value["lower"] = distance.lower.into();
    value["upper"] = distance.upper.into();
    value
}
