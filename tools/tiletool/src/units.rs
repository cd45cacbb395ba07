//! Numbers for people, and the units of distances and areas.
//!
//! The unit comes from the coordinate reference system of the tile file. Only names, factors and
//! codes with one meaning are used. All other coordinates are in coordinate units.

use std::f64::consts::PI;
use std::path::Path;

use delaunay_tiles::geometry::Rect;
use delaunay_tiles::input::Format;
use delaunay_tiles::store::{ReadError, TileReader};

/// The unit of the coordinates of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    Metre,
    Kilometre,
    Foot,
    /// 1200/3937 m.
    UsSurveyFoot,
    /// An angle: the coordinates are a longitude and a latitude.
    Degree,
    Unknown,
}

impl Unit {
    /// Returns the unit of the coordinates of a file. Reads no list that is not needed for it.
    ///
    /// # Errors
    /// Fails if a list of the file cannot be read.
    pub async fn of_file(reader: &TileReader) -> Result<Self, ReadError> {
        if let Some(crs) = reader.crs().await? {
            return Ok(Self::of(&crs));
        }
        let bounds = reader.metadata().bounds;
        let sources = reader.sources().await?;
        if !sources.iter().all(|source| may_be_degrees(&source.name, bounds)) {
            return Ok(Self::Unknown);
        }
        let lists = reader.lists().await?;
        let is_plain = lists.lines.iter().all(|lines| may_be_degrees(&lines.name, bounds));
        Ok(match is_plain && !(sources.is_empty() && lists.lines.is_empty()) {
            true => Self::Degree,
            false => Self::Unknown,
        })
    }

    /// Returns the unit of a coordinate reference system.
    pub fn of(crs: &str) -> Self {
        let unit = match crs.contains(['[', '(']) {
            true => of_wkt(crs),
            false => of_name(crs),
        };
        unit.unwrap_or(Self::Unknown)
    }

    /// Returns the name of the unit, in the plural.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Metre => "m",
            Self::Kilometre => "km",
            Self::Foot => "ft",
            Self::UsSurveyFoot => "US survey ft",
            Self::Degree => "degrees",
            Self::Unknown => "coordinate units",
        }
    }

    /// Formats a distance with its unit.
    pub fn distance(self, distance: f64) -> String {
        let number = number(distance);
        let name = match (self, &*number) {
            (Self::Degree, "1") => "degree",
            (Self::Unknown, "1") => "coordinate unit",
            _ => self.name(),
        };
        format!("{number} {name}")
    }

    /// Formats an area with its unit.
    pub fn area(self, area: f64) -> String {
        match self {
            Self::Degree | Self::Unknown => format!("{} square {}", number(area), self.name()),
            _ => format!("{} {}²", number(area), self.name()),
        }
    }

    /// Returns what a user of distances must know about this unit.
    pub const fn warning(self) -> Option<&'static str> {
        match self {
            Self::Degree => {
                Some("the coordinates are degrees, so distances are in degrees, not metres; project the data first")
            }
            _ => None,
        }
    }
}

/// Formats a number for people: six significant digits, all digits before the point, and no
/// trailing zeros. Very small and very large numbers have an exponent.
pub fn number(v: f64) -> String {
    let magnitude = v.abs();
    if magnitude == 0.0 {
        return "0".to_owned();
    } else if !v.is_finite() {
        return v.to_string();
    }
    if !(1e-5..1e15).contains(&magnitude) {
        let text = format!("{v:.5e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{exponent}", without_zeros(digits));
    }
    let decimals = (5 - magnitude.log10().floor() as i32).clamp(0, 10) as usize;
    without_zeros(&format!("{v:.decimals$}")).to_owned()
}

/// Returns a decimal number without zeros at its end.
fn without_zeros(text: &str) -> &str {
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => text,
    }
}

/// Returns whether a file that names no reference system has degrees: GeoJSON whose coordinates can
/// be degrees. RFC 7946 says that they are.
fn may_be_degrees(name: &str, bounds: Rect) -> bool {
    Format::from_path(Path::new(name)) == Some(Format::GeoJson)
        && (-180.0..=180.0).contains(&bounds.min_x)
        && (-180.0..=180.0).contains(&bounds.max_x)
        && (-90.0..=90.0).contains(&bounds.min_y)
        && (-90.0..=90.0).contains(&bounds.max_y)
}

/// Returns the unit of a reference system given by a name or a code, such as `EPSG:25832` or
/// `urn:ogc:def:crs:OGC:1.3:CRS84`.
fn of_name(name: &str) -> Option<Unit> {
    let name = name.trim().to_ascii_uppercase();
    let parts: Vec<&str> = name.split([':', '/']).collect();
    let (&code, authority) = parts.split_last()?;
    if authority.contains(&"OGC") && matches!(code, "CRS84" | "CRS83" | "CRS27") {
        return Some(Unit::Degree);
    }
    let code: u32 = code.parse().ok().filter(|_| authority.contains(&"EPSG"))?;
    match code {
        // WGS 84, ETRS89, NAD83, NAD27.
        4326 | 4258 | 4269 | 4267 => Some(Unit::Degree),
        // UTM: WGS 84 north and south, ETRS89, NAD83. LAEA Europe.
        32601..=32660 | 32701..=32760 | 25828..=25838 | 26901..=26923 | 3035 => Some(Unit::Metre),
        _ => None,
    }
}

/// Returns the unit of a projected or geographic reference system in WKT 1 or WKT 2.
fn of_wkt(text: &str) -> Option<Unit> {
    let (mut open, mut word): (Vec<String>, String) = (Vec::new(), String::new());
    // The depth of the first reference system of the horizontal plane, and whether it is projected.
    let mut system = None;
    let mut is_quoted = false;
    for c in text.chars() {
        match c {
            '"' => is_quoted = !is_quoted,
            _ if is_quoted => {}
            '[' | '(' => {
                open.push(std::mem::take(&mut word).to_ascii_uppercase());
                system = system.or_else(|| Some((open.len(), is_projected(open.last()?)?)));
            }
            ',' | ']' | ')' => {
                if let (Some((depth, is_projected)), Ok(factor)) = (system, word.parse()) {
                    let node = open.get(depth..).unwrap_or_default().iter().map(String::as_str);
                    match (&node.collect::<Vec<_>>()[..], is_projected) {
                        (["UNIT" | "LENGTHUNIT"] | ["AXIS", "UNIT" | "LENGTHUNIT"], true) => return of_length(factor),
                        (["UNIT" | "ANGLEUNIT"] | ["AXIS", "UNIT" | "ANGLEUNIT"], false) => return of_angle(factor),
                        _ => {}
                    }
                }
                word.clear();
                if c != ',' {
                    open.pop();
                }
                if system.is_some_and(|(depth, _)| open.len() < depth) {
                    return None;
                }
            }
            c if c.is_whitespace() => {}
            c => word.push(c),
        }
    }
    None
}

/// Returns whether a reference system is in the plane; `None` for other keywords.
fn is_projected(keyword: &str) -> Option<bool> {
    match keyword {
        "PROJCS" | "PROJCRS" | "PROJECTEDCRS" | "LOCAL_CS" | "ENGCRS" | "ENGINEERINGCRS" => Some(true),
        "GEOGCS" | "GEOGCRS" | "GEOGRAPHICCRS" | "GEODCRS" | "GEODETICCRS" => Some(false),
        _ => None,
    }
}

/// Returns the unit with this number of metres.
fn of_length(factor: f64) -> Option<Unit> {
    let units = [
        (1.0, Unit::Metre),
        (1000.0, Unit::Kilometre),
        (0.3048, Unit::Foot),
        (1200.0 / 3937.0, Unit::UsSurveyFoot),
    ];
    // Both kinds of foot differ by two millionths.
    let is_it = |(metres, _): &(f64, Unit)| (factor - metres).abs() <= 1e-7 * metres;
    units.into_iter().find(is_it).map(|(_, unit)| unit)
}

/// Returns the unit with this number of radians.
fn of_angle(factor: f64) -> Option<Unit> {
    ((factor - PI / 180.0).abs() <= 1e-8).then_some(Unit::Degree)
}

#[cfg(test)]
mod tests {
    use super::*;

    const UTM: &str = r#"PROJCS["WGS 84 / UTM zone 32N",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["false_easting",500000],UNIT["metre",1,AUTHORITY["EPSG","9001"]],AXIS["Easting",EAST]]"#;

    fn unit(crs: &str) -> Unit {
        Unit::of(crs)
    }

    #[test]
    fn numbers_have_six_significant_digits() {
        for (v, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (8.0, "8"),
            (-1.5, "-1.5"),
            (2f64.sqrt(), "1.41421"),
            (0.1 + 0.2, "0.3"),
            (9.999_999_9, "10"),
            (1_234.567_89, "1234.57"),
            (1_234_567.89, "1234568"),
            (0.000_012_345_678, "0.0000123457"),
            (1e-7, "1e-7"),
            (1.234_567_8e-7, "1.23457e-7"),
            (1e20, "1e20"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(number(v), text);
        }
    }

    #[test]
    fn distances_and_areas_name_their_units() {
        assert_eq!(Unit::Metre.distance(12.5), "12.5 m");
        assert_eq!(Unit::Metre.area(12.5), "12.5 m²");
        assert_eq!(Unit::Degree.distance(1.0), "1 degree");
        assert_eq!(Unit::Unknown.distance(0.5), "0.5 coordinate units");
        assert_eq!(Unit::Unknown.area(2.0), "2 square coordinate units");
        assert!(Unit::Degree.warning().is_some() && Unit::Metre.warning().is_none());
    }

    #[test]
    fn wkt_of_both_versions_names_the_horizontal_unit() {
        assert_eq!(unit(UTM), Unit::Metre);
        assert_eq!(
            unit(&UTM.replace(r#""metre",1,"#, r#""Foot_US", 0.304800609601219,"#)),
            Unit::UsSurveyFoot
        );
        assert_eq!(unit(&UTM.replace(r#""metre",1,"#, r#""foot",0.3048,"#)), Unit::Foot);
        assert_eq!(
            unit(&UTM.replace(r#""metre",1,"#, r#""link",0.201168,"#)),
            Unit::Unknown
        );
        let with_height = format!(
            r#"COMPD_CS["both, [and]",{UTM},VERT_CS["height",VERT_DATUM["d",2005],UNIT["US survey foot",0.3048006096]]]"#
        );
        assert_eq!(unit(&with_height), Unit::Metre);
        let geographic =
            r#"GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.25]],UNIT["degree",0.0174532925199433]]"#;
        assert_eq!(unit(geographic), Unit::Degree);
        let second = r#"PROJCRS["ETRS89 / LCC",BASEGEOGCRS["ETRS89",DATUM["d",ELLIPSOID["GRS 1980",6378137,298.257,LENGTHUNIT["metre",1]]],PRIMEM["Greenwich",0,ANGLEUNIT["degree",0.0174532925199433]]],CONVERSION["c",METHOD["m"],PARAMETER["p",0,LENGTHUNIT["metre",1]]],CS[Cartesian,2],AXIS["easting (E)",east,ORDER[1],LENGTHUNIT["kilometre",1000]],AXIS["northing (N)",north,LENGTHUNIT["kilometre",1000]]]"#;
        assert_eq!(unit(second), Unit::Kilometre);
        let geodetic = r#"GEOGCRS["WGS 84 3D", DATUM["d",ELLIPSOID["e",6378137,298.25,LENGTHUNIT["metre",1.0]]], CS[ellipsoidal,3], AXIS["lat",north], AXIS["h",up,LENGTHUNIT["metre",1]], ANGLEUNIT["degree",0.0174532925199433]]"#;
        assert_eq!(unit(geodetic), Unit::Degree);
        for broken in [
            "[",
            "]]",
            "UNIT[\"metre\",1]",
            "PROJCS[\"x\"]",
            "PROJCS[\"x",
            "GEOCCS[\"x\",UNIT[\"metre\",1]]",
        ] {
            assert_eq!(unit(broken), Unit::Unknown, "{broken}");
        }
    }

    #[test]
    fn names_and_codes_with_one_meaning_have_a_unit() {
        for (name, expected) in [
            ("urn:ogc:def:crs:OGC:1.3:CRS84", Unit::Degree),
            ("http://www.opengis.net/def/crs/OGC/1.3/CRS84", Unit::Degree),
            ("EPSG:4326", Unit::Degree),
            ("urn:ogc:def:crs:EPSG::25832", Unit::Metre),
            ("epsg:32733", Unit::Metre),
            ("EPSG:4647", Unit::Unknown),
            ("32733", Unit::Unknown),
            ("my town", Unit::Unknown),
            ("", Unit::Unknown),
        ] {
            assert_eq!(unit(name), expected, "{name}");
        }
    }

    #[test]
    fn geojson_without_a_reference_system_has_degrees() {
        let bounds = |max_x| Rect::new(0.0, 0.0, max_x, 1.0);
        for (name, max_x, expected) in [
            ("a.geojson", 1.0, true),
            ("b.json.gz", 180.0, true),
            ("a.geojson", 180.5, false),
            ("b.csv", 1.0, false),
            ("-", 1.0, false),
        ] {
            assert_eq!(may_be_degrees(name, bounds(max_x)), expected, "{name} {max_x}");
        }
    }
}
