//! `verify` refuses overviews that break a promise: each test breaks one, and keeps all checksums right.

use std::fs;

use delaunay_tiles::input::PointBatch;
use delaunay_tiles::overviews;
use delaunay_tiles::store::OpenOptions;
use delaunay_tiles::{BuildOptions, Point, TileReader, VerifyError};
use distributions::Kind;

use super::{file, file_of, hills, with_overviews};
use crate::support::{Scratch, batches, build_batches, open_bytes, runtime};

const BLOCK: usize = 4096;
/// The bytes of an overview in the root of the directory.
const ENTRY: usize = 56;

/// A file whose bytes are changed. All numbers are little-endian.
struct Bytes(Vec<u8>);

impl Bytes {
    fn u64(&self, at: usize) -> u64 {
        u64::from_le_bytes(self.0[at..at + 8].try_into().unwrap())
    }

    fn put(&mut self, at: usize, bytes: &[u8]) {
        self.0[at..at + bytes.len()].copy_from_slice(bytes);
    }

    /// The offset of the superblock in force.
    fn superblock(&self) -> usize {
        if self.u64(32) > self.u64(BLOCK + 32) { 0 } else { BLOCK }
    }

    fn root(&self) -> std::ops::Range<usize> {
        let at = self.superblock();
        let start = self.u64(at + 48) as usize;
        start..start + u32::from_le_bytes(self.0[at + 56..at + 60].try_into().unwrap()) as usize
    }

    /// Makes all checksums of the file right again.
    fn seal(&mut self) {
        let (at, root) = (self.superblock(), self.root());
        let crc = crc32c::crc32c(&self.0[root]);
        self.put(at + 60, &crc.to_le_bytes());
        let crc = crc32c::crc32c(&self.0[at..at + BLOCK - 4]);
        self.put(at + BLOCK - 4, &crc.to_le_bytes());
    }

    /// Puts another file behind this one, in place of the overview of a level.
    fn replace(&mut self, level: usize, other: &[u8], vertices: u64) {
        let entry = self.entries()[level];
        let offset = self.0.len().next_multiple_of(BLOCK);
        self.0.resize(offset, 0);
        self.0.extend_from_slice(other);
        let crc = &other[BLOCK - 4..BLOCK];
        self.put(entry, &(offset as u64).to_le_bytes());
        self.put(entry + 8, &(other.len() as u64).to_le_bytes());
        self.put(entry + 24, &vertices.to_le_bytes());
        self.put(entry + 48, crc);
        let at = self.superblock();
        let length = self.0.len() as u64;
        self.put(at + 40, &length.to_le_bytes());
        self.seal();
    }

    /// The offsets of all entries, of which the first is known by its section.
    fn entries(&self) -> Vec<usize> {
        let root = self.root();
        // An entry is preceded by others or by their number. The first section starts where the file ended.
        let mut found = Vec::new();
        for at in (root.start..root.end - ENTRY).step_by(4) {
            let (offset, length) = (self.u64(at) as usize, self.u64(at + 8) as usize);
            let is_section = offset >= 2 * BLOCK
                && offset.is_multiple_of(BLOCK)
                && offset.checked_add(length).is_some_and(|end| end <= self.0.len())
                && length > 2 * BLOCK
                && self.0[offset..].starts_with(b"DELTILES");
            if is_section {
                found.push(at);
            }
        }
        found
    }
}

async fn hilly() -> (Scratch, Vec<Point>, Vec<f64>) {
    let (points, z) = hills(Kind::Uniform, 2500);
    let scratch = with_overviews(&points, &z, 100).await;
    (scratch, points, z)
}

/// Expects that the deep check refuses the file, and that the plain one does not.
async fn refused(bytes: Bytes, message: &str) {
    let reader = open_bytes(bytes.0).await.unwrap();
    reader.verify(true).await.unwrap();
    overviews::verify(&reader, false).await.unwrap();
    match overviews::verify(&reader, true).await {
        Err(VerifyError::File(found)) if found.contains(message) => {}
        other => panic!("{message}: {other:?}"),
    }
}

async fn replaced(scratch: &Scratch, level: usize, other: &Scratch) -> Bytes {
    let mut bytes = Bytes(fs::read(&scratch.path).unwrap());
    let vertices = other.open().await.metadata().vertices;
    bytes.replace(level, &fs::read(&other.path).unwrap(), vertices);
    bytes
}

#[test]
fn sound_overviews_are_proven() {
    runtime().block_on(async {
        let (scratch, ..) = hilly().await;
        let reader = scratch.open().await;
        let count = reader.overviews().len();
        assert!(count >= 2);
        for deep in [false, true] {
            assert_eq!(overviews::verify(&reader, deep).await.unwrap(), count);
        }
        let mut bytes = Bytes(fs::read(&scratch.path).unwrap());
        assert_eq!(bytes.entries().len(), count);
        bytes.seal();
        assert!(bytes.0 == fs::read(&scratch.path).unwrap());
    });
}

#[test]
fn errors_that_are_not_those_of_the_surface_are_refused() {
    runtime().block_on(async {
        let (scratch, ..) = hilly().await;
        for field in [32, 40] {
            let mut bytes = Bytes(fs::read(&scratch.path).unwrap());
            let entry = bytes.entries()[1];
            // The next smaller number.
            let error = bytes.u64(entry + field) - 1;
            bytes.put(entry + field, &error.to_le_bytes());
            bytes.seal();
            refused(bytes, "overview 2 has errors of").await;
        }
    });
}

#[test]
fn a_vertex_that_the_file_does_not_have_is_refused() {
    runtime().block_on(async {
        let (scratch, points, z) = hilly().await;
        let corners = corners(&points, &z);
        let mut other = corners.clone();
        other.points.push(Point::new(0.5, 0.500_001));
        other.z.push(0.0);
        other.records.push(9);
        let other = file_of(&[other], 100).await;
        refused(
            replaced(&scratch, 1, &other).await,
            "has 1 vertices that the file does not have",
        )
        .await;
    });
}

/// The points within a thousandth of the hull, among which all corners are, and some inside.
fn corners(points: &[Point], z: &[f64]) -> PointBatch {
    let mut batch = PointBatch::default();
    let is_near = |p: Point| [p.x, p.y, 1.0 - p.x, 1.0 - p.y].into_iter().any(|d| d < 0.02);
    for (i, (&p, &z)) in points.iter().zip(z).enumerate() {
        if is_near(p) {
            batch.points.push(p);
            batch.z.push(z);
            batch.records.push(i as u64);
        }
    }
    batch
}

#[test]
fn another_z_is_refused() {
    runtime().block_on(async {
        let (scratch, points, z) = hilly().await;
        let mut other = corners(&points, &z);
        other.z[3] += 1.0;
        let other = file_of(&[other], 100).await;
        refused(replaced(&scratch, 1, &other).await, "another z").await;
    });
}

#[test]
fn a_missing_corner_of_the_hull_is_refused() {
    runtime().block_on(async {
        let (scratch, points, z) = hilly().await;
        let inner: Vec<(Point, f64)> = points.iter().copied().zip(z).filter(|(p, _)| p.x > 0.1).collect();
        let inner: (Vec<Point>, Vec<f64>) = inner.into_iter().step_by(9).unzip();
        let other = file(&inner.0, &inner.1, 100).await;
        refused(replaced(&scratch, 1, &other).await, "outside the overview").await;
    });
}

#[test]
fn a_vertex_that_the_level_before_lacks_is_refused() {
    runtime().block_on(async {
        let (scratch, points, z) = hilly().await;
        // Most points near the hull are not in the first level.
        let other = file_of(&[corners(&points, &z)], 100).await;
        refused(replaced(&scratch, 1, &other).await, "that the level before it lacks").await;
    });
}

#[test]
fn constraints_are_refused() {
    runtime().block_on(async {
        let (scratch, points, z) = hilly().await;
        let other = Scratch::new();
        let mut builder = delaunay_tiles::Builder::new(&other.path, BuildOptions::default()).unwrap();
        let batch = corners(&points, &z);
        builder.push_segments(&[[batch.points[0], batch.points[1]]]).unwrap();
        builder.push(&batch).await.unwrap();
        builder.finish().await.unwrap();
        let bytes = replaced(&scratch, 1, &other).await;
        let reader = open_bytes(bytes.0).await.unwrap();
        let error = overviews::verify(&reader, false).await.unwrap_err();
        assert!(error.to_string().contains("has constraints"), "{error}");
    });
}

#[test]
fn a_damaged_overview_is_refused_by_the_plain_check() {
    runtime().block_on(async {
        let (scratch, ..) = hilly().await;
        let sound = fs::read(&scratch.path).unwrap();
        let entries = Bytes(sound.clone()).entries();
        for (level, &entry) in entries.iter().enumerate() {
            let section = Bytes(sound.clone()).u64(entry) as usize;
            let length = Bytes(sound.clone()).u64(entry + 8) as usize;
            let mut is_refused = 0;
            for at in (section..section + length).step_by(97) {
                let mut bytes = sound.clone();
                bytes[at] ^= 1;
                let reader = open_bytes(bytes).await.unwrap();
                // The file itself is sound. Gaps of the overview carry no meaning.
                reader.verify(false).await.unwrap();
                if let Err(error) = overviews::verify(&reader, false).await {
                    assert!(
                        error.to_string().contains(&format!("overview {}", level + 1)),
                        "{error}"
                    );
                    is_refused += 1;
                }
            }
            assert!(is_refused > 3, "{is_refused}");
        }
    });
}

#[test]
fn sections_that_cannot_be_are_errors() {
    runtime().block_on(async {
        let (scratch, ..) = hilly().await;
        let sound = fs::read(&scratch.path).unwrap();
        let (entry, root, length) = {
            let bytes = Bytes(sound.clone());
            (bytes.entries()[0], bytes.root(), sound.len() as u64)
        };
        for (field, value) in [
            (0, u64::MAX - 4095),
            (0, length.next_multiple_of(4096)),
            (0, 4096),
            (0, 8193),
            (0, root.start as u64),
            (8, u64::MAX),
            (8, length),
            (8, 4096),
            (16, 0),
            (24, 0),
            (24, 1),
            (32, f64::NAN.to_bits()),
            (32, (-1.0f64).to_bits()),
            (40, f64::INFINITY.to_bits()),
        ] {
            let mut bytes = Bytes(sound.clone());
            bytes.put(entry + field, &value.to_le_bytes());
            bytes.seal();
            let error = open_bytes(bytes.0).await.err();
            let error = error.unwrap_or_else(|| panic!("{field} {value}")).to_string();
            assert!(error.contains("overview"), "{error}");
        }
        // What only the overview itself contradicts.
        for (field, value) in [(0, 8192), (24, 999_u64), (48, 5)] {
            let mut bytes = Bytes(sound.clone());
            bytes.put(entry + field, &value.to_le_bytes());
            bytes.seal();
            let Ok(reader) = open_bytes(bytes.0).await else {
                continue;
            };
            reader.tile(delaunay_tiles::store::TileId(0)).await.unwrap();
            assert!(reader.overview(0).await.is_err(), "{field}");
            assert!(overviews::verify(&reader, false).await.is_err());
        }
    });
}

#[test]
fn an_overview_has_no_overviews() {
    runtime().block_on(async {
        // A file with overviews as an overview of another one.
        let (points, z) = hills(Kind::Uniform, 2500);
        let outer = with_overviews(&points, &z, 100).await;
        let inner = Scratch::new();
        let options = BuildOptions::default().tile_vertices(60);
        let some: (Vec<Point>, Vec<f64>) = points.iter().copied().zip(z).take(300).unzip();
        build_batches(&inner.path, &batches(&some.0, &some.1), options)
            .await
            .unwrap();
        super::make_small(&inner.path).await.unwrap();
        let opened = TileReader::open(&inner.path, OpenOptions::default()).await.unwrap();
        assert!(!opened.overviews().is_empty());
        opened.compact(&inner.path).await.unwrap();
        let bytes = replaced(&outer, 1, &inner).await;
        let reader = open_bytes(bytes.0).await.unwrap();
        let level = reader.overview(1).await.unwrap();
        assert_eq!(level.metadata().vertices, 300);
        assert!(level.overviews().is_empty() && level.stale_overviews().is_empty());
    });
}
