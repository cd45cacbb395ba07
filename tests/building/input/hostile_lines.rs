//! Damaged files and noise give the sources of segments, obstacles, sites and `.poly` their records
//! or an error, never a panic.
//!
//! All randomness comes from fixed seeds.

use crate::input::hostile::Random;
use crate::input::{poly, segments, sites};
use delaunay_tiles::input::{InputError, SegmentSource, SiteSource};
use std::path::Path;

/// A suffix, and a reader of files with this suffix.
type Reader = (&'static str, fn(&Path) -> Result<(), InputError>);

fn lines(path: &Path) -> Result<(), InputError> {
    SegmentSource::open(&[path.to_owned()])
        .and_then(segments::drain)
        .map(|_| ())
}

fn obstacles(path: &Path) -> Result<(), InputError> {
    SegmentSource::open_obstacles(&[path.to_owned()])
        .and_then(segments::drain)
        .map(|_| ())
}

fn sites(path: &Path) -> Result<(), InputError> {
    SiteSource::open(&[path.to_owned()], None)
        .and_then(sites::drain)
        .map(|_| ())
}

fn named_sites(path: &Path) -> Result<(), InputError> {
    SiteSource::open(&[path.to_owned()], Some("id"))
        .and_then(sites::drain)
        .map(|_| ())
}

fn poly(path: &Path) -> Result<(), InputError> {
    poly::read(path).map(|_| ())
}

fn edges(path: &Path) -> Result<(), InputError> {
    SegmentSource::open_edges(path, None)
        .and_then(|(source, _)| segments::drain(source))
        .map(|_| ())
}

const READERS: [Reader; 11] = [
    ("geojson", lines),
    ("csv", lines),
    ("u32", lines),
    ("geojson", obstacles),
    ("geojson", sites),
    ("csv", sites),
    ("geojson", named_sites),
    ("csv", named_sites),
    ("poly", poly),
    ("ply", edges),
    ("obj", edges),
];

/// Reads a file with all readers of its suffix. Returns the number of readers that accepted it.
fn readers_of(folder: &Path, bytes: &[u8], suffix: &str) -> usize {
    let path = folder.join("hostile").with_extension(suffix);
    std::fs::write(&path, bytes).unwrap();
    let mut took = 0;
    for (_, read) in READERS.into_iter().filter(|reader| reader.0 == suffix) {
        match read(&path) {
            Ok(()) => took += 1,
            Err(error) => {
                let message = error.to_string();
                assert!(message.contains("hostile") && message.len() < 900, "{message}");
            }
        }
    }
    took
}

const SAMPLES: [(&str, &[u8]); 7] = [
    ("ply", crate::input::mesh::TEXT.as_bytes()),
    ("obj", crate::input::mesh::OBJ.as_bytes()),
    (
        "geojson",
        br#"{"type":"Feature","properties":{"id":"\u0041"},"geometry":{"type":"LineString","coordinates":[[1,2],[3,4,5]]}}"#,
    ),
    (
        "geojson",
        br#"{"type":"Feature","geometry":{"type":"MultiPolygon","coordinates":[[[[0,0],[9,0],[0,9],[0,0]],[[1,1],[2,1],[1,2],[1,1]]]]}}"#,
    ),
    (
        "geojson",
        br#"{"type":"Feature","id":7,"geometry":{"type":"MultiPoint","coordinates":[[1,2],[3,4]]},"properties":{"id":null}}"#,
    ),
    ("csv", b"x,y,id,x2\n1,2,3,4\n# c\n\"5\",6e1,\"a, b\",7\n"),
    ("poly", b"3 2 0 1\n1 0 0 1\n2 9 0 1\n3 0 9 1\n3 1\n1 1 2 1\n2 2 3 1\n3 3 1 1\n1\n1 2.5 2.5\n1\n1 2 2 0.5 0.1\n"),
];

#[test]
fn a_json_or_poly_document_cut_short_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (suffix, sample) in SAMPLES {
        // A JSON document must be whole. Rows may end anywhere; so may the regions of `.poly`, and
        // numbers may lose digits.
        let shortest = match suffix {
            "geojson" => sample.len(),
            // The last number may lose no digit, since it has one; the line end may be missing.
            "ply" => sample.len() - 1,
            "poly" => sample.windows(5).position(|window| window == b"2.5 2").unwrap() + 5,
            _ => 0,
        };
        for length in 0..=sample.len() {
            let took = readers_of(folder.path(), &sample[..length], suffix);
            assert!(took == 0 || length >= shortest, "{length} bytes of {suffix} were read");
            assert!(took > 0 || length < sample.len(), "no reader takes the whole {suffix}");
        }
    }
}

#[test]
fn damaged_bytes_give_records_or_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(4);
    for (suffix, sample) in SAMPLES {
        for _ in 0..200 {
            let mut bytes = sample.to_vec();
            for _ in 0..=random.below(3) {
                let at = random.below(bytes.len());
                bytes[at] = random.next() as u8;
            }
            readers_of(folder.path(), &bytes, suffix);
        }
    }
}

#[test]
fn noise_gives_records_or_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(5);
    let heads: [&[u8]; 7] = [
        b"",
        b"x,y,id\n",
        b"2 2\n0 0 0\n1 1 1\n",
        b"0 2\n",
        br#"{"type":"Polygon","coordinates":[["#,
        br#"{"type":"Feature","id":"#,
        &[0x1f, 0x8b, 8],
    ];
    let likely = b"0123456789.,-+eE \t\n\r\"#{}[]:;xyz\\untf";
    for suffix in ["geojson", "csv", "u32", "poly"] {
        for round in 0..200 {
            let mut bytes = heads[round % heads.len()].to_vec();
            let length = random.below(400);
            if round % 2 == 0 {
                bytes.extend(random.bytes(length));
            } else {
                bytes.extend((0..length).map(|_| likely[random.below(likely.len())]));
            }
            readers_of(folder.path(), &bytes, suffix);
        }
    }
}
