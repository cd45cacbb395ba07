//! The parts of a system that WKT of all versions contains: names, ids, units, datums.

use std::f64::consts::PI;

use serde_json::{Value, json};

use crate::crs::wkt::Node;

/// Names of datums in WKT 1, and in the EPSG dataset if they differ by more than blanks and marks.
const DATUM_NAMES: [(&str, &str); 4] = [
    ("WGS_1984", "World Geodetic System 1984"),
    ("Militar_Geographische_Institute", "Militar-Geographische Institut"),
    ("Geocentric_datum_of_Korea", "Korean Geodetic Datum 2002"),
    (
        "Swiss_Terrestrial_Reference_Frame_1995",
        "Swiss Terrestrial Reference System 1995",
    ),
];

/// A unit of measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Measure {
    kind: &'static str,
    name: String,
    /// The number of metres or radians, or the factor itself.
    factor: f64,
}

impl Measure {
    /// Returns the unit that a node contains under one of the keywords.
    fn of(node: &Node, kind: &'static str, keywords: &[&str]) -> Option<Self> {
        let unit = node.child(keywords)?;
        let &factor = unit.numbers.first().filter(|&&factor| factor > 0.0)?;
        let name = unit.texts.first()?.clone();
        Some(Self { kind, name, factor })
    }

    pub fn json(&self) -> Value {
        let is = |factor: f64| (self.factor / factor - 1.0).abs() < 1e-10;
        match self.kind {
            "LinearUnit" if is(1.0) => json!("metre"),
            "AngularUnit" if is(PI / 180.0) => json!("degree"),
            "ScaleUnit" if is(1.0) => json!("unity"),
            _ => json!({"type": self.kind, "name": self.name, "conversion_factor": self.factor}),
        }
    }

    /// Returns a value as PROJJSON has it where `default` is the unit of a bare number.
    fn value(&self, value: f64, default: &str) -> Value {
        match self.json() {
            Value::String(name) if name == default => json!(value),
            unit => json!({"value": value, "unit": unit}),
        }
    }
}

pub fn degree() -> Measure {
    Measure {
        kind: "AngularUnit",
        name: "degree".to_owned(),
        factor: PI / 180.0,
    }
}

/// Returns the unit of lengths of a node.
pub fn length(node: &Node) -> Option<Measure> {
    Measure::of(node, "LinearUnit", &["LENGTHUNIT", "UNIT"])
}

/// Returns the unit of angles of a node.
pub fn angle(node: &Node) -> Option<Measure> {
    Measure::of(node, "AngularUnit", &["ANGLEUNIT", "UNIT"])
}

/// Returns the unit of ratios of a node.
pub fn ratio(node: &Node) -> Option<Measure> {
    Measure::of(node, "ScaleUnit", &["SCALEUNIT"])
}

/// Returns an object with another member, if there is a value for it.
pub fn with(mut object: Value, key: &str, value: Option<Value>) -> Value {
    if let Some(value) = value {
        object[key] = value;
    }
    object
}

/// Returns an object of a type with the name and id of a node.
pub fn object(kind: &str, node: &Node) -> Option<Value> {
    let object = json!({"type": kind, "name": node.texts.first()?});
    Some(with(object, "id", id(node)))
}

/// Returns the id of a node.
pub fn id(node: &Node) -> Option<Value> {
    let id = node.child(&["AUTHORITY", "ID"])?;
    let authority = id.texts.first()?;
    let code = match (id.texts.get(1), id.numbers.first()) {
        (Some(text), _) => text.parse::<u32>().map_or_else(|_| json!(text), |code| json!(code)),
        (None, Some(&number)) if number.fract() == 0.0 && (0.0..1e9).contains(&number) => json!(number as u32),
        _ => return None,
    };
    Some(json!({"authority": authority, "code": code}))
}

/// Returns a reference frame of a type.
pub fn frame(kind: &str, datum: &Node) -> Option<Value> {
    let mut frame = object(kind, datum)?;
    let written = datum.texts.first()?;
    if let Some((_, name)) = DATUM_NAMES
        .iter()
        .find(|(first, _)| first.eq_ignore_ascii_case(written))
    {
        frame["name"] = json!(name);
    }
    Some(frame)
}

/// Returns the datum of a geographic system, and the name of the member for it. `unit` is the unit of
/// the system's angles.
pub fn geodetic_datum(node: &Node, unit: &Measure) -> Option<(&'static str, Value)> {
    if let Some(ensemble) = node.child(&["ENSEMBLE"]) {
        return Some(("datum_ensemble", datum_ensemble(ensemble)?));
    }
    let datum = node.child(&["DATUM", "TRF", "GEODETICDATUM"])?;
    let epoch = node
        .child(&["DYNAMIC"])
        .and_then(|dynamic| dynamic.child(&["FRAMEEPOCH"]));
    let epoch = epoch.and_then(|epoch| epoch.numbers.first());
    let kind = match epoch {
        Some(_) => "DynamicGeodeticReferenceFrame",
        None => "GeodeticReferenceFrame",
    };
    let frame = with(frame(kind, datum)?, "ellipsoid", Some(ellipsoid(datum)?));
    let frame = with(frame, "frame_reference_epoch", epoch.map(|epoch| json!(epoch)));
    Some(("datum", with(frame, "prime_meridian", prime_meridian(node, unit)?)))
}

fn datum_ensemble(node: &Node) -> Option<Value> {
    let members = node.children.iter().filter(|child| child.keyword == "MEMBER");
    let members: Option<Vec<_>> = members
        .map(|member| Some(with(json!({"name": member.texts.first()?}), "id", id(member))))
        .collect();
    let accuracy = node.child(&["ENSEMBLEACCURACY"])?.numbers.first()?;
    let ensemble = json!({
        "name": node.texts.first()?,
        "members": members?,
        "ellipsoid": ellipsoid(node)?,
        "accuracy": accuracy.to_string(),
    });
    Some(with(ensemble, "id", id(node)))
}

fn ellipsoid(datum: &Node) -> Option<Value> {
    let node = datum.child(&["SPHEROID", "ELLIPSOID"])?;
    let &[semi_major, flattening, ..] = &node.numbers[..] else {
        return None;
    };
    if !(semi_major > 0.0 && flattening >= 0.0) {
        return None;
    }
    let semi_major = length(node).map_or(json!(semi_major), |unit| unit.value(semi_major, "metre"));
    let name = node.texts.first()?;
    let ellipsoid = match flattening {
        // A sphere.
        0.0 => json!({"name": name, "radius": semi_major}),
        _ => json!({"name": name, "semi_major_axis": semi_major, "inverse_flattening": flattening}),
    };
    Some(with(ellipsoid, "id", id(node)))
}

/// Returns the prime meridian of a system, `None` within if it is that of Greenwich.
fn prime_meridian(node: &Node, unit: &Measure) -> Option<Option<Value>> {
    /// Longitude of Paris in degrees, which is written so even where the unit is the grad. There are
    /// two values of it; in grads, it is 2.5969.
    const PARIS: f64 = 2.3372;
    let Some(meridian) = node.child(&["PRIMEM", "PRIMEMERIDIAN"]) else {
        return Some(None);
    };
    let &longitude = meridian.numbers.first()?;
    if longitude == 0.0 {
        return Some(None);
    }
    let own = angle(meridian);
    let unit = match &own {
        Some(own) => own,
        None if (longitude - PARIS).abs() < 1e-4 => &degree(),
        None => unit,
    };
    let meridian_object = json!({"name": meridian.texts.first()?, "longitude": unit.value(longitude, "degree")});
    Some(Some(with(meridian_object, "id", id(meridian))))
}

/// Returns a meridian along which an axis points.
pub fn meridian(node: &Node) -> Option<Value> {
    let &longitude = node.numbers.first()?;
    Some(json!({"longitude": angle(node)?.value(longitude, "degree")}))
}
