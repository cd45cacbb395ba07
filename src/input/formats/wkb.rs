//! Geometries as well-known binary (WKB), each by itself. Source: OGC 06-103r4, section 8; and the
//! variant of PostGIS (EWKB). The crate `wkb` decodes them.

use crate::input::about::Field;
use crate::input::caught::catch;
use crate::input::error::{InputError, Location};
use crate::input::formats::shapes::{Decoder, Feature, Kind};
use crate::input::watch::Reading;
use geo_traits::{
    CoordTrait, Dimensions, GeometryCollectionTrait, GeometryTrait, GeometryType, LineStringTrait,
    MultiLineStringTrait, MultiPointTrait, MultiPolygonTrait, PointTrait, PolygonTrait,
};
use std::path::Path;
use std::sync::Arc;
use wkb::reader::{Wkb, read_wkb};

/// Geometries in memory, each of them a feature. One without bytes is empty.
pub struct Geometries<I> {
    pub geometries: I,
    /// The name of the whole, for messages.
    pub name: Arc<Path>,
    pub reading: Reading,
}

impl<I: Iterator<Item = Vec<u8>> + Send> Decoder for Geometries<I> {
    fn decode(&mut self, number: u64, feature: &mut Feature) -> Result<bool, InputError> {
        self.reading.check()?;
        let Some(bytes) = self.geometries.next() else {
            return Ok(false);
        };
        if bytes.is_empty() {
            return Ok(true);
        }
        let problem = match catch(|| add(&bytes, feature)) {
            Some(Ok(())) => return Ok(true),
            Some(Err(problem)) => problem,
            None => "it cannot be decoded".to_owned(),
        };
        let location = Location::Feature(number);
        let hint = "give geometries as well-known binary (WKB)";
        Err(InputError::malformed(&self.name, location, problem, hint))
    }

    fn keep_ids(&mut self, _: &str) {}

    fn fields(&self) -> Vec<Field> {
        Vec::new()
    }

    fn crs(&self) -> Option<&str> {
        None
    }
}

/// Adds the geometry that `bytes` encode. Returns what is wrong with it.
pub fn add(bytes: &[u8], into: &mut Feature) -> Result<(), String> {
    let geometry = read_wkb(bytes).map_err(|error| format!("{error}; curves and surfaces are not read"))?;
    add_geometry(&geometry, into);
    Ok(())
}

/// Adds a geometry, or all those of a collection. The crate has bounded their nesting.
fn add_geometry(geometry: &Wkb, into: &mut Feature) {
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
            parts.geometries().for_each(|part| add_geometry(part, into));
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
