//! Small parsers of the exported formats. They accept what both the formats' descriptions allow and
//! the exports use, and panic at anything else.

use std::collections::{BTreeMap, VecDeque};

use delaunay_tiles::export::Format;
use delaunay_tiles::geometry::Point;
use geojson::{FeatureCollection, GeometryValue};

/// The content of an exported file.
#[derive(Debug, Default, PartialEq)]
pub struct Parsed {
    pub points: Vec<Point>,
    /// Empty if the format has none.
    pub z: Vec<f64>,
    /// Empty if the format has none.
    pub records: Vec<u64>,
    pub triangles: Vec<[usize; 3]>,
}

pub fn parse(format: Format, files: &[Vec<u8>]) -> Parsed {
    match (format, files) {
        (Format::Ply, [ply]) => parse_ply(ply),
        (Format::Node, [node, ele]) => parse_node(text(node), text(ele)),
        (Format::Obj, [obj]) => parse_obj(text(obj)),
        (Format::GeoJson, [geojson]) => parse_geojson(text(geojson)),
        _ => panic!("{} files of {format}", files.len()),
    }
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

fn parse_ply(bytes: &[u8]) -> Parsed {
    const END: &[u8] = b"end_header\n";
    let end = bytes.windows(END.len()).position(|w| w == END).unwrap() + END.len();
    let header: Vec<&str> = text(&bytes[..end])
        .lines()
        .filter(|l| !l.starts_with("comment "))
        .collect();
    assert_eq!(header[..2], ["ply", "format binary_little_endian 1.0"]);
    // Elements, each with name, count and properties.
    let mut elements: Vec<(&str, usize, Vec<&str>)> = Vec::new();
    for line in &header[2..header.len() - 1] {
        if let Some(element) = line.strip_prefix("element ") {
            let (name, count) = element.split_once(' ').unwrap();
            elements.push((name, count.parse().unwrap(), Vec::new()));
        } else {
            elements
                .last_mut()
                .unwrap()
                .2
                .push(line.strip_prefix("property ").unwrap());
        }
    }
    let [vertex, face, edge] = elements.try_into().unwrap();
    assert_eq!(vertex.2[..3], ["double x", "double y", "double z"]);
    assert_eq!((face.0, face.2), ("face", vec!["list uchar uint vertex_indices"]));
    assert_eq!(edge, ("edge", 0, vec!["uint vertex1", "uint vertex2"]));
    let mut rest = &bytes[end..];
    let mut parsed = Parsed::default();
    for _ in 0..vertex.1 {
        let [x, y, z] = [(); 3].map(|()| f64::from_le_bytes(take(&mut rest)));
        parsed.points.push(Point::new(x, y));
        parsed.z.push(z);
        parsed.records.push(match vertex.2[3] {
            "uint record" => u32::from_le_bytes(take(&mut rest)).into(),
            "double record" => f64::from_le_bytes(take(&mut rest)) as u64,
            other => panic!("{other}"),
        });
    }
    for _ in 0..face.1 {
        assert_eq!(take(&mut rest), [3u8]);
        parsed
            .triangles
            .push([(); 3].map(|()| u32::from_le_bytes(take(&mut rest)) as usize));
    }
    assert!(rest.is_empty());
    parsed
}

fn take<const N: usize>(bytes: &mut &[u8]) -> [u8; N] {
    let (first, rest) = bytes.split_first_chunk().unwrap();
    *bytes = rest;
    *first
}

fn parse_node(node: &str, ele: &str) -> Parsed {
    let mut parsed = Parsed::default();
    let (head, rows) = rows(node);
    let [count, 2, z, 0] = head[..] else { panic!("{head:?}") };
    assert_eq!(rows.len(), count);
    for (row, number) in rows.iter().zip(0usize..) {
        assert_eq!(row.len(), 3 + z);
        assert_eq!(row[0].parse::<usize>().unwrap(), number);
        parsed
            .points
            .push(Point::new(row[1].parse().unwrap(), row[2].parse().unwrap()));
        parsed.z.extend(row[3..].iter().map(|z| z.parse::<f64>().unwrap()));
    }
    let (head, rows) = self::rows(ele);
    assert_eq!(head, [rows.len(), 3, 0]);
    for (row, number) in rows.iter().zip(0usize..) {
        let row: Vec<usize> = row.iter().map(|field| field.parse().unwrap()).collect();
        let [found, a, b, c] = row[..] else { panic!("{row:?}") };
        assert_eq!(found, number);
        parsed.triangles.push([a, b, c]);
    }
    parsed
}

/// Returns the numbers of the first line, and the fields of the other lines. Skips comments.
fn rows(text: &str) -> (Vec<usize>, VecDeque<Vec<&str>>) {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let mut rows: VecDeque<Vec<&str>> = lines.map(|line| line.split(' ').collect()).collect();
    let head = rows.pop_front().unwrap();
    (head.into_iter().map(|field| field.parse().unwrap()).collect(), rows)
}

fn parse_obj(text: &str) -> Parsed {
    let mut parsed = Parsed::default();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let (kind, fields) = line.split_once(' ').unwrap();
        let fields: Vec<&str> = fields.split(' ').collect();
        assert_eq!(fields.len(), 3, "{line}");
        if kind == "v" {
            assert!(parsed.triangles.is_empty(), "vertices come first");
            let [x, y, z] = [0, 1, 2].map(|i| fields[i].parse().unwrap());
            parsed.points.push(Point::new(x, y));
            parsed.z.push(z);
        } else {
            assert_eq!(kind, "f");
            parsed
                .triangles
                .push([0, 1, 2].map(|i| fields[i].parse::<usize>().unwrap() - 1));
        }
    }
    parsed
}

/// Takes the vertices from the triangles, and checks that triangles agree on shared vertices.
fn parse_geojson(text: &str) -> Parsed {
    let collection: FeatureCollection = text.parse().unwrap();
    let mut parsed = Parsed::default();
    let mut vertices: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for feature in collection.features {
        let properties = feature.properties.unwrap();
        match feature.geometry.unwrap().value {
            GeometryValue::Polygon { coordinates: rings } => {
                let [ring] = &rings[..] else {
                    panic!("{} rings", rings.len())
                };
                let [a, b, c, last] = &ring[..] else {
                    panic!("{} corners", ring.len())
                };
                assert_eq!(a, last);
                let numbers = properties["vertices"].as_array().unwrap();
                let numbers: [usize; 3] = [0, 1, 2].map(|i| numbers[i].as_u64().unwrap() as usize);
                for (number, corner) in numbers.into_iter().zip([a, b, c]) {
                    let corner = corner.as_slice().to_vec();
                    let before = vertices.entry(number).or_insert_with(|| corner.clone());
                    assert_eq!(*before, corner, "vertex {number}");
                }
                parsed.triangles.push(numbers);
            }
            GeometryValue::Point { coordinates } => {
                let number = properties["vertex"].as_u64().unwrap() as usize;
                parsed.records.push(properties["record"].as_u64().unwrap());
                assert!(vertices.insert(number, coordinates.as_slice().to_vec()).is_none());
            }
            other => panic!("{other:?}"),
        }
    }
    for ((number, vertex), expected) in vertices.into_iter().zip(0..) {
        assert_eq!(number, expected, "a vertex without triangles");
        parsed.points.push(Point::new(vertex[0], vertex[1]));
        parsed.z.extend(&vertex[2..]);
    }
    parsed
}
