//! The methods of projections: their names in WKT 1 and in the EPSG dataset.
//!
//! Sources: EPSG guidance note 7-2; the names of WKT 1 are those of GDAL
//! (<https://gdal.org/proj_list>) and of ESRI.

use crate::crs::wkt::Node;

/// What a parameter measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    Angle,
    Length,
    Ratio,
}

/// A parameter of a method.
#[derive(Debug)]
pub struct Parameter {
    pub name: &'static str,
    pub code: u32,
    pub quantity: Quantity,
    /// Its names in WKT 1, without other characters than letters and digits.
    pub first_version: &'static [&'static str],
    /// An angle of 0 may be omitted.
    pub may_be_omitted: bool,
}

/// A method of projecting.
#[derive(Debug)]
pub struct Method {
    pub name: &'static str,
    pub code: u32,
    pub parameters: &'static [Parameter],
}

/// The code of the angle between the grid and the skew grid.
pub const GRID_ANGLE: u32 = 8814;

const ORIGIN_LATITUDES: &[&str] = &["latitudeoforigin", "latitudeofcenter"];
const MERIDIANS: &[&str] = &["centralmeridian", "longitudeofcenter", "longitudeoforigin"];
const SCALE: &[&str] = &["scalefactor"];
const EAST: &[&str] = &["falseeasting"];
const NORTH: &[&str] = &["falsenorthing"];
const FIRST: &[&str] = &["standardparallel1"];

const fn angle(code: u32, name: &'static str, first_version: &'static [&'static str]) -> Parameter {
    Parameter {
        name,
        code,
        quantity: Quantity::Angle,
        first_version,
        may_be_omitted: false,
    }
}

const fn origin_latitude(code: u32, name: &'static str) -> Parameter {
    Parameter {
        may_be_omitted: true,
        ..angle(code, name, ORIGIN_LATITUDES)
    }
}

const fn offset(code: u32, name: &'static str, first_version: &'static [&'static str]) -> Parameter {
    Parameter {
        quantity: Quantity::Length,
        ..angle(code, name, first_version)
    }
}

const fn scale(code: u32, name: &'static str) -> Parameter {
    Parameter {
        quantity: Quantity::Ratio,
        ..angle(code, name, SCALE)
    }
}

const LATITUDE: Parameter = origin_latitude(8801, "Latitude of natural origin");
const LONGITUDE: Parameter = angle(8802, "Longitude of natural origin", MERIDIANS);
const SCALE_AT_ORIGIN: Parameter = scale(8805, "Scale factor at natural origin");
const EASTING: Parameter = offset(8806, "False easting", EAST);
const NORTHING: Parameter = offset(8807, "False northing", NORTH);
const CENTRE_LATITUDE: Parameter = angle(8811, "Latitude of projection centre", ORIGIN_LATITUDES);
const CENTRE_LONGITUDE: Parameter = angle(8812, "Longitude of projection centre", MERIDIANS);
const AZIMUTH: Parameter = angle(8813, "Azimuth at projection centre", &["azimuth"]);
const SKEW: Parameter = angle(GRID_ANGLE, "Angle from Rectified to Skew Grid", &["rectifiedgridangle"]);
const SCALE_AT_CENTRE: Parameter = scale(8815, "Scale factor at projection centre");
const FALSE_LATITUDE: Parameter = origin_latitude(8821, "Latitude of false origin");
const FALSE_LONGITUDE: Parameter = angle(8822, "Longitude of false origin", MERIDIANS);
const FIRST_PARALLEL: Parameter = angle(8823, "Latitude of 1st standard parallel", FIRST);
const SECOND_PARALLEL: Parameter = angle(8824, "Latitude of 2nd standard parallel", &["standardparallel2"]);
const EASTING_AT_FALSE: Parameter = offset(8826, "Easting at false origin", EAST);
const NORTHING_AT_FALSE: Parameter = offset(8827, "Northing at false origin", NORTH);
const ORIGIN_LONGITUDE: Parameter = angle(8833, "Longitude of origin", MERIDIANS);

/// The parameters of methods with a natural origin.
const NATURAL: &[Parameter] = &[LATITUDE, LONGITUDE, EASTING, NORTHING];
/// The same with a scale factor there.
const SCALED: &[Parameter] = &[LATITUDE, LONGITUDE, SCALE_AT_ORIGIN, EASTING, NORTHING];
/// The parameters of conic methods with a false origin.
const CONIC: &[Parameter] = &[
    FALSE_LATITUDE,
    FALSE_LONGITUDE,
    FIRST_PARALLEL,
    SECOND_PARALLEL,
    EASTING_AT_FALSE,
    NORTHING_AT_FALSE,
];
/// The parameters of cylindrical methods with a standard parallel.
const CYLINDRIC: &[Parameter] = &[FIRST_PARALLEL, LONGITUDE, EASTING, NORTHING];
/// The same where the parallel is 0 if it is omitted.
const EQUIDISTANT: &[Parameter] = &[
    Parameter {
        may_be_omitted: true,
        ..FIRST_PARALLEL
    },
    LONGITUDE,
    EASTING,
    NORTHING,
];
const OBLIQUE_A: &[Parameter] = &[
    CENTRE_LATITUDE,
    CENTRE_LONGITUDE,
    AZIMUTH,
    SKEW,
    SCALE_AT_CENTRE,
    EASTING,
    NORTHING,
];
const OBLIQUE_B: &[Parameter] = &[
    CENTRE_LATITUDE,
    CENTRE_LONGITUDE,
    AZIMUTH,
    SKEW,
    SCALE_AT_CENTRE,
    offset(8816, "Easting at projection centre", EAST),
    offset(8817, "Northing at projection centre", NORTH),
];
const LABORDE: &[Parameter] = &[
    CENTRE_LATITUDE,
    CENTRE_LONGITUDE,
    AZIMUTH,
    SCALE_AT_CENTRE,
    EASTING,
    NORTHING,
];
const KROVAK: &[Parameter] = &[
    CENTRE_LATITUDE,
    ORIGIN_LONGITUDE,
    angle(1036, "Co-latitude of cone axis", &["azimuth"]),
    angle(
        8818,
        "Latitude of pseudo standard parallel",
        &["pseudostandardparallel1"],
    ),
    scale(8819, "Scale factor on pseudo standard parallel"),
    EASTING,
    NORTHING,
];
/// The parameters of the polar method with a standard parallel, which GDAL calls the latitude of
/// origin.
const POLAR_B: &[Parameter] = &[
    angle(8832, "Latitude of standard parallel", &["latitudeoforigin"]),
    ORIGIN_LONGITUDE,
    EASTING,
    NORTHING,
];
/// The same in ESRI's words.
const POLAR_OF_ESRI: &[Parameter] = &[
    angle(8832, "Latitude of standard parallel", FIRST),
    ORIGIN_LONGITUDE,
    EASTING,
    NORTHING,
];
const TUNISIA: &[Parameter] = &[FALSE_LATITUDE, FALSE_LONGITUDE, EASTING_AT_FALSE, NORTHING_AT_FALSE];

/// The methods with their names in WKT 1.
static METHODS: &[(&[&str], Method)] = &[
    (
        &["transversemercator", "gausskruger"],
        method(9807, "Transverse Mercator", SCALED),
    ),
    (
        &["transversemercatorsouthorientated"],
        method(9808, "Transverse Mercator (South Orientated)", SCALED),
    ),
    (
        &["lambertconformalconic1sp"],
        method(9801, "Lambert Conic Conformal (1SP)", SCALED),
    ),
    (
        &["lambertconformalconic2sp"],
        method(9802, "Lambert Conic Conformal (2SP)", CONIC),
    ),
    (
        &["lambertconformalconic2spbelgium"],
        method(9803, "Lambert Conic Conformal (2SP Belgium)", CONIC),
    ),
    (&["mercator1sp"], method(9804, "Mercator (variant A)", SCALED)),
    (
        &["mercator2sp", "mercator"],
        method(9805, "Mercator (variant B)", CYLINDRIC),
    ),
    (
        &["mercatorauxiliarysphere", "popularvisualisationpseudomercator"],
        method(1024, "Popular Visualisation Pseudo Mercator", NATURAL),
    ),
    (&["cassinisoldner", "cassini"], method(9806, "Cassini-Soldner", NATURAL)),
    (
        &["obliquestereographic", "doublestereographic"],
        method(9809, "Oblique Stereographic", SCALED),
    ),
    (
        &["polarstereographic"],
        method(9810, "Polar Stereographic (variant A)", SCALED),
    ),
    (
        &["polarstereographicb"],
        method(9829, "Polar Stereographic (variant B)", POLAR_B),
    ),
    (
        &["stereographicnorthpole", "stereographicsouthpole"],
        method(9829, "Polar Stereographic (variant B)", POLAR_OF_ESRI),
    ),
    (&["newzealandmapgrid"], method(9811, "New Zealand Map Grid", NATURAL)),
    (
        &["hotineobliquemercator", "hotineobliquemercatorazimuthnaturalorigin"],
        method(9812, "Hotine Oblique Mercator (variant A)", OBLIQUE_A),
    ),
    (
        &["hotineobliquemercatorazimuthcenter"],
        method(9815, "Hotine Oblique Mercator (variant B)", OBLIQUE_B),
    ),
    (
        &["labordeobliquemercator"],
        method(9813, "Laborde Oblique Mercator", LABORDE),
    ),
    (&["tunisiamininggrid"], method(9816, "Tunisia Mining Grid", TUNISIA)),
    (&["polyconic"], method(9818, "American Polyconic", NATURAL)),
    (&["krovak"], method(9819, "Krovak", KROVAK)),
    (&["krovaknorth"], method(1041, "Krovak (North Orientated)", KROVAK)),
    (
        &["lambertazimuthalequalarea"],
        method(9820, "Lambert Azimuthal Equal Area", NATURAL),
    ),
    (
        &["lambertazimuthalequalareasphere"],
        method(1027, "Lambert Azimuthal Equal Area (Spherical)", NATURAL),
    ),
    (
        &["albersconicequalarea", "albers"],
        method(9822, "Albers Equal Area", CONIC),
    ),
    (
        &["azimuthalequidistant"],
        method(9832, "Modified Azimuthal Equidistant", NATURAL),
    ),
    (
        &["cylindricalequalarea"],
        method(9835, "Lambert Cylindrical Equal Area", CYLINDRIC),
    ),
    (
        &["cylindricalequalareasphere"],
        method(9834, "Lambert Cylindrical Equal Area (Spherical)", CYLINDRIC),
    ),
    (
        &["equirectangular", "equidistantcylindrical"],
        method(1028, "Equidistant Cylindrical", EQUIDISTANT),
    ),
    (
        &["equirectangularsphere", "equidistantcylindricalsphere"],
        method(1029, "Equidistant Cylindrical (Spherical)", EQUIDISTANT),
    ),
];

const fn method(code: u32, name: &'static str, parameters: &'static [Parameter]) -> Method {
    Method { name, code, parameters }
}

/// Returns the letters and digits of a name, in lower case.
pub fn letters(name: &str) -> String {
    let letters = name.chars().filter(char::is_ascii_alphanumeric);
    letters.map(|c| c.to_ascii_lowercase()).collect()
}

/// Returns the method of a projected system in WKT 1 with a base and the values of its parameters.
pub fn of(node: &Node, base: &Node, given: &[(String, f64)]) -> Option<&'static Method> {
    let name = letters(node.child(&["PROJECTION"])?.texts.first()?);
    let name = variant(name, node, base, given)?;
    let has_name = |(names, _): &&(&[&str], Method)| names.contains(&&*name);
    METHODS.iter().find(has_name).map(|(_, method)| method)
}

/// Returns the name of the variant of a method, where one name of WKT 1 stands for several.
fn variant(name: String, node: &Node, base: &Node, given: &[(String, f64)]) -> Option<String> {
    let value = |of: &str| given.iter().find(|(name, _)| name == of).map(|&(_, value)| value);
    let extension = node.child(&["EXTENSION"]).and_then(|extension| extension.texts.get(1));
    let is_sphere = || {
        let datum = base.child(&["DATUM"])?;
        Some(datum.child(&["SPHEROID"])?.numbers.get(1) == Some(&0.0))
    };
    Some(match (&*name, extension) {
        // Longitudes and latitudes of the ellipsoid taken for those of a sphere, for map tiles.
        ("mercator1sp", Some(text)) if text.contains("+proj=merc +a=6378137 +b=6378137 ") => {
            "popularvisualisationpseudomercator".to_owned()
        }
        (_, Some(_)) => return None,
        ("polarstereographic", _) => {
            let is_pole = value("latitudeoforigin")?.abs() == 90.0;
            let is_scaled = value("scalefactor").is_some_and(|scale| scale != 1.0);
            if is_pole || is_scaled { name } else { name + "b" }
        }
        ("lambertconformalconic", _) => {
            let one = value("standardparallel2").is_none() && value("standardparallel1") == value("latitudeoforigin");
            name + if one { "1sp" } else { "2sp" }
        }
        // Only the axes tell.
        ("krovak", _) => match &*node.child(&["AXIS"])?.words.first()?.to_ascii_lowercase() {
            "south" => name,
            _ => "krovaknorth".to_owned(),
        },
        ("lambertazimuthalequalarea" | "cylindricalequalarea" | "equirectangular" | "equidistantcylindrical", _)
            if is_sphere()? =>
        {
            name + "sphere"
        }
        _ => name,
    })
}
