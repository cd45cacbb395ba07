//! The methods of projections, by their names in WKT 1, in ESRI's WKT, and in WKT 2.

/// A method, or several that give the same coordinates for some parameters, so that programs give one
/// system any of their names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    TransverseMercator,
    /// With one or with two standard parallels.
    LambertConformalConic,
    /// All variants, and that of the web, which some programs write as another.
    Mercator,
    Albers,
    LambertAzimuthal,
    PolarStereographic,
    ObliqueStereographic,
    /// Hotine's, and the Swiss one, which is a case of it.
    ObliqueMercator,
    CassiniSoldner,
    Krovak,
}

impl Method {
    /// Returns the method with a name; `None` if the name is not known, or that of several methods.
    pub fn of_name(name: &str) -> Option<Self> {
        let letters = name.chars().filter(char::is_ascii_alphanumeric);
        let name: String = letters.map(|c| c.to_ascii_lowercase()).collect();
        Some(match &*name {
            "transversemercator" | "transversemercatorcomplex" | "gausskruger" => Self::TransverseMercator,
            "lambertconformalconic"
            | "lambertconformalconic1sp"
            | "lambertconformalconic2sp"
            | "lambertconicconformal1sp"
            | "lambertconicconformal2sp" => Self::LambertConformalConic,
            "mercator"
            | "mercator1sp"
            | "mercator2sp"
            | "mercatorvarianta"
            | "mercatorvariantb"
            | "mercatorauxiliarysphere"
            | "popularvisualisationpseudomercator" => Self::Mercator,
            "albers" | "albersconicequalarea" | "albersequalarea" => Self::Albers,
            "lambertazimuthalequalarea" => Self::LambertAzimuthal,
            "polarstereographic"
            | "polarstereographicvarianta"
            | "polarstereographicvariantb"
            | "polarstereographicvariantc"
            | "stereographicnorthpole"
            | "stereographicsouthpole" => Self::PolarStereographic,
            "obliquestereographic" | "doublestereographic" => Self::ObliqueStereographic,
            "hotineobliquemercator"
            | "hotineobliquemercatorazimuthcenter"
            | "hotineobliquemercatorazimuthnaturalorigin"
            | "hotineobliquemercatorvarianta"
            | "hotineobliquemercatorvariantb"
            | "rectifiedskeworthomorphiccenter"
            | "rectifiedskeworthomorphicnaturalorigin"
            | "swissobliquecylindrical"
            | "swissobliquemercator" => Self::ObliqueMercator,
            "cassini" | "cassinisoldner" => Self::CassiniSoldner,
            "krovak" | "krovaknorthorientated" => Self::Krovak,
            _ => return None,
        })
    }

    /// Returns the name of the method, for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::TransverseMercator => "Transverse Mercator",
            Self::LambertConformalConic => "Lambert Conic Conformal",
            Self::Mercator => "Mercator",
            Self::Albers => "Albers Equal Area",
            Self::LambertAzimuthal => "Lambert Azimuthal Equal Area",
            Self::PolarStereographic => "Polar Stereographic",
            Self::ObliqueStereographic => "Oblique Stereographic",
            Self::ObliqueMercator => "Oblique Mercator",
            Self::CassiniSoldner => "Cassini-Soldner",
            Self::Krovak => "Krovak",
        }
    }
}
