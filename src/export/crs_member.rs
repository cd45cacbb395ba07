//! The member `crs` of GeoParquet, which must be PROJJSON.

use serde_json::Value;

use crate::crs::Crs;

/// What GeoParquet says of the reference system.
#[derive(Debug, PartialEq)]
pub(super) enum CrsMember {
    /// Nothing, which means longitude and latitude in WGS 84.
    Absent,
    /// PROJJSON.
    Json(String),
    /// `null`: nothing is known.
    Unknown,
    /// `null` too, because PROJJSON of this text cannot be made.
    Text(String),
}

impl CrsMember {
    pub(super) fn of(crs: Option<&Crs>) -> Self {
        let Some(crs) = crs else {
            return Self::Unknown;
        };
        let text = crs.text();
        if is_projjson(text) {
            return Self::Json(text.to_owned());
        }
        match crs.projjson() {
            // OGC's CRS84 counts as EPSG:4326, which has another order of axes.
            _ if crs.epsg() == Some(4326) && text.to_ascii_uppercase().ends_with("CRS84") => Self::Absent,
            Some(json) => Self::Json(json.to_string()),
            // Here, both have the same order.
            None if crs.epsg() == Some(4326) => Self::Absent,
            None if text.is_empty() => Self::Unknown,
            None => Self::Text(text.to_owned()),
        }
    }

    /// Returns the value of the member, if it is written.
    pub(super) fn json(&self) -> Option<&str> {
        match self {
            Self::Absent => None,
            Self::Json(json) => Some(json),
            Self::Unknown | Self::Text(_) => Some("null"),
        }
    }

    /// Returns what the user should know.
    pub(super) fn note(&self) -> Option<String> {
        let Self::Text(text) = self else {
            return None;
        };
        let start: String = text.chars().take(60).collect();
        Some(format!(
            "GeoParquet describes reference systems as PROJJSON, which cannot be made of {start:?}; the file says that \
             its system is unknown, and has the text under the key `delaunay-tiles:crs`"
        ))
    }
}

/// Returns whether a text is an object of JSON with a name and the type of a reference system.
fn is_projjson(text: &str) -> bool {
    if !text.starts_with('{') {
        return false;
    }
    let Ok(object) = serde_json::from_str::<Value>(text) else {
        return false;
    };
    object["name"].is_string() && object["type"].as_str().is_some_and(|kind| kind.ends_with("CRS"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_member_is_projjson_or_null_or_absent() {
        let of = |text: &str| CrsMember::of(Some(&Crs::new(text)));
        assert_eq!(CrsMember::of(None), CrsMember::Unknown);
        assert_eq!(of("OGC:CRS84"), CrsMember::Absent);
        let given = r#"{"type":"ProjectedCRS","name":"mine"}"#;
        assert_eq!(of(given), CrsMember::Json(given.to_owned()));
        for text in [
            "{\"type\":",
            "{\"type\":\"ProjectedCRS\"}",
            "my town",
            "PROJCS[\"x\"]",
            "EPSG:65000",
        ] {
            assert_eq!(of(text), CrsMember::Text(text.to_owned()));
            assert_eq!(of(text).json(), Some("null"));
            let note = of(text).note().unwrap();
            assert!(note.contains(&format!("{text:?}")), "{note}");
        }
        let geographic = r#"GEOGCS["a "" b",DATUM["d",SPHEROID["s",6378137,298.25]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]]"#;
        let CrsMember::Json(json) = of(geographic) else {
            panic!("{:?}", of(geographic))
        };
        let object: Value = serde_json::from_str(&json).unwrap();
        assert_eq!(object["name"], "a \" b");
    }

    #[cfg(feature = "epsg")]
    #[test]
    fn codes_have_their_definition() {
        for code in [4326, 25832, 2056] {
            let member = CrsMember::of(Some(&Crs::new(&format!("EPSG:{code}"))));
            let object: Value = serde_json::from_str(member.json().unwrap()).unwrap();
            assert_eq!(object["id"]["code"], code);
            assert_eq!(member.note(), None);
        }
    }
}
