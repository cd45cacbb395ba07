//! The geometries of a feature.

use crate::input::formats::shapes::{Feature, Kind};
use ::flatgeobuf::{Geometry, GeometryType};

/// Adds a geometry of the type `kind`, or of its own type if that is unknown. Returns what is wrong
/// with it. The verifier has bounded the depth of parts in parts.
pub fn add_geometry(geometry: &Geometry, kind: GeometryType, into: &mut Feature) -> Result<(), String> {
    let kind = match kind {
        GeometryType::Unknown => geometry.type_(),
        kind => kind,
    };
    let (kind, has_z) = match kind {
        GeometryType::Point => (Kind::Point, add_positions(geometry, into)?),
        GeometryType::MultiPoint => (Kind::MultiPoint, add_positions(geometry, into)?),
        GeometryType::LineString => {
            let has_z = add_positions(geometry, into)?;
            into.end_line(0);
            (Kind::LineString, has_z)
        }
        GeometryType::MultiLineString => (Kind::MultiLineString, add_lines(geometry, into)?),
        GeometryType::Polygon => (Kind::Polygon, add_lines(geometry, into)?),
        GeometryType::MultiPolygon => (Kind::MultiPolygon, add_polygons(geometry, into)?),
        GeometryType::GeometryCollection => {
            for part in geometry.parts().iter().flatten() {
                add_geometry(&part, GeometryType::Unknown, into)?;
            }
            return Ok(());
        }
        GeometryType::Unknown => return Err("neither the file nor the geometry has a type".to_owned()),
        other => {
            let name = other.variant_name().unwrap_or("geometry of an unknown type");
            return Err(format!(
                "this is a {name}; convert curves and surfaces to lines and polygons first"
            ));
        }
    };
    into.end_geometry(kind, has_z);
    Ok(())
}

/// Adds all positions of a geometry. Returns whether they have z.
fn add_positions(geometry: &Geometry, into: &mut Feature) -> Result<bool, String> {
    let count = count(geometry)?;
    add_range(geometry, 0, count, into)
}

/// Returns the number of positions.
fn count(geometry: &Geometry) -> Result<usize, String> {
    let numbers = geometry.xy().map_or(0, |xy| xy.len());
    match numbers % 2 {
        0 => Ok(numbers / 2),
        _ => Err(format!("{numbers} coordinates are not pairs of x and y")),
    }
}

/// Adds the positions from `from` up to `to`. Returns whether they have z.
fn add_range(geometry: &Geometry, from: usize, to: usize, into: &mut Feature) -> Result<bool, String> {
    let z = geometry.z().filter(|z| !z.is_empty());
    let Some(xy) = geometry.xy().filter(|_| from < to) else {
        return Ok(z.is_some());
    };
    if let Some(z) = z
        && 2 * z.len() != xy.len()
    {
        return Err(format!("{} positions have {} values of z", xy.len() / 2, z.len()));
    }
    for n in from..to {
        let z = z.map_or(f64::NAN, |z| z.get(n));
        into.position(xy.get(2 * n), xy.get(2 * n + 1), z);
    }
    Ok(z.is_some())
}

/// Adds the lines or rings of a geometry. Returns whether they have z.
fn add_lines(geometry: &Geometry, into: &mut Feature) -> Result<bool, String> {
    let count = count(geometry)?;
    let ends = geometry.ends().filter(|ends| !ends.is_empty());
    let Some(ends) = ends else {
        let has_z = add_range(geometry, 0, count, into)?;
        if count > 0 {
            into.end_line(0);
        }
        return Ok(has_z);
    };
    let (mut from, mut has_z) = (0, false);
    for (number, end) in ends.iter().enumerate() {
        let to = end as usize;
        if to < from || to > count {
            return Err(format!("part {number} goes from position {from} to {to} of {count}"));
        }
        has_z = add_range(geometry, from, to, into)?;
        into.end_line(number as u64);
        from = to;
    }
    match from == count {
        true => Ok(has_z),
        false => Err(format!("the parts end at position {from} of {count}")),
    }
}

/// Adds the polygons of a geometry. Returns whether they have z.
fn add_polygons(geometry: &Geometry, into: &mut Feature) -> Result<bool, String> {
    let Some(parts) = geometry.parts() else {
        // Some writers have no parts where there is one polygon.
        return add_lines(geometry, into);
    };
    let mut has_z = None;
    for part in parts {
        let part_has_z = add_lines(&part, into)?;
        if count(&part)? > 0 && has_z.replace(part_has_z).is_some_and(|before| before != part_has_z) {
            return Err("some polygons have z and others have none".to_owned());
        }
    }
    Ok(has_z.unwrap_or(false))
}
