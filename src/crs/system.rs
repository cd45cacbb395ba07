//! What a description says of the system of the plane: unit, kind, projection.

use std::f64::consts::PI;

use super::code;
use super::method::Method;
use super::unit::Unit;
use super::wkt::Node;

pub const PROJECTED: [&str; 3] = ["PROJCS", "PROJCRS", "PROJECTEDCRS"];
pub const LOCAL: [&str; 3] = ["LOCAL_CS", "ENGCRS", "ENGINEERINGCRS"];
pub const GEOGRAPHIC: [&str; 5] = ["GEOGCS", "GEOGCRS", "GEOGRAPHICCRS", "GEODCRS", "GEODETICCRS"];
pub const VERTICAL: [&str; 4] = ["VERT_CS", "VERTCS", "VERTCRS", "VERTICALCRS"];
pub const COMPOUND: [&str; 3] = ["COMPD_CS", "COMPOUNDCRS", "BOUNDCRS"];

/// The facts about a system of the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct System {
    pub name: Option<String>,
    pub is_geographic: bool,
    pub unit: Unit,
    /// The method of the projection, if it has one of the usual names.
    method: Option<Method>,
    /// The parameters of the projection, lengths in metres and angles in degrees.
    parameters: Vec<(Parameter, f64)>,
}

/// A parameter that projections of all kinds of WKT have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Parameter {
    Latitude,
    Longitude,
    Scale,
    Easting,
    Northing,
    FirstParallel,
    SecondParallel,
}

/// Returns the node of the system of the plane, in that of a compound system or itself.
pub fn horizontal(root: &Node) -> Option<&Node> {
    let is_horizontal = |node: &Node| {
        let keyword = &&*node.keyword;
        PROJECTED.contains(keyword) || LOCAL.contains(keyword) || GEOGRAPHIC.contains(keyword)
    };
    if is_horizontal(root) {
        return Some(root);
    }
    if root.keyword == "SOURCECRS" || COMPOUND.contains(&&*root.keyword) {
        return root.children.iter().find_map(horizontal);
    }
    None
}

/// Returns the unit of the vertical system in that of a compound system.
pub fn height_unit(root: &Node) -> Option<Unit> {
    if VERTICAL.contains(&&*root.keyword) {
        return factor(root, &["UNIT", "LENGTHUNIT"]).map(Unit::of_length);
    }
    let is_compound = root.keyword == "SOURCECRS" || COMPOUND.contains(&&*root.keyword);
    root.children.iter().filter(|_| is_compound).find_map(height_unit)
}

/// Returns the EPSG code of a node.
pub fn epsg(node: &Node) -> Option<u32> {
    let id = node.child(&["AUTHORITY", "ID"])?;
    if !id.texts.first()?.eq_ignore_ascii_case("EPSG") {
        return None;
    }
    let code = match id.texts.get(1) {
        Some(code) => code.parse().ok()?,
        None => id.numbers.first().map(|&code| code as u32)?,
    };
    Some(code::current(code))
}

/// Returns the factor of the unit that a node contains.
fn factor(node: &Node, keywords: &[&str]) -> Option<f64> {
    let of = |node: &Node| node.child(keywords).and_then(|unit| unit.numbers.first().copied());
    of(node).or_else(|| node.child(&["AXIS"]).and_then(of))
}

impl System {
    /// Returns the facts that the node of a system of the plane contains. `None` if it is a system
    /// in space.
    pub fn of(node: &Node) -> Option<Self> {
        let is_geographic = GEOGRAPHIC.contains(&&*node.keyword);
        if node
            .child(&["CS"])
            .is_some_and(|axes| axes.numbers.first() == Some(&3.0))
            && is_cartesian(node)
        {
            return None;
        }
        let keywords = match is_geographic {
            true => ["UNIT", "ANGLEUNIT"],
            false => ["UNIT", "LENGTHUNIT"],
        };
        let factor = factor(node, &keywords);
        let unit = match (factor, is_geographic) {
            (Some(factor), true) => Unit::of_angle(factor),
            (Some(factor), false) => Unit::of_length(factor),
            (None, _) => Unit::Unknown,
        };
        let own = node.children.iter();
        let conversion = node.child(&["CONVERSION"]);
        let method = conversion.unwrap_or(node).child(&["PROJECTION", "METHOD"]);
        let conversion = conversion.map_or(&[][..], |conversion| &conversion.children);
        let parameters = own.chain(conversion).filter(|child| child.keyword == "PARAMETER");
        Some(Self {
            name: node.texts.first().cloned(),
            is_geographic,
            unit,
            method: method.and_then(|method| Method::of_name(method.texts.first()?)),
            parameters: parameters.filter_map(|node| parameter(node, factor?)).collect(),
        })
    }

    /// Returns the facts about a system that is known by its code and, maybe, its definition.
    pub fn of_code(code: u32, definition: Option<&str>) -> Option<Self> {
        if let Some(node) = definition.and_then(Node::parse) {
            return horizontal(&node).and_then(Self::of);
        }
        // Codes with one meaning, for a library without definitions: WGS 84, ETRS89, NAD83 and NAD27
        // with angles; UTM of WGS 84, ETRS89 and NAD83, European LAEA, Web Mercator in metres.
        let is_geographic = matches!(code, 4326 | 4258 | 4269 | 4267);
        let is_metric = matches!(code, 32601..=32660 | 32701..=32760 | 25828..=25838 | 26901..=26923 | 3035 | 3857);
        (is_geographic || is_metric).then_some(Self {
            name: None,
            is_geographic,
            unit: if is_geographic { Unit::Degree } else { Unit::Metre },
            method: None,
            parameters: Vec::new(),
        })
    }

    /// Returns the facts that PROJJSON tells at its beginning: whether the system is geographic.
    pub fn of_projjson(text: &str) -> Option<Self> {
        let after = text.strip_prefix('{')?.split_once("\"type\"")?.1;
        let kind = after.trim_start().strip_prefix(':')?.trim_start().strip_prefix('"')?;
        let is_geographic = match kind.split('"').next()? {
            "GeographicCRS" => true,
            "ProjectedCRS" => false,
            _ => return None,
        };
        Some(Self {
            name: None,
            is_geographic,
            unit: if is_geographic { Unit::Degree } else { Unit::Unknown },
            method: None,
            parameters: Vec::new(),
        })
    }

    /// Returns how two systems differ, if that is certain.
    pub fn conflict(&self, other: &Self) -> Option<String> {
        if self.is_geographic != other.is_geographic {
            let kind = |system: &Self| match system.is_geographic {
                true => "longitudes and latitudes",
                false => "projected coordinates",
            };
            return Some(format!("{} are not {}", kind(self), kind(other)));
        }
        let known = |system: &Self| system.unit != Unit::Unknown;
        if known(self) && known(other) && self.unit != other.unit {
            return Some(format!("{} are not {}", self.unit.name(), other.unit.name()));
        }
        if let (Some(this), Some(that)) = (self.method, other.method)
            && this != that
        {
            return Some(format!("{} is not {}", this.name(), that.name()));
        }
        for &(parameter, this) in &self.parameters {
            let same = other.parameters.iter().find(|(of, _)| *of == parameter);
            let Some(&(_, that)) = same else { continue };
            // Far below the resolution of any data, far above rounding in units and texts.
            if (this - that).abs() > 1e-6 * this.abs().max(that.abs()).max(1.0) {
                return Some(format!("{} {this} is not {that}", parameter.name()));
            }
        }
        None
    }
}

/// Returns whether the axes of a geodetic system in WKT 2 are those of space, not angles.
fn is_cartesian(node: &Node) -> bool {
    factor(node, &["ANGLEUNIT"]).is_none() && factor(node, &["LENGTHUNIT"]).is_some()
}

impl Parameter {
    /// Returns the parameter with a name, in any spelling of WKT 1 and 2.
    fn of_name(name: &str) -> Option<Self> {
        let letters = name.chars().filter(char::is_ascii_alphanumeric);
        let name: String = letters.map(|c| c.to_ascii_lowercase()).collect();
        Some(match &*name {
            "latitudeoforigin" | "latitudeofcenter" | "latitudeofnaturalorigin" | "latitudeoffalseorigin" => {
                Self::Latitude
            }
            "centralmeridian" | "longitudeofcenter" | "longitudeofnaturalorigin" | "longitudeoffalseorigin" => {
                Self::Longitude
            }
            "scalefactor" | "scalefactoratnaturalorigin" => Self::Scale,
            "falseeasting" | "eastingatfalseorigin" => Self::Easting,
            "falsenorthing" | "northingatfalseorigin" => Self::Northing,
            "standardparallel1" | "latitudeof1ststandardparallel" => Self::FirstParallel,
            "standardparallel2" | "latitudeof2ndstandardparallel" => Self::SecondParallel,
            _ => return None,
        })
    }

    /// Returns the name of the parameter, for people.
    fn name(self) -> &'static str {
        match self {
            Self::Latitude => "latitude of origin",
            Self::Longitude => "central meridian",
            Self::Scale => "scale factor",
            Self::Easting => "false easting",
            Self::Northing => "false northing",
            Self::FirstParallel => "first standard parallel",
            Self::SecondParallel => "second standard parallel",
        }
    }
}

/// Returns a parameter of a projection in a system whose unit is `factor` metres.
fn parameter(node: &Node, factor: f64) -> Option<(Parameter, f64)> {
    let parameter = Parameter::of_name(node.texts.first()?)?;
    let value = *node.numbers.first()?;
    let own = |keyword| node.child(&[keyword]).and_then(|unit| unit.numbers.first().copied());
    let value = match parameter {
        Parameter::Easting | Parameter::Northing => value * own("LENGTHUNIT").unwrap_or(factor),
        Parameter::Scale => value,
        _ => value * own("ANGLEUNIT").map_or(1.0, |radians| radians / (PI / 180.0)),
    };
    Some((parameter, value))
}
