//! The promise: a damaged or hostile file gives an error or the same answer, never a panic, a hang,
//! a huge allocation or a wrong answer.

mod compressed;
mod digest;
mod fuzzed;
mod surgery;
mod tables;
mod town;

use std::io;
use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

use self::digest::fix_digest;
use self::surgery::Patient;
use crate::support::cases::cases;
use crate::support::peeling::peeled;
use crate::support::{self, Random, batches, file_bytes, open_bytes, points_of, reference, runtime};
use bytes::Bytes;
use delaunay_tiles::BuildOptions;
use delaunay_tiles::export::{ExportError, ExportOptions, Format, export};
use delaunay_tiles::geometry::{Point, Rect};
use delaunay_tiles::io::{MemoryFile, ReadAt};
use delaunay_tiles::mesh::EngineKind;
use delaunay_tiles::query::BulkOptions;
use delaunay_tiles::store::{Cache, Digest, Directory, OpenOptions, ReadError, Tile, TileReader, VerifyError};
use delaunay_tiles::terrain::Surface;
use distributions::Kind;
use futures::future::{BoxFuture, FutureExt};
use futures::stream::{StreamExt, TryStreamExt};

const LONGEST: Duration = Duration::from_secs(20);

fn options() -> BuildOptions {
    BuildOptions::default().tile_vertices(8).threads(2)
}

/// Builds a grid, uniform points, and uniform points with z, in tiles of 8.
fn patients() -> Vec<Patient> {
    patients_of(8)
}

fn patients_of(width: u32) -> Vec<Patient> {
    let n = width * width;
    let grid: Vec<Point> = (0..n)
        .map(|i| Point::new(f64::from(i % width), f64::from(i / width)))
        .collect();
    let uniform = points_of(Kind::Uniform, n.into(), 1);
    let z: Vec<f64> = (0..n).map(f64::from).collect();
    let build = |points: &[Point], z: &[f64]| runtime().block_on(file_bytes(&batches(points, z), options()));
    [build(&grid, &[]), build(&uniform, &[]), build(&uniform, &z)]
        .map(Patient::new)
        .into()
}

/// A file with a flipped bit, without a copy of the file.
struct Flipped {
    bytes: Bytes,
    at: u64,
    mask: u8,
}

impl ReadAt for Flipped {
    fn length(&self) -> u64 {
        self.bytes.len() as u64
    }

    fn backend(&self) -> &'static str {
        "flipped"
    }

    fn read_at(&self, range: Range<u64>) -> BoxFuture<'static, io::Result<Bytes>> {
        let mut part = self.bytes.slice(range.start as usize..range.end as usize);
        if range.contains(&self.at) {
            let mut copy = part.to_vec();
            copy[(self.at - range.start) as usize] ^= self.mask;
            part = copy.into();
        }
        futures::future::ready(Ok(part)).boxed()
    }
}

/// Reads and verifies all of a file, and returns its digest.
async fn digest_of(bytes: Vec<u8>) -> Result<Digest, String> {
    digest_of_source(MemoryFile::new(bytes)).await
}

async fn digest_of_source(source: impl ReadAt + 'static) -> Result<Digest, String> {
    let all = async {
        let opened = TileReader::open_source(source, "file", OpenOptions::default()).await;
        let reader = opened.map_err(message)?;
        let mut tiles = reader.tiles();
        while let Some(tile) = tiles.next().await {
            tile.map_err(message)?;
        }
        reader.verify(true).await.map_err(|error| match error {
            VerifyError::Read(error) => message(error),
            other => other.to_string(),
        })?;
        reader.recompute_digest().await.map_err(message)
    };
    tokio::time::timeout(LONGEST, all)
        .await
        .expect("no file takes that long")
}

/// Returns the text of an error. Nobody cancels here, so a cancelled task would be a hidden panic.
fn message(error: ReadError) -> String {
    assert!(!matches!(error, ReadError::Cancelled), "a task panicked");
    error.to_string()
}

#[test]
fn a_file_cut_off_at_any_length_is_refused() {
    for patient in patients() {
        let bytes = &patient.bytes;
        // Every length near the ends of parts, and every 61st elsewhere.
        let parts = patient.of_tiles().chain(patient.directory());
        let ends: Vec<usize> = parts
            .flat_map(|p| [p.at, p.at + p.length])
            .chain([0, 4096, 8192, bytes.len()])
            .collect();
        let lengths = (0..bytes.len()).filter(|&l| l % 61 == 0 || ends.iter().any(|end| end.abs_diff(l) < 9));
        runtime().block_on(async {
            for length in lengths {
                let error = open_bytes(bytes[..length].to_vec()).await.err();
                assert!(
                    matches!(error, Some(ReadError::Invalid { .. })),
                    "length {length}: {error:?}"
                );
            }
        });
    }
}

#[test]
fn a_flipped_bit_gives_an_error_or_the_same_answer() {
    let mut flips = 0;
    for patient in patients_of(5).into_iter().step_by(2) {
        runtime().block_on(async {
            let right = digest_of(patient.bytes.clone()).await.unwrap();
            let parts = patient.of_tiles().chain(patient.directory());
            let mut bytes: Vec<usize> = parts.flat_map(|p| p.at..p.at + p.length).collect();
            // The fields of both superblocks, and some of the reserved bytes.
            bytes.extend((0..8192).filter(|at| matches!(at % 4096, 0..80 | 4088..) || at % 97 == 0));
            let whole = Bytes::from(patient.bytes.clone());
            let step = 8 / cases(8);
            flips += cases(8) * bytes.len();
            for at in bytes {
                for bit in (at % step..8).step_by(step) {
                    let flipped = Flipped {
                        bytes: whole.clone(),
                        at: at as u64,
                        mask: 1 << bit,
                    };
                    let found = digest_of_source(flipped).await;
                    assert!(found.is_err() || found == Ok(right), "bit {bit} of byte {at}");
                    assert_eq!(
                        found.is_ok(),
                        at < 8192,
                        "bit {bit} of byte {at}: one superblock may be damaged"
                    );
                }
            }
        });
    }
    println!("{flips} bits flipped");
}

#[test]
fn bytes_in_gaps_and_after_the_end_do_not_change_the_answer() {
    for patient in patients() {
        runtime().block_on(async {
            let right = digest_of(patient.bytes.clone()).await.unwrap();
            let mut bytes = patient.bytes.clone();
            let parts = patient.of_tiles().chain(patient.directory());
            let mut parts: Vec<_> = parts.map(|p| (p.at, p.at + p.length)).collect();
            parts.sort_unstable();
            let mut end = 8192;
            for (from, to) in parts {
                bytes[end..from].fill(0xa5);
                end = to;
            }
            bytes.extend([0x5a; 777]);
            assert_eq!(digest_of(bytes).await, Ok(right));
        });
    }
}

#[test]
fn a_file_with_one_damaged_superblock_is_read() {
    let patient = &patients()[0];
    runtime().block_on(async {
        let right = digest_of(patient.bytes.clone()).await;
        for damaged in [0..4096, 4096..8192] {
            for value in [0, 0xff] {
                let mut bytes = patient.bytes.clone();
                bytes[damaged.clone()].fill(value);
                assert_eq!(digest_of(bytes.clone()).await, right);
                bytes[..8192].fill(value);
                assert!(digest_of(bytes).await.is_err());
            }
        }
    });
}

/// Changes a few bytes of `part`.
fn mutate(random: &mut Random, part: &mut [u8]) {
    /// Numbers that are likely to cause errors.
    const AWFUL: [u64; 12] = [
        0,
        1,
        2,
        7,
        0x7f,
        0xff,
        0xffff,
        0x7fff_ffff,
        0xffff_ffff,
        u64::MAX >> 1,
        u64::MAX,
        1 << 63,
    ];
    for _ in 0..1 + random.below(3) {
        let value = match random.below(3) {
            0 => AWFUL[random.below(AWFUL.len())],
            1 => random.bits(),
            _ => [0.0, -0.0, 1.0, 1e300, 1e-300, f64::NAN, f64::INFINITY, 3.5][random.below(8)].to_bits(),
        };
        let width = [1, 1, 2, 4, 4, 8][random.below(6)].min(part.len());
        let at = random.below(part.len() - width + 1) & !(if random.below(4) == 0 { 0 } else { width - 1 });
        if random.below(5) == 0 {
            // A small step up or down.
            part[at] = part[at].wrapping_add([1, 0xff, 3, 0xfd][random.below(4)]);
        } else {
            part[at..at + width].copy_from_slice(&value.to_le_bytes()[..width]);
        }
    }
}

/// Runs everything that a service would run. The answers must be right only if `verify` accepts the
/// file.
async fn use_all(bytes: Vec<u8>, right: &Digest, story: &str) -> Outcome {
    let Ok(reader) = open_bytes(bytes).await.map_err(message) else {
        return Outcome::Refused;
    };
    let all = async {
        let mut whole = true;
        let (mut points, mut heights) = (Vec::new(), Vec::new());
        let mut tiles = reader.tiles();
        while let Some(tile) = tiles.next().await {
            match tile {
                Ok(tile) => {
                    points.extend(tile.points());
                    heights.extend(tile.vertex_indices().filter_map(|v| Some((tile.point(v), tile.z(v)?))));
                }
                Err(error) => {
                    message(error);
                    whole = false;
                }
            }
        }
        let places = [(0.5, 0.25), (3.0, 3.0), (0.75, 0.125), (6.5, 2.0), (1e30, 0.0)];
        for (x, y) in places {
            let _ = reader.locate(x, y).await.map_err(message);
        }
        let places = places.map(|(x, y)| Point::new(x, y));
        let bulk = BulkOptions::default().threads(1);
        let _ = reader.locate_many(places, bulk).await.map_err(message);
        let surface = Surface::default();
        let _ = reader.surface_z_many(places, surface, bulk).await.map_err(message);
        let found: Result<Vec<_>, _> = reader.triangles_in(Rect::PLANE).try_collect().await;
        whole &= found.map_err(message).is_ok();
        let left = left_after_peeling(&reader).await.map_err(message);
        let digest = reader.recompute_digest().await.map_err(message);
        let shallow = reader.verify(false).await;
        let deep = reader.verify(true).await;
        for verified in [&shallow, &deep] {
            if let Err(VerifyError::Read(error)) = verified {
                message(error.clone());
            }
        }
        if let Ok(report) = deep {
            assert!(whole && shallow.is_ok(), "{story}");
            let digest = digest.unwrap();
            // A moved vertex may be valid, but then the triangulation must be that of the moved
            // points.
            let mut expected = reference(EngineKind::Native, &points);
            heights.iter().for_each(|&(p, z)| expected.add_z(p, z));
            assert_eq!(digest, expected, "{story}");
            assert_eq!(reader.metadata().digest, expected, "{story}");
            assert_eq!(
                (report.vertices, report.triangles),
                (digest.vertices.count, digest.triangles.count),
                "{story}"
            );
            let bounds = Rect::around(points.iter().copied());
            assert_eq!(reader.metadata().bounds, bounds, "{story}");
            check_z(&reader, story).await;
            check_peeling(&reader, left.unwrap(), story).await;
            assert!(
                points.iter().all(|p| p.x.to_bits() == p.normalized().x.to_bits()),
                "{story}"
            );
            assert!(
                points.iter().all(|p| p.y.to_bits() == p.normalized().y.to_bits()),
                "{story}"
            );
            if digest == *right {
                Outcome::Same
            } else {
                Outcome::OtherPoints
            }
        } else {
            Outcome::Found
        }
    };
    match tokio::time::timeout(LONGEST, all).await {
        Ok(outcome) => outcome,
        Err(_) => panic!("{story}: it hangs"),
    }
}

/// Checks that tiles have the z of each corner of their triangles as its owner has it.
async fn check_z(reader: &TileReader, story: &str) {
    let tiles: Vec<_> = reader.tiles().try_collect().await.unwrap();
    for tile in &tiles {
        for corner in tile.triangle_ids().flat_map(|triangle| tile.corners(triangle)) {
            let id = tile.vertex(corner).id;
            let right = tiles[id.tile.0 as usize].z(id.index);
            assert_eq!(tile.z(corner).map(f64::to_bits), right.map(f64::to_bits), "{story}");
            assert_eq!(right.is_some_and(f64::is_finite), reader.metadata().has_z, "{story}");
        }
    }
}

/// Triangles with a longer edge are peeled off from the hull.
const LONG: f64 = 0.3;

async fn left_after_peeling(reader: &TileReader) -> Result<u64, ReadError> {
    let options = ExportOptions::default().max_edge(Some(LONG)).from_hull(true);
    match export(reader, Format::Obj, options, vec![io::sink()], |_, _| ()).await {
        Ok(exported) => Ok(exported.triangles),
        Err(ExportError::Read(error)) => Err(error),
        Err(error) => panic!("{error}"),
    }
}

/// Checks the number of triangles that are left against a flood over all triangles.
async fn check_peeling(reader: &TileReader, left: u64, story: &str) {
    let tiles: Vec<_> = reader.tiles().try_collect().await.unwrap();
    let owned = |tile: &Arc<Tile>| {
        let triangles = tile.owned_triangles().map(|triangle| tile.triangle_points(triangle));
        triangles.collect::<Vec<_>>()
    };
    let peeled = peeled(&tiles.iter().flat_map(owned).collect::<Vec<_>>(), LONG);
    let expected = peeled.iter().filter(|is_peeled| !**is_peeled).count();
    assert_eq!(left, expected as u64, "{story}");
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    Refused,
    Found,
    Same,
    OtherPoints,
}

#[test]
fn changed_bytes_with_right_checksums_never_give_a_wrong_answer() {
    let mut outcomes = [0; 4];
    for (number, patient) in patients().into_iter().enumerate() {
        let right = runtime().block_on(digest_of(patient.bytes.clone())).unwrap();
        let runtime = runtime();
        for seed in 0..1000 {
            let mut random = Random(1_000_000 * number as u64 + seed);
            let mut mutated = patient.clone();
            let group = random.below(8);
            let part = match group {
                0..3 => patient.cores[random.below(patient.cores.len())],
                3..5 => patient.borders[random.below(patient.borders.len())],
                5..7 => patient.pages[0],
                _ => *patient
                    .directory()
                    .nth(random.below(patient.directory().count()))
                    .unwrap(),
            };
            mutate(&mut random, &mut mutated.bytes[part.at..part.at + part.length]);
            mutated.sew();
            if group < 7 && random.below(4) > 0 {
                runtime.block_on(fix_digest(&mut mutated));
            }
            let story = format!("file {number}, seed {seed}, group {group}");
            let outcome = runtime.block_on(use_all(mutated.bytes, &right, &story));
            outcomes[outcome as usize] += 1;
        }
    }
    println!("refused, found, same, other points: {outcomes:?}");
    assert!(outcomes[..3].iter().all(|&n| n > 50), "{outcomes:?}");
}

/// A z that is not the owner's is found, and one that is none is refused.
#[test]
fn changed_z_of_foreign_vertices_with_right_checksums_is_found() {
    /// The slot of `foreign_z` in a border.
    const FOREIGN_Z: usize = 13;
    let patient = patients().pop().unwrap();
    let mut outcomes = [0; 2];
    let runtime = runtime();
    for border in &patient.borders {
        let table = support::flat::Table::root(&patient.bytes[border.at..]);
        let (first, count) = table.vector(FOREIGN_Z).expect("the file has z");
        assert!(count > 0);
        for (place, &value) in (0..count).zip([f64::NAN, 1e9, f64::INFINITY, -0.5, f64::MAX].iter().cycle()) {
            let mut mutated = patient.clone();
            mutated.put(border.at + first + 8 * place, &value.to_le_bytes());
            mutated.sew();
            let found = runtime.block_on(digest_of(mutated.bytes)).unwrap_err();
            let says = match value.is_finite() {
                true => format!("has z {value:?}, but the tile that owns it says "),
                false => "of another tile has no finite z".to_owned(),
            };
            assert!(found.contains(&says), "{found}");
            outcomes[usize::from(value.is_finite())] += 1;
        }
        // A vector of another length.
        let mut mutated = patient.clone();
        mutated.put(border.at + first - 4, &(count as u32 - 1).to_le_bytes());
        mutated.sew();
        let found = runtime.block_on(digest_of(mutated.bytes)).unwrap_err();
        assert!(found.contains("z of foreign vertices, not"), "{found}");
    }
    assert!(outcomes.iter().all(|&n| n > 20), "{outcomes:?}");
}

#[test]
fn changed_superblocks_with_right_checksums_never_give_a_wrong_answer() {
    let patient = &patients()[1];
    let right = runtime().block_on(digest_of(patient.bytes.clone())).unwrap();
    let runtime = runtime();
    for seed in 0..500 {
        let mut random = Random(77_000 + seed);
        let mut mutated = patient.clone();
        mutate(&mut random, &mut mutated.bytes[8..72]);
        mutated.sew_superblocks();
        runtime.block_on(use_all(mutated.bytes, &right, &format!("seed {seed}")));
    }
}

/// Readers allocate by the counts in the directory, so the file's length must bound them.
#[test]
fn counts_that_exceed_the_file_are_refused() {
    let patient = &patients()[1];
    runtime().block_on(async {
        // vertices; core, border and owned triangles.
        for field in [48, 52, 56, 60] {
            let mut mutated = patient.clone();
            let entry = patient.entries[1];
            mutated.put(entry + field, &0xffff_fff0u32.to_le_bytes());
            fix_sums(&mut mutated);
            mutated.sew();
            let error = directory_of(mutated.bytes).await.err();
            assert!(
                matches!(error, Some(ReadError::Invalid { .. })),
                "field {field}: {error:?}"
            );
        }
        // All tiles claim the same large extent.
        let mut mutated = patient.clone();
        let end = mutated.bytes.len() as u64;
        for &entry in &patient.entries {
            mutated.put(entry, &8192u64.to_le_bytes());
            for length in [16, 24] {
                mutated.put(entry + length, &((end - 8192) as u32).to_le_bytes());
            }
        }
        mutated.cores.clear();
        mutated.borders.clear();
        mutated.tables.clear();
        mutated.sew();
        let error = directory_of(mutated.bytes).await.err();
        assert!(matches!(error, Some(ReadError::Invalid { .. })), "{error:?}");
    });
}

/// Opens a file and reads its whole directory.
async fn directory_of(bytes: Vec<u8>) -> Result<Arc<Directory>, ReadError> {
    open_bytes(bytes).await?.directory().await
}

/// Sets the root's sums of vertices and triangles to those of the entries.
fn fix_sums(patient: &mut Patient) {
    let sum = |field: usize| -> u64 {
        patient
            .entries
            .iter()
            .map(|e| u64::from(support::flat::u32_at(&patient.bytes, e + field)))
            .sum()
    };
    let (vertices, triangles) = (sum(48), sum(60));
    let root = support::flat::Table::root(&patient.bytes[patient.root.at..]);
    let offsets = [3, 4].map(|slot| patient.root.at + root.field(slot).unwrap());
    patient.put(offsets[0], &vertices.to_le_bytes());
    patient.put(offsets[1], &triangles.to_le_bytes());
}

/// Files of several origins may share a service's cache, whose keys contain the file's id, which
/// anybody can copy.
#[test]
fn a_file_cannot_pass_for_another_in_a_shared_cache() {
    let [one, other, _] = patients().try_into().ok().unwrap();
    let mut impostor = other.clone();
    let id = one.bytes[16..32].to_vec();
    impostor.put(16, &id);
    let crc = crc32c::crc32c(&impostor.bytes[..4092]);
    impostor.put(4092, &crc.to_le_bytes());
    impostor.bytes.copy_within(..4096, 4096);
    runtime().block_on(async {
        let cache = Cache::new(1 << 30);
        let mut seen = Vec::new();
        for bytes in [one.bytes, impostor.bytes, other.bytes] {
            let options = OpenOptions::default().cache(&cache);
            let reader = TileReader::open_source(MemoryFile::new(bytes), "file", options).await;
            let reader = reader.unwrap();
            let directory = reader.directory().await.unwrap();
            let mut points = Vec::new();
            for id in directory.tile_ids() {
                points.extend(reader.tile(id).await.unwrap().points());
            }
            seen.push((reader.file_id(), points));
        }
        assert!(seen[0].0 == seen[1].0 && seen[0].1 != seen[1].1);
        assert!(seen[1].0 != seen[2].0 && seen[1].1 == seen[2].1);
    });
}

#[test]
fn a_negative_zero_coordinate_is_refused() {
    let patient = &patients()[0];
    let at = patient.cores[0].at;
    let zero = [0u8; 16];
    // The grid has a corner at the origin; its coordinates are sixteen zero bytes, aligned to
    // eight.
    let core = &patient.bytes[at..at + patient.cores[0].length];
    let (first, count) = support::flat::Table::root(core).vector(2).unwrap();
    let vertex = (0..count / 2).find(|v| core[first + 16 * v..][..16] == zero).unwrap();
    let mut mutated = patient.clone();
    mutated.put(at + first + 16 * vertex, &(-0.0f64).to_le_bytes());
    mutated.sew();
    assert!(runtime().block_on(digest_of(mutated.bytes)).is_err());
}

#[test]
fn files_that_are_no_tile_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file");
    let mut random = Random(5);
    let noise: Vec<u8> = (0..50_000).map(|_| random.bits() as u8).collect();
    let text = "x,y\n1.5,2.5\n".repeat(2000).into_bytes();
    let mut magic = vec![0; 20_000];
    magic[..8].copy_from_slice(b"DELTILES");
    let files = [
        Vec::new(),
        vec![0; 8192],
        vec![0; 100_000],
        noise,
        text,
        magic,
        b"DELTILES".to_vec(),
    ];
    runtime().block_on(async {
        for bytes in files {
            std::fs::write(&path, &bytes).unwrap();
            let error = TileReader::open(&path, OpenOptions::default()).await.err();
            assert!(
                matches!(error, Some(ReadError::Invalid { .. })),
                "{} bytes: {error:?}",
                bytes.len()
            );
        }
        for path in [
            folder.path().to_owned(),
            folder.path().join("missing"),
            path.join("below a file"),
        ] {
            let error = TileReader::open(&path, OpenOptions::default()).await.err();
            assert!(matches!(error, Some(ReadError::Io { .. })), "{error:?}");
        }
    });
}
