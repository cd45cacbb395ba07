//! PLY and OBJ: their points, and the edges of their faces; and the edges of `.ele`.

use crate::input::{assert_says, data, file, message, segments, skipping, stream, with_format};
use delaunay_tiles::input::{Format, InputError, InputOptions, PointSource, SegmentSource};
use std::fs;
use std::path::{Path, PathBuf};

/// A pyramid whose base is one face of four corners; the vertices come in the middle.
pub const TEXT: &str = "ply\nformat ascii 1.0\ncomment by hand\nelement camera 2\nproperty list uchar int id\nproperty char n\n\
                        element vertex 5\nproperty uchar red\nproperty double y\nproperty float X\nproperty list int short more\n\
                        property int z\nelement face 5\nproperty float area\nproperty list uchar uint vertex_index\nend_header\n\
                        2 7 8 1\n0 1\n9 0 0 1 5 0\n9 0 4.5 0 0\n9 4 4.5 2 5 6 0\n9 4 0 0 0\n9 2 2 0 3\n\
                        16 4 0 1 2 3\n1 3 0 1 4\n1 3 1 2 4\n1 3 2 3 4\n1 3 3 0 4\n";

/// The same in binary, of either byte order.
pub fn bytes(is_big: bool) -> Vec<u8> {
    let format = if is_big {
        "binary_big_endian"
    } else {
        "binary_little_endian"
    };
    let end = TEXT.find("2 7 8").unwrap();
    let mut bytes = TEXT[..end].replace("ascii", format).into_bytes();
    let mut put = |number: &[u8]| match is_big {
        true => bytes.extend_from_slice(number),
        false => bytes.extend(number.iter().rev()),
    };
    for camera in [&[7i32, 8][..], &[]] {
        put(&[camera.len() as u8]);
        camera.iter().for_each(|id| put(&id.to_be_bytes()));
        put(&[1]);
    }
    for (x, y, z, more) in [
        (0.0f32, 0.0f64, 0i32, &[5i16][..]),
        (4.5, 0.0, 0, &[]),
        (4.5, 4.0, 0, &[5, 6]),
    ]
    .into_iter()
    .chain([(0.0, 4.0, 0, &[][..]), (2.0, 2.0, 3, &[])])
    {
        put(&[9]);
        put(&y.to_be_bytes());
        put(&x.to_be_bytes());
        put(&(more.len() as i32).to_be_bytes());
        more.iter().for_each(|item| put(&item.to_be_bytes()));
        put(&z.to_be_bytes());
    }
    for corners in [&[0u32, 1, 2, 3][..], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]] {
        put(&1f32.to_be_bytes());
        put(&[corners.len() as u8]);
        corners.iter().for_each(|corner| put(&corner.to_be_bytes()));
    }
    bytes
}

/// The same as OBJ.
pub const OBJ: &str = "# by hand\nmtllib a.mtl\no pyramid\nv 0 0 0\nv 4.5 0 0 1\nvn 0 0 1\nv 4.5 4 0 0.5 0.5 0.5\nv 0 4 0 # corner\n\
                       f 1//1 2//1 3//1 4//1\nv 2 2 3\nf 1/1 2/2 5/3\nf -4 -3 -1\nf 3 4 5\nf 4/1/1 1/1/1 5/1/1\n";

const POINTS: [(f64, f64); 5] = [(0.0, 0.0), (4.5, 0.0), (4.5, 4.0), (0.0, 4.0), (2.0, 2.0)];
const EDGES: [[u64; 2]; 8] = [[0, 1], [0, 3], [0, 4], [1, 2], [1, 4], [2, 3], [2, 4], [3, 4]];

fn pyramids() -> [(&'static str, Vec<u8>); 4] {
    [
        ("a.ply", TEXT.into()),
        ("b.ply", bytes(false)),
        ("c.ply", bytes(true)),
        ("d.obj", OBJ.into()),
    ]
}

/// Reads the edges, each with its smaller end first, sorted.
fn edges(path: &Path) -> Result<(Vec<[u64; 2]>, SegmentSource), InputError> {
    let (source, _) = SegmentSource::open_edges(path, None)?;
    let read = segments::drain(source)?;
    assert!(read.ends.is_empty());
    let mut edges: Vec<[u64; 2]> = read.records.iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    Ok((edges, read.source))
}

fn written(folder: &tempfile::TempDir, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    path
}

#[track_caller]
fn refused(path: &Path, parts: &[&str]) {
    let message = edges(path).expect_err("this has no edges").to_string();
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
}

#[test]
fn points_and_edges_of_a_mesh_come_from_every_format() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in pyramids() {
        let read = file(name, &bytes, &InputOptions::default()).unwrap();
        assert_eq!(read.points, POINTS, "{name}");
        assert_eq!(read.z, [0.0, 0.0, 0.0, 0.0, 3.0], "{name}");
        assert_eq!(read.records, [0, 1, 2, 3, 4], "{name}");
        assert_eq!(read.source.notes(), [""; 0], "{name}");
        let path = written(&folder, name, &bytes);
        assert_eq!(SegmentSource::open_edges(&path, None).unwrap().1, 5);
        let (found, source) = edges(&path).unwrap();
        assert_eq!(found, EDGES, "{name}");
        assert_eq!(source.sources(), [(name.to_owned(), 5)]);
        assert!(
            source
                .origin(3)
                .unwrap()
                .to_string()
                .ends_with("face 3 (counted from 0)")
        );
    }
}

#[test]
fn meshes_may_be_compressed_or_come_from_a_stream() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in pyramids() {
        let zipped = crate::input::gzip(&bytes);
        let name = format!("{name}.gz");
        let read = file(&name, &zipped, &InputOptions::default()).unwrap();
        assert_eq!(read.points, POINTS, "{name}");
        assert_eq!(edges(&written(&folder, &name, &zipped)).unwrap().0, EDGES, "{name}");
    }
    assert_eq!(stream(bytes(true), &InputOptions::default()).unwrap().points, POINTS);
    assert_eq!(stream(OBJ, &with_format(Format::Obj)).unwrap().points, POINTS);
}

/// The files were written by trimesh.
#[test]
fn meshes_of_another_program_are_equal_in_all_formats() {
    let names = ["tin.ply", "tin_ascii.ply", "tin.obj"];
    let read = names.map(|name| {
        let path = data(&format!("formats/{name}"));
        let source = PointSource::open(std::slice::from_ref(&path), &InputOptions::default());
        let read = source.and_then(crate::input::drain).unwrap();
        (read.points, read.z, edges(&path).unwrap().0)
    });
    let (points, _, edges) = &read[0];
    // 6 × 6 squares with a diagonal.
    assert_eq!((points.len(), edges.len()), (49, 2 * 6 * 7 + 36));
    assert_eq!(read[0], read[1]);
    assert_eq!(read[0], read[2]);
}

#[test]
fn binary_ply_without_lists_can_be_sampled() {
    let mut bytes = b"ply\nformat binary_little_endian 1.0\nelement a 2\nproperty short b\nelement vertex 1000\n\
                      property float y\nproperty uchar c\nproperty double x\nend_header\n\x01\x02\x03\x04"
        .to_vec();
    for n in 0..1000u16 {
        bytes.extend_from_slice(&f32::from(n).to_le_bytes());
        bytes.push(7);
        bytes.extend_from_slice(&f64::from(2 * n).to_le_bytes());
    }
    let folder = tempfile::tempdir().unwrap();
    let path = written(&folder, "a.ply", &bytes);
    let source = PointSource::open(&[path], &InputOptions::default()).unwrap();
    assert!(!source.has_z());
    assert_eq!(source.expected_points(), Some(1000));
    let sample = source.sample(100).unwrap();
    assert!(sample.len() >= 50 && sample.iter().all(|p| p.x == 2.0 * p.y));
    let read = crate::input::drain(source).unwrap();
    assert!(
        read.points
            .iter()
            .enumerate()
            .all(|(n, p)| *p == (2.0 * n as f64, n as f64))
    );
}

#[test]
fn a_broken_row_is_refused_with_its_place_or_skipped() {
    let text = TEXT.replace("9 4 4.5 2 5 6 0", "9 4 4.5 3 5 6 0");
    assert_says(
        file("a.ply", &text, &InputOptions::default()),
        &[
            "a.ply: record 2 (line 21): `9 4 4.5 3 5 6 0` does not have the numbers",
            "announces for its element",
        ],
    );
    assert_eq!(file("a.ply", &text, &skipping()).unwrap().records, [0, 1, 3, 4]);
    let nan = bytes(true);
    let at = nan
        .windows(4)
        .rposition(|window| window == 4.5f32.to_be_bytes())
        .unwrap();
    let nan = [&nan[..at], &f32::NAN.to_be_bytes(), &nan[at + 4..]].concat();
    assert_says(
        file("a.ply", &nan, &InputOptions::default()),
        &["a.ply: record 2 (byte ", "x is NaN, not a finite number"],
    );
    assert_eq!(file("a.ply", &nan, &skipping()).unwrap().records, [0, 1, 3, 4]);
    let obj = OBJ.replace("v 4.5 0 0 1", "v 4.5 0");
    assert_says(
        file("a.obj", &obj, &InputOptions::default()),
        &["a.obj: record 1 (line 5): `v 4.5 0` is not `v` and three numbers"],
    );
    assert_eq!(file("a.obj", &obj, &skipping()).unwrap().records, [0, 2, 3, 4]);
}

#[test]
fn headers_that_make_no_sense_are_refused() {
    let default = InputOptions::default();
    for (from, to, says) in [
        ("ply\n", "plie\n", "the file does not begin with `ply`"),
        (
            "format ascii",
            "format utf8",
            "line 2: the header has the line `format utf8 1.0`",
        ),
        ("format ascii 1.0\n", "", "the header has no line `format`"),
        (
            "vertex 5",
            "vertex -5",
            "line 7: the header has the line `element vertex -5`",
        ),
        (
            "element vertex 5",
            "element point 5",
            "the header has no element `vertex`",
        ),
        (
            "double y",
            "quad y",
            "line 9: the header has the line `property quad y`",
        ),
        ("float X", "float u", "the element `vertex` has no properties x and y"),
        ("end_header", "end", "the header has the line `end`"),
    ] {
        assert!(TEXT.contains(from));
        assert_says(file("a.ply", TEXT.replacen(from, to, 1), &default), &["a.ply: ", says]);
    }
    assert_says(
        file("a.ply", b"ply\nformat ascii 1.0\n", &default),
        &["the file ends within the header"],
    );
    let many = format!(
        "ply\nformat ascii 1.0\nelement a 1\n{}",
        "property int a\n".repeat(5000)
    );
    assert_says(
        file("a.ply", many, &default),
        &["one element, property or name too many"],
    );
}

#[test]
fn meshes_cut_short_or_with_false_counts_are_refused() {
    let default = InputOptions::default();
    for is_big in [false, true] {
        let whole = bytes(is_big);
        for length in 0..whole.len() {
            assert!(file("a.ply", &whole[..length], &default).is_err(), "{length} bytes");
        }
    }
    let text = TEXT.replace("vertex 5", "vertex 18446744073709551615");
    assert_says(file("a.ply", &text, &skipping()), &["rows of the element `vertex`"]);
    assert_says(
        file("a.ply", TEXT.replace("face 5", "face 6"), &default),
        &["line 29: the file ends after 5 of 6 rows of the element `face`"],
    );
    let claims = |rows: &str| {
        let whole = bytes(false);
        let at = whole.windows(9).position(|window| window == b"vertex 5\n").unwrap();
        [&whole[..at], format!("vertex {rows}\n").as_bytes(), &whole[at + 9..]].concat()
    };
    assert_says(
        file("a.ply", claims("4000000000"), &default),
        &["by its header the file has at least 84", "the file is cut short"],
    );
    assert_says(
        file("a.ply", claims("18446744073709551615"), &default),
        &["by its header the file has more than 2^64 bytes"],
    );
    let rest = [&bytes(false), &b"rest"[..]].concat();
    let read = file("a.ply", rest, &default).unwrap();
    assert!(read.source.notes()[0].ends_with("what follows the last element is not read: 4 bytes"));
}

#[test]
fn faces_that_make_no_sense_are_refused_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    for (from, to, says) in [
        (
            "1 3 2 3 4",
            "1 3 2 3 5",
            "face 3 (line 27): there is no point 5; they are 0 to 4",
        ),
        (
            "1 3 2 3 4",
            "1 3 2 3 -1",
            "face 3 (line 27): -1 is not the index of a point",
        ),
        (
            "1 3 2 3 4",
            "1 4 2 3 4",
            "face 3 (line 27): `1 4 2 3 4` does not have the numbers",
        ),
        ("vertex_index", "corners", "the element `face` has no list of corners"),
    ] {
        let path = written(&folder, "a.ply", TEXT.replace(from, to));
        refused(&path, &["a.ply: ", says]);
    }
    for (from, to, says) in [
        (
            "f 3 4 5",
            "f 3 4 6",
            "face 3 (line 13): there is no point 6; they are 1 to 5",
        ),
        ("f 3 4 5", "f 3 4 0", "face 3 (line 13): there is no point 0"),
        (
            "f 3 4 5",
            "f 3 4 -7",
            "face 3 (line 13): `f 3 4 -7` does not have the indices",
        ),
        ("f 3 4 5", "f 3 4 \\", "line 13: a row that continues on the next line"),
        ("f 3 4 5", "f 3", "face 3 (line 13): `f 3` does not have the indices"),
    ] {
        refused(&written(&folder, "a.obj", OBJ.replace(from, to)), &["a.obj: ", says]);
    }
    let none = written(&folder, "none.obj", "v 0 0 0\n");
    assert!(edges(&none).unwrap().1.notes()[0].ends_with("none.obj: there are no faces, and so no edges"));
    refused(
        &written(&folder, "a.csv", "1,2\n"),
        &["edges are read from .node files"],
    );
}

/// The list of corners is within a limit, and no batch is larger than others.
#[test]
fn faces_of_many_corners_are_rings() {
    let folder = tempfile::tempdir().unwrap();
    let ring = |corners: u64| {
        let mut text = format!(
            "ply\nformat ascii 1.0\nelement vertex {corners}\nproperty float x\nproperty float y\nelement face 1\n\
             property list uint uint vertex_indices\nend_header\n"
        );
        (0..corners).for_each(|n| text += &format!("{n} {}\n", n * n % 97));
        text += &corners.to_string();
        (0..corners).for_each(|n| text += &format!(" {n}"));
        written(&folder, "ring.ply", text)
    };
    let (found, source) = edges(&ring(20_000)).unwrap();
    assert_eq!((found.len(), source.sources()[0].1), (20_000, 1));
    refused(&ring(70_000), &["a face of 70000 corners; the limit is 65536"]);
}

/// An edge between two faces comes once, unless many others come in between.
#[test]
fn edges_come_at_most_twice() {
    let folder = tempfile::tempdir().unwrap();
    let side = 300;
    let mut text = String::new();
    (0..side * side).for_each(|n| text += &format!("v {} {} 0\n", n % side, n / side));
    for a in (0..side * (side - 1)).filter(|n| n % side < side - 1) {
        text += &format!("f {} {} {} {}\n", a + 1, a + 2, a + side + 2, a + side + 1);
    }
    let (mut found, _) = edges(&written(&folder, "grid.obj", text)).unwrap();
    let count = found.len();
    found.dedup();
    assert_eq!(found.len(), 2 * side * (side - 1));
    assert!(count - found.len() < count / 50, "{count}");
}

#[test]
fn triangles_beside_a_node_file_are_read() {
    let folder = tempfile::tempdir().unwrap();
    for base in [0, 1] {
        let mut node = "5 2 0 0\n".to_owned();
        POINTS
            .iter()
            .zip(base..)
            .for_each(|((x, y), n)| node += &format!("{n} {x} {y}\n"));
        let path = written(&folder, "a.node", &node);
        fs::remove_file(folder.path().join("a.ele")).ok();
        refused(
            &path,
            &[
                "a.node: its triangles would be in",
                "a.ele, which does not exist; put that file there",
            ],
        );
        let ele = |rows: &[&str]| written(&folder, "a.ele", rows.join("\n"));
        let triangle = |n: u64, corners: [u64; 3]| {
            format!("{n} {} {} {}", corners[0] + base, corners[1] + base, corners[2] + base)
        };
        let [one, two] = [triangle(7, [0, 1, 4]), triangle(1, [1, 2, 4])];
        ele(&["# here", "2 3 1", &one, &format!("{two} 3.5 # attribute")]);
        let (found, source) = edges(&path).unwrap();
        assert_eq!(found, [[0, 1], [0, 4], [1, 2], [1, 4], [2, 4]]);
        assert_eq!(source.sources(), [("a.ele".to_owned(), 2)]);
        assert!(
            source
                .origin(1)
                .unwrap()
                .to_string()
                .ends_with("a.ele: triangle 1 (counted from 0)")
        );
        ele(&["3 3 0", &one, &two]);
        refused(&path, &["a.ele: line 4: the file ends after 2 of 3 triangles"]);
        ele(&["1 3 0", &one, &two]);
        refused(&path, &["a.ele: line 3: a row after the last of 1 triangles"]);
        ele(&["1 4 0", "1 1 2 3 4"]);
        refused(&path, &["a.ele: line 1: the first line is `1 4 0`: tetrahedra"]);
        ele(&["1 3 0", &triangle(0, [0, 1, 5])]);
        refused(
            &path,
            &[
                "a.ele: face 0 (line 2): there is no point ",
                &format!("{base} to {}", base + 4),
            ],
        );
        ele(&["1 3 0", "0 1 2"]);
        refused(
            &path,
            &["face 0 (line 2): `0 1 2` is not a number and the indices of three points"],
        );
    }
}

#[test]
fn other_formats_are_not_taken_for_meshes() {
    for name in ["a.ply", "a.obj"] {
        let binary = [0u8, 159, 146, 150, 0, 10, 7, 0];
        let message = message(file(name, binary, &InputOptions::default()));
        assert!(message.contains(name), "{message}");
    }
    let read = file("a.obj", "x,y\n1,2\n", &InputOptions::default()).unwrap();
    assert!(read.source.notes()[0].ends_with("no row begins with `v`, so there are no vertices"));
}
