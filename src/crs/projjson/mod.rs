//! PROJJSON of a coordinate reference system, made from its WKT.
//!
//! In: a tree of WKT 1 (of the OGC, of GDAL or of ESRI) or WKT 2. Out: the same system as PROJJSON
//! 0.7 (<https://proj.org/specifications/projjson.html>). WKT 2 has the same parts in other words. In
//! WKT 1, methods and parameters have other names than in the EPSG dataset, and values have the
//! units of the system; `methods` has the table. A transformation to WGS 84 that WKT contains is not
//! part of the system, and is omitted.
//!
//! Nothing is guessed: a system with an unknown method, a parameter that the method does not have,
//! or a missing unit, has no PROJJSON.
//!
//! ```text
//! conversion ──▶ methods
//!     └────▶ parts ◀──── axes      names, ids, units, datums
//! ```

mod axes;
mod conversion;
mod methods;
mod parts;

use serde_json::{Value, json};

use self::axes::{coordinate_system, turned_at_pole};
use self::conversion::conversion;
use self::parts::{angle, frame, geodetic_datum, id, length, object, with};
use super::system::{COMPOUND, GEOGRAPHIC, LOCAL, PROJECTED};
use super::wkt::Node;

const SCHEMA: &str = "https://proj.org/schemas/v0.7/projjson.schema.json";

/// Returns the PROJJSON of the system that a tree describes, with its heights if they can be
/// described; `None` if the system of the plane cannot.
pub fn of(root: &Node) -> Option<Value> {
    Some(with(system(root)?, "$schema", Some(json!(SCHEMA))))
}

fn system(node: &Node) -> Option<Value> {
    let keyword = &&*node.keyword;
    match *keyword {
        "BOUNDCRS" => system(node.child(&["SOURCECRS"])?.children.first()?),
        _ if COMPOUND.contains(keyword) => compound(node),
        _ if PROJECTED.contains(keyword) => projected(node),
        _ if GEOGRAPHIC.contains(keyword) => geographic(node),
        _ if LOCAL.contains(keyword) => local(node),
        _ => None,
    }
}

fn compound(node: &Node) -> Option<Value> {
    let [plane, heights, ..] = &node.children[..] else {
        return None;
    };
    let plane = system(plane)?;
    let Some(heights) = vertical(heights) else {
        return Some(plane);
    };
    let compound = object("CompoundCRS", node)?;
    Some(with(compound, "components", Some(json!([plane, heights]))))
}

/// Returns a geographic system, or a projected system's base.
fn geographic(node: &Node) -> Option<Value> {
    if node.child(&["DERIVINGCONVERSION"]).is_some() {
        return None;
    }
    let unit = angle(node).or_else(|| node.child(&["AXIS"]).and_then(angle));
    // Bases of WKT 2 have the unit of angles at other places only.
    let unit = unit.or_else(|| node.keyword.starts_with("BASE").then(parts::degree))?;
    let (key, datum) = geodetic_datum(node, &unit)?;
    let system = with(object("GeographicCRS", node)?, key, Some(datum));
    let axes = coordinate_system(node, "ellipsoidal", &unit)?;
    Some(with(system, "coordinate_system", Some(axes)))
}

fn projected(node: &Node) -> Option<Value> {
    let base = node.child(&["GEOGCS", "BASEGEOGCRS", "BASEGEODCRS"])?;
    let unit = length(node).or_else(|| node.child(&["AXIS"]).and_then(length))?;
    let system = object("ProjectedCRS", node)?;
    let system = with(system, "base_crs", Some(geographic(base)?));
    let conversion = conversion(node, base, &unit)?;
    let mut axes = coordinate_system(node, "Cartesian", &unit)?;
    if node.keyword == "PROJCS" {
        turned_at_pole(&mut axes, &conversion);
    }
    let system = with(system, "conversion", Some(conversion));
    Some(with(system, "coordinate_system", Some(axes)))
}

fn vertical(node: &Node) -> Option<Value> {
    /// What WKT 1 calls heights above the ellipsoid, which are no system of their own.
    const ELLIPSOIDAL: f64 = 2002.0;
    if !matches!(&*node.keyword, "VERT_CS" | "VERTCRS" | "VERTICALCRS") {
        return None;
    }
    let datum = node.child(&["VERT_DATUM", "VDATUM", "VRF", "VERTICALDATUM"])?;
    if datum.numbers.first() == Some(&ELLIPSOIDAL) {
        return None;
    }
    let unit = length(node).or_else(|| node.child(&["AXIS"]).and_then(length))?;
    let system = with(
        object("VerticalCRS", node)?,
        "datum",
        Some(frame("VerticalReferenceFrame", datum)?),
    );
    let axes = coordinate_system(node, "vertical", &unit)?;
    Some(with(system, "coordinate_system", Some(axes)))
}

fn local(node: &Node) -> Option<Value> {
    let unit = length(node).or_else(|| node.child(&["AXIS"]).and_then(length))?;
    let datum = node.child(&["LOCAL_DATUM", "EDATUM", "ENGINEERINGDATUM"]);
    let datum = match datum {
        Some(datum) => with(json!({"name": datum.texts.first()?}), "id", id(datum)),
        None => json!({"name": "Unknown engineering datum"}),
    };
    let system = with(object("EngineeringCRS", node)?, "datum", Some(datum));
    let axes = coordinate_system(node, "Cartesian", &unit)?;
    Some(with(system, "coordinate_system", Some(axes)))
}

#[cfg(test)]
mod tests;
