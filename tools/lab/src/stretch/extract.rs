//! Extracts the polygons of a file that are within a rectangle.

use std::fs;
use std::path::Path;
use std::str::FromStr;

use anyhow::{Context, bail};
use delaunay_tiles::geometry::Rect;
use serde_json::{Value, json};

/// A rectangle, as `X0,Y0,X1,Y1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Within(pub Rect);

impl FromStr for Within {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
        match numbers.as_deref() {
            Ok(&[x0, y0, x1, y1]) if x0 < x1 && y0 < y1 => Ok(Self(Rect::new(x0, y0, x1, y1))),
            _ => Err("a rectangle is X0,Y0,X1,Y1, with X0 < X1 and Y0 < Y1".to_owned()),
        }
    }
}

/// Writes the polygons of a GeoJSON file whose outer rings are within a rectangle, and returns
/// their number.
pub fn extract(from: &Path, within: Within, to: &Path) -> anyhow::Result<usize> {
    let shown = from.display();
    let text = fs::read(from).with_context(|| format!("cannot read {shown}"))?;
    let whole: Value = serde_json::from_slice(&text)
        .with_context(|| format!("{shown} is no GeoJSON; polygons can be chosen from GeoJSON only"))?;
    let mut inside = Vec::new();
    let features = whole["features"].as_array().map_or(&[][..], Vec::as_slice);
    for geometry in features.iter().map(|feature| &feature["geometry"]) {
        let coordinates = &geometry["coordinates"];
        let polygons = match geometry["type"].as_str() {
            Some("Polygon") => std::slice::from_ref(coordinates),
            Some("MultiPolygon") => coordinates.as_array().map_or(&[][..], Vec::as_slice),
            _ => &[],
        };
        inside.extend(polygons.iter().filter(|polygon| lies_in(polygon, within.0)));
    }
    if inside.is_empty() {
        let Rect {
            min_x,
            min_y,
            max_x,
            max_y,
        } = within.0;
        bail!("{shown}: no polygon lies in {min_x},{min_y},{max_x},{max_y}");
    }
    let features = inside.iter().map(
        |polygon| json!({"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": polygon}}),
    );
    let chosen = json!({"type": "FeatureCollection", "features": features.collect::<Vec<_>>()});
    fs::write(to, chosen.to_string()).with_context(|| format!("cannot write {}", to.display()))?;
    Ok(inside.len())
}

/// Returns whether all corners of a polygon's outer ring are within a rectangle; `false` for other
/// values.
fn lies_in(polygon: &Value, rect: Rect) -> bool {
    let Some(ring) = polygon[0].as_array() else {
        return false;
    };
    let inside = |corner: &Value| {
        let at = corner[0].as_f64().zip(corner[1].as_f64());
        at.is_some_and(|(x, y)| (rect.min_x..=rect.max_x).contains(&x) && (rect.min_y..=rect.max_y).contains(&y))
    };
    ring.iter().all(inside)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_within_a_rectangle_are_extracted_whole() {
        let folder = tempfile::tempdir().unwrap();
        let [from, to] = ["a.json", "b.json"].map(|name| folder.path().join(name));
        let square = |x: f64| json!([[[x, 0.1], [x + 1.0, 0.1], [x, 1.0], [x, 0.1]]]);
        let feature = |kind: &str, coordinates: Value| json!({"type": "Feature", "geometry": {"type": kind, "coordinates": coordinates}});
        let features = [
            feature("Polygon", square(0.0)),
            feature("MultiPolygon", json!([square(2.0), square(2.5)])),
            feature("Point", json!([0.5, 0.5])),
            feature("Polygon", json!("nonsense")),
            json!(7),
        ];
        fs::write(&from, json!({"features": features}).to_string()).unwrap();
        let within = "0, 0, 3, 1".parse().unwrap();
        assert_eq!(extract(&from, within, &to).unwrap(), 2);
        let chosen: Value = serde_json::from_slice(&fs::read(&to).unwrap()).unwrap();
        assert_eq!(chosen["features"][1]["geometry"]["coordinates"], square(2.0));

        let error = extract(&from, "5,5,6,6".parse().unwrap(), &to).unwrap_err();
        assert!(error.to_string().contains("no polygon lies in 5,5,6,6"), "{error}");
        fs::write(&from, "x").unwrap();
        assert!(extract(&from, within, &to).is_err());
        for wrong in ["", "1,2,3", "1,2,0,3", "1,2,nan,3", "1,2,3,4,5"] {
            assert!(wrong.parse::<Within>().is_err(), "{wrong}");
        }
    }
}
