//! Names of coordinate reference systems: codes, URNs, URLs.

/// Returns the EPSG code that a name contains, such as `EPSG:25832`, `urn:ogc:def:crs:EPSG::25832`,
/// `http://www.opengis.net/def/crs/EPSG/0/25832` or `OGC:CRS84`.
pub fn epsg(name: &str) -> Option<u32> {
    let name = name.to_ascii_uppercase();
    let parts: Vec<&str> = name.split([':', '/', '#']).collect();
    let (&code, authority) = parts.split_last()?;
    if authority.contains(&"OGC") {
        match code {
            "CRS84" | "CRS84H" => return Some(4326),
            "CRS83" => return Some(4269),
            "CRS27" => return Some(4267),
            _ => {}
        }
    }
    let is_epsg = authority.iter().any(|part| matches!(*part, "EPSG" | "EPSG.XML"));
    let code: u32 = code.parse().ok().filter(|_| is_epsg)?;
    Some(current(code))
}

/// Returns the code in use for a system that has other codes too.
pub fn current(code: u32) -> u32 {
    match code {
        // Web Mercator, by its former and unofficial codes.
        900_913 | 3785 | 102_100 | 102_113 => 3857,
        code => code,
    }
}

/// Returns the definition of a code as WKT.
#[cfg(feature = "epsg")]
pub fn definition(code: u32) -> Option<String> {
    super::epsg::definition(code).map(|definition| definition.wkt)
}

/// Without the feature `epsg`, there are no definitions.
#[cfg(not(feature = "epsg"))]
pub fn definition(_: u32) -> Option<String> {
    None
}
