//! The geometries of a feature table: a header of GeoPackage, then WKB.

use crate::input::formats::shapes::{Feature, Kind};
use geo_traits::{
    CoordTrait, Dimensions, GeometryCollectionTrait, GeometryTrait, GeometryType, LineStringTrait,
    MultiLineStringTrait, MultiPointTrait, MultiPolygonTrait, PointTrait, PolygonTrait,
};
use wkb::reader::{Wkb, read_wkb};

/// The bytes of the header before the bounds.
const HEADER: usize = 8;

/// Adds a geometry. Returns what is wrong with it.
pub fn add_blob(blob: &[u8], into: &mut Feature) -> Result<(), String> {
    let wkb = after_header(blob)?;
    let geometry = read_wkb(wkb).map_err(|error| format!("{error}; curves and surfaces are not read"))?;
    add(&geometry, into);
    Ok(())
}

/// Returns the bytes after the header.
fn after_header(blob: &[u8]) -> Result<&[u8], String> {
    let flags = match blob.first_chunk::<HEADER>() {
        Some([b'G', b'P', 0, flags, ..]) => *flags,
        _ => return Err("it does not begin as geometries of a GeoPackage do".to_owned()),
    };
    if flags & 0x20 != 0 {
        return Err("it is of a type that an extension defines".to_owned());
    }
    let numbers = match (flags >> 1) & 7 {
        0 => 0,
        1 => 4,
        2 | 3 => 6,
        4 => 8,
        other => return Err(format!("there are no bounds of type {other}")),
    };
    blob.get(HEADER + 8 * numbers..)
        .ok_or_else(|| "it is cut short".to_owned())
}

/// Adds a geometry, or all those of a collection. The crate has bounded their nesting.
fn add(geometry: &Wkb, into: &mut Feature) {
    let has_z = matches!(geometry.dim(), Dimensions::Xyz | Dimensions::Xyzm);
    let kind = match geometry.as_type() {
        GeometryType::Point(point) => {
            add_point(point, into);
            Kind::Point
        }
        GeometryType::MultiPoint(points) => {
            points.points().for_each(|point| add_point(&point, into));
            Kind::MultiPoint
        }
        GeometryType::LineString(line) => {
            add_line(line, 0, into);
            Kind::LineString
        }
        GeometryType::MultiLineString(lines) => {
            let lines = lines.line_strings().zip(0..);
            lines.for_each(|(line, number)| add_line(&line, number, into));
            Kind::MultiLineString
        }
        GeometryType::Polygon(polygon) => {
            add_polygon(polygon, into);
            Kind::Polygon
        }
        GeometryType::MultiPolygon(polygons) => {
            polygons.polygons().for_each(|polygon| add_polygon(&polygon, into));
            Kind::MultiPolygon
        }
        GeometryType::GeometryCollection(parts) => {
            parts.geometries().for_each(|part| add(part, into));
            return;
        }
        // Types that WKB does not have.
        GeometryType::Rect(_) | GeometryType::Triangle(_) | GeometryType::Line(_) => return,
    };
    into.end_geometry(kind, has_z);
}

fn add_coord(coord: &impl CoordTrait<T = f64>, into: &mut Feature) {
    // The third is m where there is no z, and does not count then.
    into.position(coord.x(), coord.y(), coord.nth(2).unwrap_or(f64::NAN));
}

/// Adds a point, unless it is empty.
fn add_point(point: &impl PointTrait<T = f64>, into: &mut Feature) {
    if let Some(coord) = point.coord() {
        add_coord(&coord, into);
    }
}

fn add_line(line: &impl LineStringTrait<T = f64>, number: u64, into: &mut Feature) {
    line.coords().for_each(|coord| add_coord(&coord, into));
    into.end_line(number);
}

fn add_polygon(polygon: &impl PolygonTrait<T = f64>, into: &mut Feature) {
    let rings = polygon.exterior().into_iter().chain(polygon.interiors());
    rings.zip(0..).for_each(|(ring, number)| add_line(&ring, number, into));
}
