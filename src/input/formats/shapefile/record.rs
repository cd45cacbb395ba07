//! The geometry of a record.

use crate::input::formats::shapefile::rings::sort_rings;
use crate::input::formats::shapes::{Feature, Kind};
use ::shapefile::{PointZ, ReadableShape, Shape, ShapeType};
use std::io::Cursor;

/// The bytes of the type and of the bounds of a record with parts.
const BEFORE_COUNTS: usize = 4 + 32;

/// Adds the geometry of a record, which has none if it is null. Returns the number of rings that are
/// directed as holes but are in no outer ring, or what is wrong with the record.
pub fn add_record(record: &mut [u8], into: &mut Feature) -> Result<u64, String> {
    let code = number(record, 0)?;
    let kind = i32::try_from(code).ok().and_then(ShapeType::from);
    let Some(kind) = kind else {
        return Err(format!("there is no shape of type {code}"));
    };
    let is_polygon = matches!(kind, ShapeType::Polygon | ShapeType::PolygonM | ShapeType::PolygonZ);
    match kind {
        ShapeType::NullShape => return Ok(0),
        ShapeType::Multipatch => {
            return Err("this is a Multipatch; convert it to lines or polygons first".to_owned());
        }
        ShapeType::Point | ShapeType::PointM | ShapeType::PointZ => {}
        ShapeType::Multipoint | ShapeType::MultipointM | ShapeType::MultipointZ => {
            check_fit(record, 0, number(record, BEFORE_COUNTS)?, BEFORE_COUNTS + 4)?;
        }
        _ => check_parts(record)?,
    }
    if is_polygon {
        // The parts of a polygon are those of a line, whose type is two less. The crate would close
        // and direct them.
        record[0] -= 2;
    }
    let length = i32::try_from(record.len()).map_err(|_| "it is too long".to_owned())?;
    let shape = Shape::read_from(&mut Cursor::new(&*record), length).map_err(|error| error.to_string())?;
    match shape {
        Shape::Point(p) => add_points(into, [[p.x, p.y, f64::NAN]], false),
        Shape::PointM(p) => add_points(into, [[p.x, p.y, f64::NAN]], false),
        Shape::PointZ(p) => add_points(into, [[p.x, p.y, p.z]], true),
        Shape::Multipoint(p) => add_multi(into, p.points().iter().map(|p| [p.x, p.y, f64::NAN]), false),
        Shape::MultipointM(p) => add_multi(into, p.points().iter().map(|p| [p.x, p.y, f64::NAN]), false),
        Shape::MultipointZ(p) => add_multi(into, p.points().iter().map(with_z), true),
        Shape::Polyline(lines) => {
            let parts = lines.parts().iter();
            let parts = parts.map(|part| part.iter().map(|p| [p.x, p.y, f64::NAN]).collect());
            return add_parts(into, parts.collect(), is_polygon, false);
        }
        Shape::PolylineM(lines) => {
            let parts = lines.parts().iter();
            let parts = parts.map(|part| part.iter().map(|p| [p.x, p.y, f64::NAN]).collect());
            return add_parts(into, parts.collect(), is_polygon, false);
        }
        Shape::PolylineZ(lines) => {
            let parts = lines.parts().iter().map(|part| part.iter().map(with_z).collect());
            return add_parts(into, parts.collect(), is_polygon, true);
        }
        other => return Err(format!("a shape of type {} was not expected", other.shapetype())),
    }
    Ok(0)
}

fn with_z(p: &PointZ) -> [f64; 3] {
    [p.x, p.y, p.z]
}

/// Returns the little-endian number at this offset.
fn number(record: &[u8], at: usize) -> Result<u32, String> {
    let bytes = record.get(at..).and_then(|bytes| bytes.first_chunk::<4>());
    match bytes {
        Some(bytes) => Ok(u32::from_le_bytes(*bytes)),
        None => Err(format!("it has only {} bytes", record.len())),
    }
}

/// Checks that the numbers of parts and points from the offset `from` on fit into the record.
fn check_fit(record: &[u8], parts: u32, points: u32, from: usize) -> Result<(), String> {
    let needed = from as u64 + 4 * u64::from(parts) + 16 * u64::from(points);
    match needed <= record.len() as u64 {
        true => Ok(()),
        false => Err(format!(
            "{parts} parts and {points} points do not fit into {} bytes",
            record.len()
        )),
    }
}

/// Checks the numbers of parts and points, and that the parts follow each other.
fn check_parts(record: &[u8]) -> Result<(), String> {
    let (parts, points) = (number(record, BEFORE_COUNTS)?, number(record, BEFORE_COUNTS + 4)?);
    let from = BEFORE_COUNTS + 8;
    check_fit(record, parts, points, from)?;
    if parts > points {
        // In memory, an empty part takes many times the four bytes that it has in the file.
        return Err(format!("{points} points are not enough for {parts} parts"));
    }
    let mut before = 0;
    for part in 0..parts {
        let first = number(record, from + 4 * part as usize)?;
        if first < before || first > points || (part == 0 && first > 0) {
            return Err(format!("part {part} begins at point {first} of {points}"));
        }
        before = first;
    }
    Ok(())
}

fn add_points(into: &mut Feature, points: impl IntoIterator<Item = [f64; 3]>, has_z: bool) {
    points.into_iter().for_each(|[x, y, z]| into.position(x, y, z));
    into.end_geometry(Kind::Point, has_z);
}

fn add_multi(into: &mut Feature, points: impl IntoIterator<Item = [f64; 3]>, has_z: bool) {
    points.into_iter().for_each(|[x, y, z]| into.position(x, y, z));
    into.end_geometry(Kind::MultiPoint, has_z);
}

/// Adds lines, or the rings of polygons. Returns the number of rings that are directed as holes but
/// are in no outer ring.
fn add_parts(into: &mut Feature, parts: Vec<Vec<[f64; 3]>>, are_rings: bool, has_z: bool) -> Result<u64, String> {
    let mut add = |part: usize, number: usize| {
        parts[part].iter().for_each(|&[x, y, z]| into.position(x, y, z));
        into.end_line(number as u64);
    };
    if !are_rings {
        (0..parts.len()).for_each(|part| add(part, part));
        into.end_geometry(Kind::MultiLineString, has_z);
        return Ok(0);
    }
    let sorted = sort_rings(&parts)?;
    for polygon in sorted.polygons {
        let parts = polygon.into_iter().enumerate();
        parts.for_each(|(number, part)| add(part, number));
    }
    into.end_geometry(Kind::MultiPolygon, has_z);
    Ok(sorted.lone_holes)
}
