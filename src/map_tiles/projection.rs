//! The way between the coordinates of a file, longitudes and latitudes, and Web Mercator.
//!
//! Coordinates of files have x in the east, whatever order of axes their system names: so do all
//! formats of points that the library reads. The datum shift is that of PROJ.4: three or seven
//! parameters, no grids. Between NAD83 and WGS 84 there is none.

use std::f64::consts::PI;

use proj4rs::Proj;
use proj4rs::transform::transform;

use crate::crs::{Crs, epsg};
use crate::geometry::{Point, Rect};
use crate::map_tiles::drawn::NoGrid;

/// The radius of the sphere of Web Mercator, in metres.
const RADIUS: f64 = 6_378_137.0;
/// Half the side of the square of Web Mercator, in metres.
const HALF: f64 = PI * RADIUS;
/// WGS 84, in longitude and latitude.
const WGS84: &str = "+proj=longlat +datum=WGS84 +no_defs";

/// How coordinates of a file become places on Earth.
pub(super) struct Projection {
    way: Way,
    /// What is added to longitudes of the file, so that they are those of maps: 0, or -360 for a
    /// file that counts them from 0 to 360.
    turn: f64,
}

enum Way {
    /// The file is in Web Mercator itself.
    Mercator,
    /// The file is in another projection, or in longitude and latitude of another datum.
    Through {
        file: Box<Proj>,
        earth: Box<Proj>,
        is_degrees: bool,
    },
    /// The file is in longitude and latitude, in degrees.
    Degrees,
}

impl Projection {
    /// Returns the projection of a coordinate reference system.
    pub(super) fn of(crs: &Crs, bounds: Rect) -> Result<Self, NoGrid> {
        let way = Way::of(crs)?;
        let is_east = way.is_degrees() && (bounds.min_x + bounds.max_x) / 2.0 > 180.0;
        Ok(Self {
            way,
            turn: if is_east { -360.0 } else { 0.0 },
        })
    }
    /// Returns whether the coordinates of the file are longitudes and latitudes.
    pub(super) fn is_geographic(&self) -> bool {
        self.way.is_degrees()
    }

    /// Returns whether a point takes more than some arithmetic.
    pub(super) fn is_slow(&self) -> bool {
        matches!(self.way, Way::Through { .. })
    }

    /// Returns whether the file is in Web Mercator.
    pub(super) fn is_mercator(&self) -> bool {
        matches!(self.way, Way::Mercator)
    }

    /// Returns the longitude and latitude of a point of the file, in degrees.
    pub(super) fn to_lon_lat(&self, p: Point) -> Option<[f64; 2]> {
        let lon_lat = match &self.way {
            Way::Degrees => [p.x, p.y],
            Way::Mercator => lon_lat_of_fraction(fraction_of_mercator(p)),
            Way::Through {
                file,
                earth,
                is_degrees,
            } => {
                let mut at = match is_degrees {
                    true => (p.x.to_radians(), p.y.to_radians(), 0.0),
                    false => (p.x, p.y, 0.0),
                };
                transform(file, earth, &mut at).ok()?;
                [at.0.to_degrees(), at.1.to_degrees()]
            }
        };
        let lon_lat = [lon_lat[0] + self.turn, lon_lat[1]];
        let is_on_earth = lon_lat[0].abs() <= 360.0 && lon_lat[1].abs() <= 90.0;
        is_on_earth.then_some(lon_lat)
    }

    /// Returns the point of the file at a longitude and latitude in degrees.
    pub(super) fn of_lon_lat(&self, [lon, lat]: [f64; 2]) -> Option<Point> {
        let lon = lon - self.turn;
        let p = match &self.way {
            Way::Degrees => Point::new(lon, lat),
            Way::Mercator => mercator_of_fraction(fraction_of_lon_lat([lon, lat])),
            Way::Through {
                file,
                earth,
                is_degrees,
            } => {
                let mut at = (lon.to_radians(), lat.to_radians(), 0.0);
                transform(earth, file, &mut at).ok()?;
                match is_degrees {
                    true => Point::new(at.0.to_degrees(), at.1.to_degrees()),
                    false => Point::new(at.0, at.1),
                }
            }
        };
        (p.x.is_finite() && p.y.is_finite()).then_some(p)
    }

    /// Returns the place of a point of the file in the square of Web Mercator: shares of its side
    /// from the west and from the north.
    pub(super) fn to_mercator(&self, p: Point) -> Option<[f64; 2]> {
        let [x, y] = match self.way {
            Way::Mercator => fraction_of_mercator(p),
            _ => fraction_of_lon_lat(self.to_lon_lat(p)?),
        };
        (x.is_finite() && y.is_finite()).then_some([x, y])
    }

    /// Returns the point of the file at a place in the square of Web Mercator.
    pub(super) fn of_mercator(&self, fraction: [f64; 2]) -> Option<Point> {
        match self.way {
            Way::Mercator => Some(mercator_of_fraction(fraction)),
            _ => self.of_lon_lat(lon_lat_of_fraction(fraction)),
        }
    }

    /// Returns the points of the file at all places in these columns and rows of the square of Web
    /// Mercator, row by row: the same as [`of_mercator`](Self::of_mercator), and NaN for `None`.
    pub(super) fn of_mercators(&self, columns: &[f64], rows: &[f64]) -> Vec<Point> {
        const NONE: Point = Point::new(f64::NAN, f64::NAN);
        if matches!(self.way, Way::Mercator) {
            let all = rows
                .iter()
                .flat_map(|&y| columns.iter().map(move |&x| mercator_of_fraction([x, y])));
            return all.collect();
        }
        // Longitudes depend on the column only, and latitudes on the row.
        let lon: Vec<f64> = columns.iter().map(|&x| lon_lat_of_fraction([x, 0.5])[0]).collect();
        let lat = rows.iter().map(|&y| lon_lat_of_fraction([0.5, y])[1]);
        let all = lat.flat_map(|lat| lon.iter().map(move |&lon| [lon, lat]));
        all.map(|lon_lat| self.of_lon_lat(lon_lat).unwrap_or(NONE)).collect()
    }
}

impl Way {
    fn of(crs: &Crs) -> Result<Self, NoGrid> {
        let unsupported = |reason: String| NoGrid::Unsupported {
            crs: crs.summary(),
            reason,
        };
        if crs.epsg() == Some(3857) {
            return Ok(Self::Mercator);
        }
        if matches!(crs.epsg(), Some(4326 | 4258 | 4269)) {
            return Ok(Self::Degrees);
        }
        let definition = match crs.epsg().and_then(definition) {
            Some(definition) => definition,
            None => {
                let wkt = crs
                    .wkt()
                    .ok_or_else(|| unsupported("it has no definition".to_owned()))?;
                proj4wkt::wkt_to_projstring(&wkt).map_err(|error| unsupported(error.to_string()))?
            }
        };
        let proj = |text: &str| Proj::from_proj_string(text).map_err(|error| unsupported(error.to_string()));
        let (file, earth) = (proj(&definition)?, proj(WGS84)?);
        let is_known = file.is_latlong() || file.has_inverse() && file.has_forward();
        if !is_known || file.is_geocent() {
            return Err(unsupported("its projection has no inverse".to_owned()));
        }
        Ok(Self::Through {
            is_degrees: file.is_latlong(),
            file: Box::new(file),
            earth: Box::new(earth),
        })
    }

    /// Returns whether the coordinates are longitudes and latitudes.
    fn is_degrees(&self) -> bool {
        matches!(self, Self::Degrees | Self::Through { is_degrees: true, .. })
    }
}

/// Returns the definition of an EPSG code as PROJ.4 has it.
fn definition(code: u32) -> Option<String> {
    let definition = epsg::definition(code)?;
    Some(definition.proj4).filter(|text| !text.is_empty())
}

fn fraction_of_mercator(p: Point) -> [f64; 2] {
    [0.5 + p.x / (2.0 * HALF), 0.5 - p.y / (2.0 * HALF)]
}

fn mercator_of_fraction([x, y]: [f64; 2]) -> Point {
    Point::new((x - 0.5) * (2.0 * HALF), (0.5 - y) * (2.0 * HALF))
}

/// Returns the place of a longitude and latitude in the square of Web Mercator. Poles are at
/// infinity.
fn fraction_of_lon_lat([lon, lat]: [f64; 2]) -> [f64; 2] {
    [0.5 + lon / 360.0, 0.5 - lat.to_radians().sin().atanh() / (2.0 * PI)]
}

/// Returns the longitude and latitude of a place in the square of Web Mercator, in degrees.
pub(super) fn lon_lat_of_fraction([x, y]: [f64; 2]) -> [f64; 2] {
    let lat = ((0.5 - y) * (2.0 * PI)).sinh().atan();
    [(x - 0.5) * 360.0, lat.to_degrees()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn both_ways(crs: &str, p: Point, lon_lat: [f64; 2]) {
        let projection = Projection::of(&Crs::new(crs), Rect::EMPTY).unwrap();
        let [lon, lat] = projection.to_lon_lat(p).unwrap();
        assert!(
            (lon - lon_lat[0]).abs() < 1e-6 && (lat - lon_lat[1]).abs() < 1e-6,
            "{crs}: {lon} {lat}"
        );
        let there = projection.of_mercator(projection.to_mercator(p).unwrap()).unwrap();
        let far = (there.x - p.x).abs().max((there.y - p.y).abs());
        assert!(far < 1e-6 * p.x.abs().max(1.0), "{crs}: {there:?}");
    }

    #[test]
    fn known_places_are_where_they_are() {
        // Computed with PROJ 9: `cs2cs EPSG:… EPSG:4326`.
        both_ways(
            "EPSG:3857",
            Point::new(1_113_194.907_932_735_5, 6_446_275.841_017_161),
            [10.0, 50.0],
        );
        both_ways("EPSG:32632", Point::new(500_000.0, 5_538_630.702_867_8), [9.0, 50.0]);
        both_ways("OGC:CRS84", Point::new(9.0, 50.0), [9.0, 50.0]);
    }

    #[test]
    fn feet_are_not_metres() {
        // EPSG:2992 and EPSG:2994 have international feet, and their metres are those of EPSG:2991.
        let [metres, feet] = ["EPSG:2991", "EPSG:2992"].map(|crs| Projection::of(&Crs::new(crs), Rect::EMPTY).unwrap());
        let at = metres.to_lon_lat(Point::new(194_000.0, 259_000.0)).unwrap();
        let same = feet
            .to_lon_lat(Point::new(194_000.0 / 0.3048, 259_000.0 / 0.3048))
            .unwrap();
        assert!((at[0] - same[0]).abs() < 1e-9 && (at[1] - same[1]).abs() < 1e-9);
    }

    #[test]
    fn what_is_unknown_is_said() {
        let error = |crs: &str| Projection::of(&Crs::new(crs), Rect::EMPTY).err().unwrap();
        assert!(matches!(error("a map of the moon"), NoGrid::Unsupported { .. }));
        assert!(matches!(error("EPSG:4978"), NoGrid::Unsupported { .. }));
        assert!(matches!(
            error(r#"LOCAL_CS["site",UNIT["metre",1]]"#),
            NoGrid::Unsupported { .. }
        ));
    }
}
