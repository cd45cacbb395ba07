//! Small parsers of the exported formats. They accept what both the formats' descriptions allow and
//! the exports use, and panic at anything else.

use std::collections::{BTreeMap, VecDeque};

use delaunay_tiles::export::Format;
use delaunay_tiles::geometry::Point;
use serde_json::Value;

use super::features::features;

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
        (format, [file]) if format.has_features() => parse_features(format, file),
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
    let [vertex, face] = elements.try_into().unwrap();
    assert_eq!(vertex.2[..3], ["double x", "double y", "double z"]);
    assert_eq!((face.0, face.2), ("face", vec!["list uchar uint vertex_indices"]));
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
fn parse_features(format: Format, bytes: &[u8]) -> Parsed {
    let (features, kind) = features(format, bytes);
    let mut parsed = Parsed::default();
    let mut vertices: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for feature in features {
        if kind == "polygon" {
            let numbers = ["a", "b", "c"].map(|key| feature.number(key) as usize);
            for (number, corner) in numbers.into_iter().zip(feature.corners) {
                let before = vertices.entry(number).or_insert_with(|| corner.clone());
                assert_eq!(*before, corner, "vertex {number}");
            }
            parsed.triangles.push(numbers);
        } else {
            assert_eq!(kind, "point");
            parsed.records.push(feature.number("record"));
            let number = feature.number("vertex") as usize;
            assert!(vertices.insert(number, feature.corners[0].clone()).is_none());
        }
    }
    for ((number, vertex), expected) in vertices.into_iter().zip(0..) {
        assert_eq!(number, expected, "a vertex without triangles");
        parsed.points.push(Point::new(vertex[0], vertex[1]));
        parsed.z.extend(&vertex[2..]);
    }
    parsed
}

/// A glTF file: its description and its binary data.
pub fn parse_glb(bytes: &[u8]) -> (Value, &[u8]) {
    let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..4], number(4), number(8)), (&b"glTF"[..], 2, bytes.len()));
    let length = number(12);
    assert_eq!((&bytes[16..20], length % 4), (&b"JSON"[..], 0));
    let json = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    let rest = &bytes[20 + length..];
    if rest.is_empty() {
        return (json, rest);
    }
    assert_eq!((&rest[4..8], number(20 + length)), (&b"BIN\0"[..], rest.len() - 8));
    (json, &rest[8..])
}

/// Positions, triangles and edges.
pub type Mesh = (Vec<[f64; 3]>, Vec<[usize; 3]>, Vec<[usize; 2]>);

/// Returns the positions of a glTF file in the axes of the input, with 64 bits, and its triangles and
/// edges. Checks the counts and bounds that it states.
pub fn mesh_of_glb(bytes: &[u8]) -> Mesh {
    let (json, binary) = parse_glb(bytes);
    let Some(primitives) = json["meshes"][0]["primitives"].as_array() else {
        return Default::default();
    };
    assert_eq!(json["buffers"][0]["byteLength"], binary.len());
    let data = |accessor: &Value| {
        let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let at = view["byteOffset"].as_u64().unwrap_or(0) as usize;
        let length = view["byteLength"].as_u64().unwrap() as usize;
        let words = binary[at..at + length].as_chunks::<4>().0;
        let parts = if accessor["type"] == "VEC3" { 3 } else { 1 };
        assert_eq!(accessor["count"].as_u64().unwrap() * parts, words.len() as u64);
        words.iter().map(|word| u32::from_le_bytes(*word)).collect::<Vec<_>>()
    };
    let accessor = |number: &Value| &json["accessors"][number.as_u64().unwrap() as usize];
    let position = accessor(&primitives[0]["attributes"]["POSITION"]);
    let positions: Vec<f32> = data(position).into_iter().map(f32::from_bits).collect();
    let translation: Vec<f64> = json["nodes"][0]["translation"]
        .as_array()
        .unwrap()
        .iter()
        .map(|n| n.as_f64().unwrap())
        .collect();
    for axis in 0..3 {
        let all = || positions.iter().skip(axis).step_by(3).copied();
        let least = f64::from(all().fold(f32::INFINITY, f32::min));
        let most = f64::from(all().fold(f32::NEG_INFINITY, f32::max));
        assert_eq!(
            (position["min"][axis].as_f64(), position["max"][axis].as_f64()),
            (Some(least), Some(most))
        );
    }
    let at = |axis: usize, position: &[f32]| translation[axis] + f64::from(position[axis]);
    let points = positions.chunks(3).map(|p| [at(0, p), -at(2, p), at(1, p)]).collect();
    let (mut triangles, mut edges) = (Vec::new(), Vec::new());
    for primitive in primitives {
        let indices = || {
            data(accessor(&primitive["indices"]))
                .into_iter()
                .map(|i| i as usize)
                .collect::<Vec<_>>()
        };
        match primitive["mode"].as_u64().unwrap() {
            4 => triangles = indices().chunks(3).map(|t| [t[0], t[1], t[2]]).collect(),
            1 => edges = indices().chunks(2).map(|e| [e[0], e[1]]).collect(),
            mode => assert_eq!((mode, primitives.len()), (0, 1)),
        }
    }
    (points, triangles, edges)
}
