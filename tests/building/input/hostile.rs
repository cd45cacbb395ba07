//! Damaged files and noise in every format give points or an error, never a panic.
//!
//! All randomness comes from fixed seeds.

use crate::input::{drain, with_format};
use crate::support::cases::cases;
use delaunay_tiles::input::{Format, InputError, PointSource};
use std::path::Path;

/// SplitMix64 (Steele, Lea, Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        distributions::mix(self.0)
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    pub fn bytes(&mut self, n: usize) -> Vec<u8> {
        (0..n).map(|_| self.next() as u8).collect()
    }
}

/// Reads a file without and with skipping of invalid records. Returns whether the former succeeded.
fn survives(path: &Path, bytes: &[u8], format: Format) -> bool {
    std::fs::write(path, bytes).unwrap();
    let read = |skip_invalid| -> Result<(), InputError> {
        let options = with_format(format).skip_invalid(skip_invalid);
        let read = drain(PointSource::open(&[path.to_owned()], &options)?)?;
        assert!(read.points.len() <= 100_000, "more points than the file can have");
        Ok(())
    };
    let errors = [false, true].map(|skip| read(skip).err());
    for error in errors.iter().flatten() {
        let message = error.to_string();
        assert!(message.contains("hostile") && message.len() < 800, "{message}");
    }
    errors[0].is_none()
}

const FORMATS: [Format; 12] = [
    Format::Text,
    Format::F64,
    Format::Node,
    Format::Poly,
    Format::GeoJson,
    Format::FlatGeobuf,
    Format::Shapefile,
    Format::GeoPackage,
    Format::Las,
    Format::Ply,
    Format::Obj,
    Format::Parquet,
];

#[test]
fn noise_gives_points_or_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("hostile");
    let mut random = Random(1);
    let heads: [&[u8]; 16] = [
        b"",
        b"x,y\n1,2\n",
        b"\"",
        b"9 2 0 0\n",
        b"{\"type\":\"Point\",\"coordinates\":[",
        b"LASF",
        &[0x1f, 0x8b, 8],
        b"\xef\xbb\xbf",
        b"1 2 3\n\n",
        b"ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nproperty float y\nend_header\n",
        b"ply\nformat binary_big_endian 1.0\nelement a 9\nproperty list int short b\nelement vertex 2\n\
          property float x\nproperty float y\nend_header\n",
        b"v 1 2 3\nf 1 2 3\n",
        b"PAR1",
        // A header of 4 bytes, which is no FlatBuffer; a file of 2 GiB; a database with pages of 4 KiB.
        b"fgb\x03fgb\x01\x04\0\0\0\x04\0\0\0",
        &[
            0, 0, 0x27, 0x0a, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x3f, 0xff, 0xff, 0xff,
        ],
        b"SQLite format 3\0\x10\0\x01\x01\0\x40\x20\x20",
    ];
    let likely = b"0123456789.,-+eE \t\n\r\"#{}[]:;xyz\\untf";
    for format in FORMATS {
        for round in 0..150 {
            let mut bytes = heads[round % heads.len()].to_vec();
            let length = random.below(600);
            if round % 2 == 0 {
                bytes.extend(random.bytes(length));
            } else {
                bytes.extend((0..length).map(|_| likely[random.below(likely.len())]));
            }
            survives(&path, &bytes, format);
        }
    }
}

#[test]
fn damaged_text_json_mesh_and_raw_files_give_points_or_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("hostile");
    let mut random = Random(2);
    let samples: [(&[u8], Format); 8] = [
        (b"name,x,y,z\n\"a, b\",1.5,2,3\n# c\n\"d\n\",3,4e2,5\n", Format::Text),
        (b"4 2 1 1\n1 0 0 7 1\n2 1 0 7 1\n3 1 1 7 1\n4 0 1 7 1\n", Format::Node),
        (
            br#"{"type":"Feature","properties":{"a":"\u0041"},"geometry":{"type":"LineString","coordinates":[[1,2],[3,4]]}}"#,
            Format::GeoJson,
        ),
        (crate::input::mesh::TEXT.as_bytes(), Format::Ply),
        (&crate::input::mesh::bytes(false), Format::Ply),
        (&crate::input::mesh::bytes(true), Format::Ply),
        (crate::input::mesh::OBJ.as_bytes(), Format::Obj),
        (b"\0\0\0\0\0\0\xf0\x3f\0\0\0\0\0\0\xf0\x3f\0\0\0\0\0\0\xf0\x3f\0\0\0\0\0\0\xf0\x3f", Format::F64),
    ];
    for (sample, format) in samples {
        for length in 0..=sample.len() {
            survives(&path, &sample[..length], format);
        }
        for _ in 0..500 {
            let mut bytes = sample.to_vec();
            for _ in 0..=random.below(3) {
                let at = random.below(bytes.len());
                bytes[at] = random.next() as u8;
            }
            survives(&path, &bytes, format);
        }
    }
}

#[test]
fn damaged_las_files_give_points_or_an_error() {
    use std::time::Instant;
    // The decoder's panics are caught; the messages that they print have no use here.
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("hostile");
    let mut random = Random(3);
    for name in [
        "autzen.las",
        "autzen.laz",
        "autzen.copc.laz",
        "extrabytes.laz",
        "32-1-472-150-76.laz",
    ] {
        let whole = std::fs::read(crate::input::data(&format!("las/{name}"))).unwrap();
        assert!(survives(&path, &whole, Format::Las), "{name}");
        let start = u32::from_le_bytes(whole[96..100].try_into().unwrap()) as usize;
        let mut read = 0;
        let mut failed = 0;
        let mut count = |good: bool| if good { read += 1 } else { failed += 1 };
        // Every length up to the start of the points, and some lengths behind it.
        let begin = Instant::now();
        let step = 1 + whole.len() / cases(150);
        for length in (0..start.min(500)).chain((start..whole.len()).step_by(step)) {
            count(survives(&path, &whole[..length], Format::Las));
        }
        // Each bit of the header (in larger files one bit of each byte), then some bits of the
        // rest, then several bytes at once.
        let header = usize::from(u16::from_le_bytes([whole[94], whole[95]]));
        let rest = (0..cases(200)).map(|_| (header + random.below(whole.len() - header), 1 << random.below(8)));
        let flips: Vec<(usize, u8)> = (0..header)
            .flat_map(|at| (0..8).map(move |bit| (at, 1u8 << bit)))
            .filter(|&(at, bit)| bit == 1 << (at % 8) || (whole.len() < 5000 && cases(4) == 4))
            .chain(rest)
            .collect();
        for (at, bit) in flips {
            let mut bytes = whole.clone();
            bytes[at] ^= bit;
            count(survives(&path, &bytes, Format::Las));
        }
        for _ in 0..cases(120) {
            let mut bytes = whole.clone();
            for _ in 0..4 {
                let at = start + random.below(whole.len() - start);
                bytes[at] = if random.below(2) == 0 {
                    0xff
                } else {
                    random.next() as u8
                };
            }
            count(survives(&path, &bytes, Format::Las));
        }
        println!("{name}: {read} read, {failed} failed, {:?}", begin.elapsed());
    }
}

#[test]
fn damaged_parquet_files_give_points_or_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("hostile");
    let mut random = Random(5);
    for name in crate::input::parquet::FILES {
        let whole = std::fs::read(crate::input::data(&format!("formats/{name}"))).unwrap();
        assert!(survives(&path, &whole, Format::Parquet), "{name}");
        for length in (0..whole.len()).step_by(1 + whole.len() / 100) {
            assert!(!survives(&path, &whole[..length], Format::Parquet), "{name}: {length}");
        }
        // Half of the flips are in the metadata at the end.
        let footer = u32::from_le_bytes(whole[whole.len() - 8..][..4].try_into().unwrap()) as usize;
        let metadata = whole.len() - 8 - footer;
        let mut failed = 0;
        for round in 0..cases(400) {
            let mut bytes = whole.clone();
            for _ in 0..=random.below(3) {
                let at = match round % 2 {
                    0 => random.below(metadata),
                    _ => metadata + random.below(footer + 4),
                };
                bytes[at] ^= 1 << random.below(8);
            }
            failed += usize::from(!survives(&path, &bytes, Format::Parquet));
        }
        assert!(failed > 0, "{name}");
    }
}
