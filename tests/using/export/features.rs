//! Readers of the formats of features. FlatGeobuf and Parquet are read by crates.

use std::collections::BTreeMap;

use delaunay_tiles::export::Format;
use geojson::{FeatureCollection, GeometryValue};
use serde_json::Value;

/// The values of a feature, and its coordinates, those of polygons without the last ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    pub values: BTreeMap<String, Value>,
    pub corners: Vec<Vec<f64>>,
}

impl Feature {
    pub fn number(&self, key: &str) -> u64 {
        self.values[key].as_u64().unwrap_or_else(|| panic!("{key} of {self:?}"))
    }
}

/// Returns the features of a file, and the kind of their geometry in small letters.
pub fn features(format: Format, bytes: &[u8]) -> (Vec<Feature>, String) {
    match format {
        Format::GeoJson => of_geojson(std::str::from_utf8(bytes).unwrap()),
        Format::FlatGeobuf => of_flatgeobuf(bytes),
        Format::GeoParquet => of_parquet(bytes),
        _ => panic!("{format} has no features"),
    }
}

fn without_last(mut ring: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let last = ring.pop();
    assert_eq!(last.as_ref(), ring.first());
    ring
}

fn of_geojson(text: &str) -> (Vec<Feature>, String) {
    let collection: FeatureCollection = text.parse().unwrap();
    let mut kind = String::new();
    let features = collection.features.into_iter().map(|feature| {
        let mut values: BTreeMap<_, _> = feature.properties.unwrap().into_iter().collect();
        if let Some(vertices) = values.remove("vertices") {
            for (key, vertex) in ["a", "b", "c"].into_iter().zip(vertices.as_array().unwrap()) {
                values.insert(key.to_owned(), vertex.clone());
            }
        }
        let (found, corners) = match feature.geometry.unwrap().value {
            GeometryValue::Polygon { coordinates } => {
                let [ring] = &coordinates[..] else {
                    panic!("{} rings", coordinates.len())
                };
                let ring = ring.iter().map(|corner| corner.as_slice().to_vec());
                ("polygon", without_last(ring.collect()))
            }
            GeometryValue::Point { coordinates } => ("point", vec![coordinates.as_slice().to_vec()]),
            GeometryValue::LineString { coordinates } => {
                let ends = coordinates.iter().map(|end| end.as_slice().to_vec());
                ("linestring", ends.collect())
            }
            other => panic!("{other:?}"),
        };
        found.clone_into(&mut kind);
        Feature { values, corners }
    });
    (features.collect(), kind)
}

/// Also checks what the header says: the number of features, their bounds, and whether there is a z.
fn of_flatgeobuf(bytes: &[u8]) -> (Vec<Feature>, String) {
    use flatgeobuf::{FallibleStreamingIterator, FeatureProperties, FgbReader};

    let mut input = std::io::Cursor::new(bytes);
    let mut reader = FgbReader::open(&mut input).unwrap().select_all().unwrap();
    let header = reader.header();
    let has_z = header.has_z();
    let count = header.features_count();
    let envelope: Option<Vec<f64>> = header.envelope().map(|envelope| envelope.iter().collect());
    let columns: Vec<_> = header
        .columns()
        .unwrap()
        .iter()
        .map(|column| column.name().to_owned())
        .collect();
    let kind = format!("{:?}", header.geometry_type()).to_lowercase();
    let mut features = Vec::new();
    while let Some(feature) = reader.next().unwrap() {
        let properties = feature.properties().unwrap();
        let values = columns.iter().map(|name| {
            let value = properties.get(name).map_or(Value::Null, |text| {
                text.parse::<u64>()
                    .map_or_else(|_| Value::from(text.clone()), Value::from)
            });
            (name.clone(), value)
        });
        let geometry = feature.geometry().unwrap();
        let xy: Vec<f64> = geometry.xy().unwrap().iter().collect();
        let mut corners: Vec<_> = xy.chunks(2).map(<[f64]>::to_vec).collect();
        assert_eq!(geometry.z().is_some(), has_z);
        for (corner, z) in corners.iter_mut().zip(geometry.z().into_iter().flatten()) {
            corner.push(z);
        }
        let corners = if kind == "polygon" {
            without_last(corners)
        } else {
            corners
        };
        let values = values.collect();
        features.push(Feature { values, corners });
    }
    assert_eq!(features.len() as u64, count);
    let all = || features.iter().flat_map(|feature| &feature.corners);
    let least = |axis: usize| all().map(|corner| corner[axis]).fold(f64::INFINITY, f64::min);
    let most = |axis: usize| all().map(|corner| corner[axis]).fold(f64::NEG_INFINITY, f64::max);
    let bounds = (count > 0).then(|| vec![least(0), least(1), most(0), most(1)]);
    assert_eq!(envelope, bounds);
    (features, if count > 0 { kind } else { String::new() })
}

/// Also checks the metadata of GeoParquet, and that columns of coordinates agree with the geometry.
fn of_parquet(bytes: &[u8]) -> (Vec<Feature>, String) {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    let reader = SerializedFileReader::new(bytes::Bytes::copy_from_slice(bytes)).unwrap();
    let metadata = reader.metadata().file_metadata().key_value_metadata().unwrap().clone();
    let geo = metadata.iter().find(|pair| pair.key == "geo").unwrap();
    let geo: Value = serde_json::from_str(geo.value.as_ref().unwrap()).unwrap();
    assert_eq!(
        (geo["version"].as_str(), geo["primary_column"].as_str()),
        (Some("1.1.0"), Some("geometry"))
    );
    let geometry = &geo["columns"]["geometry"];
    assert_eq!(geometry["encoding"], "WKB");
    let kind = geometry["geometry_types"][0].as_str().unwrap();
    let (kind, has_z) = kind.strip_suffix(" Z").map_or((kind, false), |kind| (kind, true));
    let mut features = Vec::new();
    for row in reader.get_row_iter(None).unwrap() {
        let (mut values, mut corners, mut position) = (BTreeMap::new(), Vec::new(), Vec::new());
        for (name, field) in row.unwrap().get_column_iter() {
            match field {
                Field::Long(number) => drop(values.insert(name.clone(), Value::from(*number))),
                Field::Str(text) => drop(values.insert(name.clone(), Value::from(text.clone()))),
                Field::Null => drop(values.insert(name.clone(), Value::Null)),
                Field::Double(number) => position.push(*number),
                Field::Bytes(wkb) if name == "geometry" => corners = of_wkb(wkb.data(), kind, has_z),
                other => panic!("{name}: {other:?}"),
            }
        }
        assert!(position.is_empty() == (kind != "Point") && (position.is_empty() || corners == [position]));
        features.push(Feature { values, corners });
    }
    for (axis, at) in (0..if has_z { 3 } else { 2 }).zip(0..) {
        let all = || {
            features
                .iter()
                .flat_map(|feature| &feature.corners)
                .map(move |corner| corner[axis])
        };
        let (least, most) = (
            all().fold(f64::INFINITY, f64::min),
            all().fold(f64::NEG_INFINITY, f64::max),
        );
        let bbox = &geometry["bbox"];
        let half = bbox.as_array().map_or(0, Vec::len) / 2;
        assert_eq!(bbox[at].as_f64(), Some(least).filter(|_| !features.is_empty()));
        assert_eq!(bbox[half + at].as_f64(), Some(most).filter(|_| !features.is_empty()));
    }
    let kind = if features.is_empty() {
        String::new()
    } else {
        kind.to_lowercase()
    };
    (features, kind)
}

fn of_wkb(wkb: &[u8], kind: &str, has_z: bool) -> Vec<Vec<f64>> {
    let dims = if has_z { 3 } else { 2 };
    let (code, counts) = match kind {
        "Point" => (1u32, vec![]),
        "LineString" => (2, vec![2u32]),
        "Polygon" => (3, vec![1, 4]),
        other => panic!("{other}"),
    };
    let head: Vec<u8> = [code + if has_z { 1000 } else { 0 }]
        .iter()
        .chain(&counts)
        .flat_map(|number| number.to_le_bytes())
        .collect();
    assert_eq!(wkb[0], 1, "little-endian");
    let rest = wkb[1..].strip_prefix(&head[..]).unwrap();
    let numbers: Vec<f64> = rest
        .as_chunks::<8>()
        .0
        .iter()
        .map(|bytes| f64::from_le_bytes(*bytes))
        .collect();
    let corners: Vec<_> = numbers.chunks(dims).map(<[f64]>::to_vec).collect();
    assert_eq!(rest.len(), 8 * dims * corners.len());
    if kind == "Polygon" {
        without_last(corners)
    } else {
        corners
    }
}
