//! Heights along a line, as JSON and GeoJSON.

use delaunay_tiles::terrain::{Profile, ProfilePart, ProfilePoint};
use serde_json::{Value, json};

use crate::values::position;

/// Returns the JSON object of a profile.
pub fn object(profile: &Profile) -> Value {
    let point = |point: &ProfilePoint| {
        let at = position(point.point);
        json!({"distance": point.distance, "at": at, "z": point.z})
    };
    let parts = profile
        .parts
        .iter()
        .map(|part| part.points.iter().map(point).collect::<Vec<_>>());
    json!({"length": profile.length, "parts": parts.collect::<Vec<_>>(), "gaps": profile.gaps()})
}

/// Returns a part as a feature: a LineString with z, or a Point. `number` is its index.
pub fn feature(part: &ProfilePart, number: u64) -> Value {
    let coordinates = part.points.iter().map(|p| json!([p.point.x, p.point.y, p.z]));
    let mut coordinates: Vec<Value> = coordinates.collect();
    let geometry = match coordinates.len() {
        1 => json!({"type": "Point", "coordinates": coordinates.remove(0)}),
        _ => json!({"type": "LineString", "coordinates": coordinates}),
    };
    let ends = [part.points.first(), part.points.last()].map(|end| end.map(|point| point.distance));
    let properties = json!({"part": number, "from": ends[0], "to": ends[1]});
    json!({"type": "Feature", "properties": properties, "geometry": geometry})
}
