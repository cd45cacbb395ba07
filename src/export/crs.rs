//! What exports say of the coordinate reference system: the text of the tile file, as the input named
//! it, in the terms of each format.

/// A coordinate reference system, as far as its text tells.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Crs<'t> {
    text: &'t str,
}

impl<'t> Crs<'t> {
    /// Takes a text: `EPSG:n`, a URN, WKT or PROJJSON. Returns `None` if it is empty.
    pub(super) fn of(text: Option<&'t str>) -> Option<Self> {
        let text = text?.trim_matches(|c: char| c.is_whitespace() || c == '\0');
        (!text.is_empty()).then_some(Self { text })
    }

    /// Returns the text.
    #[cfg_attr(not(feature = "flatgeobuf"), allow(dead_code, reason = "only FlatGeobuf has it"))]
    pub(super) fn text(&self) -> &'t str {
        self.text
    }

    /// Returns the EPSG code of the whole system.
    pub(super) fn epsg(&self) -> Option<u32> {
        let upper = self.text.to_ascii_uppercase();
        if matches!(
            &*upper,
            "OGC:CRS84" | "URN:OGC:DEF:CRS:OGC:1.3:CRS84" | "URN:OGC:DEF:CRS:OGC::CRS84"
        ) {
            return Some(4326);
        }
        if let Some(rest) = upper.strip_prefix("EPSG:") {
            return rest.trim().parse().ok();
        }
        if let Some(rest) = upper.strip_prefix("URN:OGC:DEF:CRS:EPSG:") {
            // A version, which may be empty, comes before the code.
            return rest.rsplit_once(':')?.1.parse().ok();
        }
        if let Some(rest) = upper.split_once("//WWW.OPENGIS.NET/DEF/CRS/EPSG/") {
            return rest.1.rsplit_once('/')?.1.parse().ok();
        }
        self.wkt().and_then(epsg_of_wkt)
    }

    /// Returns the text if it is well-known text.
    pub(super) fn wkt(&self) -> Option<&'t str> {
        let (word, _) = self.text.split_once(['[', '('])?;
        let is_word = |c: char| c.is_ascii_alphabetic() || c == '_';
        let is_wkt = word.ends_with("CS") || word.ends_with("CRS") || word.ends_with("cs") || word.ends_with("crs");
        (is_wkt && word.trim_end().chars().all(is_word)).then_some(self.text)
    }

    /// Returns the text if it looks like PROJJSON.
    #[cfg_attr(not(feature = "parquet"), allow(dead_code, reason = "only GeoParquet has it"))]
    pub(super) fn projjson(&self) -> Option<&'t str> {
        self.text.starts_with('{').then_some(self.text)
    }
}

/// Returns the code of the `AUTHORITY["EPSG","n"]` or `ID["EPSG",n]` that belongs to the whole text,
/// not to a part of it such as its datum.
fn epsg_of_wkt(wkt: &str) -> Option<u32> {
    let (mut depth, mut quoted, mut word) = (0u32, false, 0);
    let mut found = None;
    for (at, c) in wkt.char_indices() {
        match c {
            '"' => quoted = !quoted,
            _ if quoted => {}
            '[' | '(' => {
                let name = wkt[word..at].trim();
                if depth == 1 && (name.eq_ignore_ascii_case("AUTHORITY") || name.eq_ignore_ascii_case("ID")) {
                    found = code(&wkt[at + 1..]);
                }
                depth += 1;
                word = at + 1;
            }
            ']' | ')' => {
                depth = depth.saturating_sub(1);
                word = at + 1;
            }
            ',' => word = at + 1,
            _ => {}
        }
    }
    found
}

/// Returns n of `"EPSG","n"]…` or `"EPSG",n…`.
fn code(values: &str) -> Option<u32> {
    let values = values.split([']', ')']).next()?;
    let mut values = values.split(',').map(|value| value.trim().trim_matches('"'));
    let is_epsg = values.next()?.eq_ignore_ascii_case("EPSG");
    values.next()?.parse().ok().filter(|_| is_epsg)
}

/// Appends a text to JSON, quoted.
pub(super) fn put_json_text(text: &str, out: &mut Vec<u8>) {
    out.push(b'"');
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend_from_slice(&[b'\\', c as u8]),
            c if c < ' ' => out.extend_from_slice(format!("\\u{:04x}", u32::from(c)).as_bytes()),
            c => out.extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes()),
        }
    }
    out.push(b'"');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_code_is_that_of_the_whole_system() {
        for (text, epsg) in [
            ("EPSG:2056", Some(2056)),
            (" epsg:2056\0", Some(2056)),
            ("urn:ogc:def:crs:EPSG::25832", Some(25832)),
            ("urn:ogc:def:crs:EPSG:6.9:25832", Some(25832)),
            ("urn:ogc:def:crs:OGC:1.3:CRS84", Some(4326)),
            ("http://www.opengis.net/def/crs/EPSG/0/3857", Some(3857)),
            (
                r#"PROJCS["a, b]",GEOGCS["WGS 84",AUTHORITY["EPSG","4326"]],AUTHORITY["EPSG","32632"]]"#,
                Some(32632),
            ),
            (r#"PROJCS["x",GEOGCS["WGS 84",AUTHORITY["EPSG","4326"]]]"#, None),
            (
                r#"PROJCRS["x",BASEGEOGCRS["y",ID["EPSG",4326]], ID["EPSG",32632] ]"#,
                Some(32632),
            ),
            (r#"PROJCRS["x",ID["ESRI",102008]]"#, None),
            (
                r#"COMPD_CS["c",PROJCS["p",AUTHORITY["EPSG","1"]],VERT_CS["v",AUTHORITY["EPSG","2"]]]"#,
                None,
            ),
            ("local", None),
            ("EPSG:", None),
            (r#"GEOGCS["é",AUTHORITY["EPSG""#, None),
        ] {
            assert_eq!(Crs::of(Some(text)).unwrap().epsg(), epsg, "{text}");
        }
        assert_eq!(Crs::of(Some(" \0")), None);
        assert_eq!(Crs::of(None), None);
    }

    #[test]
    fn wkt_is_told_from_names() {
        for (text, is_wkt) in [
            (r#"PROJCS["x"]"#, true),
            (r#"BOUNDCRS[SOURCECRS[x]]"#, true),
            ("EPSG:4326", false),
            ("{\"type\": [\"GEOGCRS\"]}", false),
        ] {
            assert_eq!(Crs::of(Some(text)).unwrap().wkt().is_some(), is_wkt, "{text}");
        }
    }

    #[test]
    fn texts_are_escaped_in_json() {
        let mut out = Vec::new();
        put_json_text("a\"\\\n\u{e9}", &mut out);
        assert_eq!(String::from_utf8(out).unwrap(), "\"a\\\"\\\\\\u000aé\"");
    }
}
