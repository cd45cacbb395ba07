//! The key `geo` of GeoParquet: which column has geometries, how, and in which reference system.

use serde_json::Value;

/// The limit on the bytes of the key.
const LONGEST: usize = 4 << 20;

/// The primary geometry column.
pub struct Geo {
    pub column: String,
    pub encoding: String,
    /// The types of the geometries; empty if they are unknown.
    pub types: Vec<String>,
    /// The reference system: `EPSG:…` or the like if it has an id, else PROJJSON.
    pub crs: Option<String>,
}

impl Geo {
    /// Returns what the key says, or what is wrong with it.
    pub fn parse(key: &str) -> Result<Self, String> {
        if key.len() > LONGEST {
            return Err(format!("it has {} bytes; the limit is {LONGEST}", key.len()));
        }
        let geo: Value = serde_json::from_str(key).map_err(|error| error.to_string())?;
        let column = geo["primary_column"].as_str().ok_or("it names no `primary_column`")?;
        let about = &geo["columns"][column];
        let encoding = about["encoding"]
            .as_str()
            .ok_or("it gives the primary column no `encoding`")?;
        let types = about["geometry_types"].as_array();
        let types = types.into_iter().flatten().filter_map(Value::as_str);
        Ok(Self {
            column: column.to_owned(),
            encoding: encoding.to_owned(),
            types: types.map(str::to_owned).collect(),
            crs: match about.get("crs") {
                // By the standard, longitude and latitude in degrees.
                None => Some("OGC:CRS84".to_owned()),
                Some(Value::Null) => None,
                Some(crs) => Some(name(crs)),
            },
        })
    }

    /// Returns whether all geometries are single points, which the file promises.
    pub fn has_points_only(&self) -> bool {
        !self.types.is_empty() && self.types.iter().all(|kind| matches!(&**kind, "Point" | "Point Z"))
    }
}

/// Returns the name of a reference system: its id if it has one.
fn name(crs: &Value) -> String {
    let (authority, code) = (&crs["id"]["authority"], &crs["id"]["code"]);
    match (authority.as_str(), code) {
        (Some(authority), Value::Number(code)) => format!("{authority}:{code}"),
        (Some(authority), Value::String(code)) => format!("{authority}:{code}"),
        _ => crs.as_str().map_or_else(|| crs.to_string(), str::to_owned),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reference_systems_are_named_by_their_id() {
        let crs = |crs: &str| {
            let key = format!(
                r#"{{"primary_column":"g","columns":{{"g":{{"encoding":"WKB","geometry_types":["Point Z"]{crs}}}}}}}"#
            );
            let geo = Geo::parse(&key).unwrap();
            assert!(geo.has_points_only() && geo.column == "g" && geo.encoding == "WKB");
            geo.crs
        };
        assert_eq!(crs("").as_deref(), Some("OGC:CRS84"));
        assert_eq!(crs(r#","crs":null"#), None);
        assert_eq!(
            crs(r#","crs":{"name":"a","id":{"authority":"EPSG","code":25833}}"#).as_deref(),
            Some("EPSG:25833")
        );
        assert_eq!(
            crs(r#","crs":{"name":"local"}"#).as_deref(),
            Some(r#"{"name":"local"}"#)
        );
    }

    #[test]
    fn a_key_without_its_parts_is_refused() {
        for key in ["", "[", "{}", r#"{"primary_column":"g"}"#, "7"] {
            assert!(Geo::parse(key).is_err(), "{key}");
        }
    }
}
