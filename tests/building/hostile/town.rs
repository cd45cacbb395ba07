//! Files with walls, holes, sites and regions, and files of lines without triangles, damaged in the
//! same ways.

use bytes::Bytes;
use delaunay_tiles::Builder;
use delaunay_tiles::geometry::{Point, Rect};
use delaunay_tiles::input::{SegmentBatch, SiteBatch, SiteId};
use delaunay_tiles::query::{Mode, QueryOptions};
use delaunay_tiles::store::{Digest, EdgeSource, LineKind, TileId, TileReader};
use futures::stream::StreamExt;

use super::digest::{digest_sums, fix_digest};
use super::surgery::{FilePart, Patient};
use super::{Flipped, LONGEST, digest_of, digest_of_source, message, mutate, options};
use crate::support::flat::Table;
use crate::support::{Random, Scratch, batches, open_bytes, runtime, verify_lines};

type SourcedSegment = ([Point; 2], EdgeSource);

/// The input of a file.
pub struct Town {
    points: Vec<Point>,
    lines: Vec<SourcedSegment>,
    sites: Vec<(Point, &'static str)>,
    seeds: Vec<Point>,
}

fn at([x, y]: [f64; 2]) -> Point {
    Point::new(x, y)
}

fn chain(kind: LineKind, number: u64, corners: &[[f64; 2]]) -> Vec<SourcedSegment> {
    let segments = corners.windows(2).map(|ends| [at(ends[0]), at(ends[1])]);
    segments.map(|ends| (ends, EdgeSource::new(kind, number))).collect()
}

/// A house with a court, a wall, a path along a part of it, a walled garden with a hole point, and
/// shops.
pub fn town() -> Town {
    let square = |a: f64, b: f64| [[a, a], [b, a], [b, b], [a, b], [a, a]];
    let mut court = square(2.0, 3.0);
    court.reverse();
    Town {
        points: (0..64).map(|i| at([f64::from(i % 8), f64::from(i / 8)])).collect(),
        lines: [
            chain(LineKind::BreakLine, 0, &[[0.0, 7.0], [4.0, 7.0], [7.0, 6.5]]),
            chain(LineKind::Wall, 1, &[[2.0, 7.0], [6.0, 7.0]]),
            chain(LineKind::Wall, 2, &square(5.0, 6.0)),
            chain(LineKind::Obstacle, 3, &square(1.0, 4.0)),
            chain(LineKind::Obstacle, 3, &court),
        ]
        .concat(),
        sites: vec![
            (at([7.0, 0.0]), "baker"),
            (at([7.0, 0.0]), "cobbler"),
            (at([0.5, 0.25]), "miller"),
        ],
        seeds: vec![at([5.5, 5.25])],
    }
}

/// Collinear points, without triangles.
fn street() -> Town {
    let on = |i: u32| at([f64::from(i), 9.0 - 2.0 * f64::from(i)]);
    let between = |a, b, kind, number| ([on(a), on(b)], EdgeSource::new(kind, number));
    Town {
        points: (0..40).map(on).collect(),
        lines: vec![
            between(35, 3, LineKind::BreakLine, 0),
            between(10, 20, LineKind::Wall, 1),
            between(15, 16, LineKind::Wall, 2),
        ],
        sites: vec![(on(5), "baker"), (on(39), "miller")],
        seeds: Vec::new(),
    }
}

impl Town {
    pub async fn build(&self) -> Patient {
        self.build_in_tiles_of(8).await
    }

    pub async fn build_in_tiles_of(&self, vertices: usize) -> Patient {
        let scratch = Scratch::new();
        let mut builder = Builder::new(&scratch.path, options().tile_vertices(vertices)).unwrap();
        for (ends, source) in &self.lines {
            let batch = SegmentBatch {
                ends: vec![*ends],
                lines: vec![0],
                ..SegmentBatch::default()
            };
            builder.push_lines(source.kind(), source.number(), &batch).unwrap();
        }
        builder.push_seeds(&self.seeds).unwrap();
        builder.push_sites(&self.sites()).unwrap();
        for batch in batches(&self.points, &[]) {
            builder.push(&batch).await.unwrap();
        }
        builder.finish().await.unwrap();
        Patient::new(std::fs::read(&scratch.path).unwrap())
    }

    fn sites(&self) -> SiteBatch {
        SiteBatch {
            points: self.sites.iter().map(|site| site.0).collect(),
            ids: self.sites.iter().map(|site| SiteId::Text(site.1.to_owned())).collect(),
            ..SiteBatch::default()
        }
    }

    /// Returns whether a file has exactly these lines and sites.
    async fn is_in(&self, reader: &TileReader) -> bool {
        let mut sites = Some(self.sites());
        let sites = reader.verify_sites(|batch| Ok::<_, String>(sites.take().map(|all| *batch = all).is_some()));
        sites.await.is_ok() && verify_lines(reader, self.lines.clone()).await.is_ok()
    }

    /// Reads all that a file stores of lines, regions and sites. Returns whether the file verifies
    /// and has these lines and sites; if so, its content must be right.
    pub async fn use_all(&self, bytes: Vec<u8>, right: &Digest, story: &str) -> Option<bool> {
        let reader = open_bytes(bytes).await.map_err(message).ok()?;
        let all = async {
            let mut tiles = reader.tiles();
            while let Some(tile) = tiles.next().await {
                let Ok(tile) = tile.map_err(message) else { continue };
                for edge in tile.owned_constraints() {
                    assert!(tile.ends(edge).iter().all(|end| end.point.is_valid()), "{story}");
                    assert!(tile.edge_parts(edge).count() < 1 << 20, "{story}");
                    let _ = (tile.is_constraint(edge), tile.is_wall(edge));
                }
                for triangle in tile.triangle_ids() {
                    let _ = (tile.region(triangle), tile.depth(triangle), tile.is_hole(triangle));
                }
                assert!(tile.sites().all(|site| tile.is_site(site.vertex)), "{story}");
                let points = tile.vertex_indices().filter(|&vertex| tile.is_input_point(vertex));
                assert!(points.count() <= tile.vertex_count() as usize, "{story}");
            }
            let _ = reader.locate(3.0, 3.0).await.map_err(message);
            let mut found = reader.triangles_in(Rect::PLANE);
            while let Some(triangle) = found.next().await {
                if triangle.map_err(message).is_err() {
                    break;
                }
            }
            // Searches end without a budget, even if the triangles contradict each other.
            let options = || QueryOptions::default().certified();
            for from in [[0.5, 0.4], [6.5, -2.0], [7.5, 9.0]].map(at) {
                let mut sites = reader.nearest_sites(from, options());
                while let Some(Ok(site)) = sites.next().await {
                    assert!(site.distance.value >= 0.0, "{story}");
                }
                for mode in [Mode::Exact, Mode::Fast] {
                    let _ = reader.shortest_path(from, at([6.5, 7.5]), options().mode(mode)).await;
                }
            }
            let digest = reader.recompute_digest().await.map_err(message);
            let is_proven = reader.verify(true).await.is_ok();
            let is_same = self.is_in(&reader).await;
            if is_proven && is_same {
                let digest = digest.unwrap();
                assert_eq!(reader.metadata().digest, digest, "{story}");
                // Vertices may have moved, and other hole points may give other holes.
                if digest.vertices == right.vertices
                    && reader.lists().await.is_ok_and(|lists| lists.hole_points == self.seeds)
                {
                    assert_eq!(digest, *right, "{story}");
                }
            }
            is_proven && is_same
        };
        match tokio::time::timeout(LONGEST, all).await {
            Ok(is_right) => Some(is_right),
            Err(_) => panic!("{story}: it hangs"),
        }
    }
}

#[test]
fn changed_bytes_of_towns_with_right_checksums_never_give_a_wrong_answer() {
    for (number, town) in [town(), street()].into_iter().enumerate() {
        let mut outcomes = [0; 3];
        let runtime = runtime();
        let patient = runtime.block_on(town.build());
        let right = runtime.block_on(digest_of(patient.bytes.clone())).unwrap();
        assert!(right.constraint_edges.count > 20);
        let whole = runtime.block_on(town.use_all(patient.bytes.clone(), &right, "as it was built"));
        assert_eq!(whole, Some(true));
        for seed in 0..700 {
            let mut random = Random(3_000_000 + 10_000 * number as u64 + seed);
            let mut mutated = patient.clone();
            let part = match random.below(8) {
                0..3 => patient.cores[random.below(patient.cores.len())],
                3..6 => patient.borders[random.below(patient.borders.len())],
                6 => patient.pages[0],
                _ => *patient
                    .directory()
                    .nth(random.below(patient.directory().count()))
                    .unwrap(),
            };
            mutate(&mut random, &mut mutated.bytes[part.at..part.at + part.length]);
            mutated.sew();
            if part.at != patient.root.at && random.below(4) > 0 {
                runtime.block_on(fix_digest(&mut mutated));
            }
            let story = format!("file {number}, seed {seed}");
            let outcome = runtime.block_on(town.use_all(mutated.bytes, &right, &story));
            outcomes[outcome.map_or(0, |is_right| 1 + usize::from(is_right))] += 1;
        }
        println!("refused, found, same: {outcomes:?}");
        assert!(outcomes.iter().all(|&n| n > 30), "{outcomes:?}");
    }
}

/// What holds vertices and edges is not in the digest. Each bit counts nevertheless.
#[test]
fn changed_bits_of_what_holds_vertices_and_edges_are_found() {
    /// The slots of `input_points` and `segment_ends` in a core, and of the latter in a border.
    const INPUT_POINTS: usize = 17;
    const SEGMENT_ENDS: [usize; 2] = [18, 14];
    let mut flipped = [0; 2];
    for town in [town(), street()] {
        runtime().block_on(async {
            let patient = town.build().await;
            let mut bits: Vec<(usize, usize, usize)> = Vec::new();
            let reader = open_bytes(patient.bytes.clone()).await.unwrap();
            for (number, (core, border)) in patient.cores.iter().zip(&patient.borders).enumerate() {
                let vertices = reader.tile(TileId(number as u32)).await.unwrap().vertex_count() as usize;
                let table = |part: &FilePart| Table::root(&patient.bytes[part.at..]);
                if let Some((first, _)) = table(core).vector(INPUT_POINTS) {
                    bits.extend((0..vertices).map(|bit| (0, core.at + first + bit / 8, bit % 8)));
                }
                for (part, slot) in [core, border].into_iter().zip(SEGMENT_ENDS) {
                    let sources = table(part).table(slot_of_sources(slot)).map_or(0, packed_length);
                    if let Some((first, length)) = table(part).vector(slot) {
                        assert_eq!(length, sources.div_ceil(4));
                        bits.extend((0..2 * sources).map(|bit| (1, part.at + first + bit / 8, bit % 8)));
                    }
                }
            }
            for (what, at, bit) in bits {
                let mut mutated = patient.clone();
                mutated.bytes[at] ^= 1 << bit;
                mutated.sew();
                let reader = open_bytes(mutated.bytes).await.unwrap();
                let story = format!("bit {bit} at {at}");
                match what {
                    0 => assert!(reader.verify(false).await.is_err(), "{story}"),
                    _ => assert!(!town.is_in(&reader).await, "{story}"),
                }
                flipped[what] += 1;
            }
        });
    }
    assert!(flipped[0] > 5 && flipped[1] > 50, "{flipped:?}");
}

/// Returns the slot of `edge_sources` in the table that has `segment_ends` in a slot.
fn slot_of_sources(slot_of_ends: usize) -> usize {
    match slot_of_ends {
        18 => 13,
        _ => 11,
    }
}

/// Returns the number of integers of a `Packed`.
fn packed_length(packed: Table<'_>) -> usize {
    let width = usize::from(packed.u8(0));
    let (_, bytes) = packed.vector(1).unwrap();
    (bytes - (8 - width)) / width
}

/// A reader shows the digest that the file stores. What proves something reads the tiles.
#[test]
fn a_changed_digest_with_right_checksums_is_found() {
    for town in [town(), street()] {
        runtime().block_on(async {
            let patient = town.build().await;
            let right = digest_of(patient.bytes.clone()).await.unwrap();
            for at in digest_sums(&patient).into_iter().flat_map(|sum| sum..sum + 24) {
                for mask in [1, 0x80, 0xff] {
                    let mut mutated = patient.clone();
                    mutated.bytes[at] ^= mask;
                    mutated.sew();
                    let reader = open_bytes(mutated.bytes.clone()).await.unwrap();
                    assert_ne!(reader.metadata().digest, right, "byte {at}");
                    assert_eq!(reader.recompute_digest().await.unwrap(), right, "byte {at}");
                    for deep in [false, true] {
                        let error = reader.verify(deep).await.unwrap_err().to_string();
                        assert!(error.contains("the digest of its tiles is"), "byte {at}: {error}");
                    }
                    fix_digest(&mut mutated).await;
                    assert!(mutated.bytes == patient.bytes, "byte {at}");
                }
            }
        });
    }
}

#[test]
fn a_flipped_bit_of_a_town_is_detected() {
    for town in [town(), street()] {
        runtime().block_on(async {
            let patient = town.build().await;
            let right = digest_of(patient.bytes.clone()).await.unwrap();
            let bytes: Vec<usize> = patient
                .of_tiles()
                .chain(patient.directory())
                .flat_map(|part| part.at..part.at + part.length)
                .collect();
            let whole = Bytes::from(patient.bytes.clone());
            let mut random = Random(8);
            for _ in 0..3000 {
                let (at, bit) = (bytes[random.below(bytes.len())], random.below(8));
                let flipped = Flipped {
                    bytes: whole.clone(),
                    at: at as u64,
                    mask: 1 << bit,
                };
                let found = digest_of_source(flipped).await;
                assert!(found.is_err(), "bit {bit} of byte {at}: {found:?}, not {right:?}");
            }
        });
    }
}
