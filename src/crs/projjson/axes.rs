//! The axes of a system.

use serde_json::{Value, json};

use super::parts::{Measure, angle, id, length, meridian, with};
use crate::crs::wkt::Node;

/// The directions of axes in the plane and in space.
const DIRECTIONS: [&str; 18] = [
    "north",
    "northNorthEast",
    "northEast",
    "eastNorthEast",
    "east",
    "eastSouthEast",
    "southEast",
    "southSouthEast",
    "south",
    "southSouthWest",
    "southWest",
    "westSouthWest",
    "west",
    "westNorthWest",
    "northWest",
    "northNorthWest",
    "up",
    "down",
];

/// Returns the coordinate system of a node. `unit` is the unit of axes that have none.
pub fn coordinate_system(node: &Node, subtype: &str, unit: &Measure) -> Option<Value> {
    let axes = node.children.iter().filter(|child| child.keyword == "AXIS");
    let axes: Option<Vec<_>> = axes.map(|node| axis(node, subtype, unit)).collect();
    let axes = match axes? {
        none if none.is_empty() => usual(node, subtype, unit),
        axes => axes,
    };
    let is_right = match subtype {
        "vertical" => axes.len() == 1,
        "Cartesian" => axes.len() == 2,
        _ => matches!(axes.len(), 2 | 3),
    };
    is_right.then(|| json!({"subtype": subtype, "axis": axes}))
}

fn axis(node: &Node, subtype: &str, unit: &Measure) -> Option<Value> {
    let written = node.words.first()?;
    let direction = DIRECTIONS
        .iter()
        .find(|direction| direction.eq_ignore_ascii_case(written))?;
    let is_up = matches!(*direction, "up" | "down");
    let own = match subtype == "ellipsoidal" && !is_up {
        true => angle(node),
        false => length(node),
    };
    // A unit of angles is none of heights.
    let unit = match own {
        Some(own) => own,
        None if is_up && subtype == "ellipsoidal" => return None,
        None => unit.clone(),
    };
    let (name, abbreviation) = name(node.texts.first()?, direction, subtype);
    let axis = described(&name, &abbreviation, direction, &unit);
    let axis = with(axis, "meridian", node.child(&["MERIDIAN"]).and_then(meridian));
    Some(with(axis, "id", id(node)))
}

fn described(name: &str, abbreviation: &str, direction: &str, unit: &Measure) -> Value {
    json!({"name": name, "abbreviation": abbreviation, "direction": direction, "unit": unit.json()})
}

/// Returns the name and the abbreviation in the name of an axis: `easting (E)`, `(E)`, `X`, `Easting`.
fn name(text: &str, direction: &str, subtype: &str) -> (String, String) {
    let (name, abbreviation) = match text.split_once('(') {
        Some((name, abbreviation)) => (name.trim(), abbreviation.trim_end_matches(')')),
        None if text.len() <= 2 => ("", text),
        None => (text, ""),
    };
    let (usual_name, usual_abbreviation) = match (direction, subtype) {
        ("north", "ellipsoidal") => ("Geodetic latitude", "Lat"),
        ("east", "ellipsoidal") => ("Geodetic longitude", "Lon"),
        ("up", "ellipsoidal") => ("Ellipsoidal height", "h"),
        ("up", _) => ("Gravity-related height", "H"),
        ("down", _) => ("Depth", "D"),
        ("east", _) => ("Easting", "E"),
        ("north", _) => ("Northing", "N"),
        ("south", _) => ("Southing", "S"),
        ("west", _) => ("Westing", "W"),
        _ => ("Axis", ""),
    };
    // Names of WKT 1 differ: `Latitude`, `Up`.
    let is_usual = name.is_empty() || subtype != "Cartesian";
    let name = if is_usual { usual_name } else { name };
    let abbreviation = if abbreviation.is_empty() {
        usual_abbreviation
    } else {
        abbreviation
    };
    (name.to_owned(), abbreviation.to_owned())
}

/// Returns the axes of a system that lists none.
fn usual(node: &Node, subtype: &str, unit: &Measure) -> Vec<Value> {
    let axis = |direction: &str| {
        let (name, abbreviation) = name("", direction, subtype);
        described(&name, &abbreviation, direction, unit)
    };
    // Programs omit the axes of systems of EPSG whose first axis points north, because files have
    // longitudes and eastings first nevertheless.
    let is_of_epsg = node.child(&["AUTHORITY"]).is_some();
    match subtype {
        "vertical" => vec![axis("up")],
        "Cartesian" if !is_of_epsg => vec![axis("east"), axis("north")],
        _ => vec![axis("north"), axis("east")],
    }
}

/// Replaces the directions in WKT 1 of a projection about a pole. It calls them east and north, but
/// from the north pole all ways lead south.
pub fn turned_at_pole(axes: &mut Value, conversion: &Value) {
    let Some((is_south, meridian)) = pole(conversion) else {
        return;
    };
    let (direction, up) = if is_south { ("north", 0.0) } else { ("south", 180.0) };
    for axis in axes["axis"].as_array_mut().into_iter().flatten() {
        let turn = match axis["direction"].as_str() {
            Some("east") => 90.0,
            Some("north") => up,
            _ => continue,
        };
        let longitude = (meridian + turn + 180.0_f64).rem_euclid(360.0) - 180.0;
        axis["direction"] = json!(direction);
        axis["meridian"] = json!({"longitude": if longitude == -180.0 { 180.0 } else { longitude }});
    }
}

/// Returns whether the pole that a projection is about is the south pole, and the meridian that is
/// vertical on its map, in degrees.
fn pole(conversion: &Value) -> Option<(bool, f64)> {
    let parameter = |code: u32| {
        let all = conversion["parameters"].as_array()?;
        let found = all.iter().find(|parameter| parameter["id"]["code"] == code)?;
        found["value"]
            .as_f64()
            .filter(|_| found["unit"] == "degree" || found["value"] == 0.0)
    };
    let latitude = match conversion["method"]["id"]["code"].as_u64()? {
        // Lambert azimuthal equal area on the ellipsoid and on the sphere; polar stereographic A.
        9820 | 1027 | 9810 => parameter(8801).filter(|latitude| latitude.abs() == 90.0)?,
        // Polar stereographic B.
        9829 => parameter(8832)?,
        _ => return None,
    };
    let meridian = parameter(8802).or_else(|| parameter(8833))?;
    Some((latitude < 0.0, meridian))
}
