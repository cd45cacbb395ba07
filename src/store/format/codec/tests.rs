use bytes::Bytes;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};

use super::column::Coding;
use super::encode_column::encode_floats;
use super::planes::{Cursor, PlanData, planes_for, unzigzag, zigzag};
use super::{Codec, MAX_RATIO, Part, StoredPart, encode_plan, fields, plan};
use crate::geometry::{HalfEdge, PackedHalfEdge, Point, VertexIndex};
use crate::io::Buffers;
use crate::mesh::Twin;
use crate::store::format::edge_source::{EdgeSource, LineKind};
use crate::store::format::encode::{BorderDraft, CoreDraft};
use crate::store::format::ids::{TileId, VertexId};
use crate::store::format::line_part::LinePart;

/// Pseudo-random numbers from a seed.
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 17) % limit.max(1)
    }
}

/// The kinds of floating-point numbers in drafts.
const KINDS: u64 = 6;

fn float(kind: u64, numbers: &mut Numbers) -> f64 {
    let integer = numbers.below(1 << 20) as f64 - 300_000.0;
    match kind {
        0 => integer,
        1 => integer * 0.01 + 637_000.0,
        2 => integer / 256.0,
        3 => f64::from(integer as f32 * 0.1),
        4 => (integer * 0.7).sin(),
        // Anything, NaN and infinities among them.
        _ => f64::from_bits(numbers.below(u64::MAX) << 17 | numbers.below(1 << 17)),
    }
}

/// Returns drafts that need not be triangulations: all that the encoder may assume is the layout.
fn drafts(seed: u64, vertices: u64, triangles: u64, are_mutual: bool) -> (CoreDraft, BorderDraft) {
    let numbers = &mut Numbers(seed);
    let kind = numbers.below(KINDS);
    let mut corners = |count: u64| -> Vec<[u32; 3]> {
        let corner = |_| [(); 3].map(|()| numbers.below(vertices) as u32);
        (0..count).map(corner).collect()
    };
    let (core_corners, border_corners) = (corners(triangles), corners(triangles / 3));
    let mut neighbours = vec![[PackedHalfEdge::NONE; 3]; triangles as usize];
    for _ in 0..2 * triangles {
        let [a, b] = [(); 2].map(|()| numbers.below(3 * triangles) as u32);
        let flat = neighbours.as_flattened_mut();
        let are_free = [a, b].iter().all(|&h| flat[h as usize].get().is_none());
        if !are_mutual || a != b && are_free {
            flat[a as usize] = HalfEdge(b).into();
            flat[b as usize] = HalfEdge(a).into();
        }
    }
    let largest = 1 << numbers.below(60);
    let core = CoreDraft {
        points: (0..vertices)
            .map(|_| Point::new(float(kind, numbers), float(kind, numbers)))
            .collect(),
        z: (0..vertices).map(|_| float(kind, numbers)).collect(),
        records: (0..vertices).map(|_| numbers.below(largest)).collect(),
        triangles: core_corners,
        neighbours,
        components: (0..triangles).map(|i| (i / 5) as u32).collect(),
        edge_sources: (0..triangles / 2)
            .map(|i| {
                let source = EdgeSource::new(LineKind::Obstacle, numbers.below(largest) >> 5);
                (2 * i as u32, LinePart::of(source, i % 3 > 0, i % 5 > 0))
            })
            .collect(),
        sites: (0..vertices / 4)
            .map(|i| (3 * i as u32, numbers.below(largest)))
            .collect(),
        ..CoreDraft::default()
    };
    let foreign = |i: u32| {
        let id = VertexId {
            tile: TileId(i / 7),
            index: VertexIndex(numbers.below(70_000) as u32),
        };
        (id, Point::new(float(kind, numbers), float(kind, numbers)))
    };
    let border = BorderDraft {
        vertices: vertices as u32,
        core_triangles: triangles as u32,
        foreign: (0..vertices as u32 / 2).map(foreign).collect(),
        triangles: border_corners,
        neighbours: vec![[Twin::Hull, Twin::Elsewhere, Twin::HalfEdge(HalfEdge(2))]; triangles as usize / 3],
        core_links: (0..triangles as u32 / 9).map(|i| (2 * i, i)).collect(),
        components: vec![3; triangles as usize / 3],
        ..BorderDraft::default()
    };
    (core, border)
}

fn encoded((core, border): &(CoreDraft, BorderDraft)) -> [(Bytes, Part); 2] {
    let buffers = Buffers::default();
    [
        (core.encode(TileId(3), 1, &buffers), Part::Core),
        (border.encode(TileId(3), 1, &buffers), Part::Border),
    ]
}

fn decoded(stored: &StoredPart) -> Bytes {
    stored.codec.decode(&stored.bytes, stored.decoded as u32).unwrap()
}

#[test]
fn parts_of_any_content_decode_to_the_same_bytes() {
    let config = ProptestConfig {
        cases: 200,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(1),
        ..ProptestConfig::default()
    };
    let sizes = (any::<u64>(), 0u64..400, 0u64..900, any::<bool>());
    TestRunner::new(config)
        .run(&sizes, |(seed, vertices, triangles, are_mutual)| {
            let triangles = if vertices == 0 { 0 } else { triangles };
            for (raw, part) in encoded(&drafts(seed, vertices, triangles, are_mutual)) {
                let stored = Codec::Zstandard.store(raw.clone(), part);
                prop_assert_eq!(stored.codec, Codec::Zstandard);
                prop_assert_eq!(stored.decoded, raw.len());
                prop_assert_eq!(decoded(&stored), raw);
            }
            Ok(())
        })
        .unwrap();
}

#[test]
fn bytes_that_shrink_beyond_the_limit_are_stored_as_they_are() {
    let core = CoreDraft {
        points: vec![Point::new(0.0, 0.0); 1 << 20],
        records: vec![0; 1 << 20],
        ..CoreDraft::default()
    };
    let raw = core.encode(TileId(0), 1, &Buffers::default());
    let stored = Codec::Zstandard.store(raw.clone(), Part::Core);
    assert_eq!((stored.codec, &stored.bytes), (Codec::Raw, &raw));
    let shrunk = super::zstandard::encode(&raw, Part::Core).unwrap();
    assert!(shrunk.len() as u64 * MAX_RATIO < raw.len() as u64);
}

/// Coordinates of LAS files are scale · integer + offset, with rounding errors.
#[test]
fn decimals_with_rounding_errors_take_three_bytes_and_others_their_bits() {
    let column = |value: &dyn Fn(f64) -> f64| {
        let values: Vec<f64> = (0..5000u32).map(|i| value(f64::from(i * 7919 % 100_003))).collect();
        let mut data = PlanData::default();
        let column = encode_floats(&mut data, &values);
        let mut rows = vec![0; 8 * values.len()];
        let mut cursor = Cursor::new(&data.bytes);
        column.decode(&mut cursor, &mut rows, 8, 0).unwrap();
        cursor.end().unwrap();
        let bits: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        assert!(rows == bits);
        column
    };
    let decimals: [&dyn Fn(f64) -> f64; 6] = [
        &|i| i,
        &|i| i * 0.01 + 637_177.98,
        &|i| (i - 500.0) * 0.001 + 849_000.25,
        &|i| i * 0.3048,
        &|i| -(i + 1.0) / 65_536.0,
        &|i| i * 1_000_000.0,
    ];
    for value in decimals {
        let column = column(value);
        assert!(
            matches!(column.coding, Coding::Decimals(_)) && column.planes <= 4,
            "{column:?}"
        );
    }
    for value in [&|i: f64| i.sqrt() as _, &|i: f64| -0.0 * i] as [&dyn Fn(f64) -> f64; 2] {
        assert_eq!(column(value).coding, Coding::Floats);
    }
}

#[test]
fn zigzag_is_undone_and_planes_suffice() {
    for value in [0, 1, -1, 127, -128, 128, i64::MAX, i64::MIN] {
        assert_eq!(unzigzag(zigzag(value)), value);
        let planes = planes_for(zigzag(value));
        assert!(planes == 8 || zigzag(value) < 1 << (8 * planes));
        assert!(planes == 0 || zigzag(value) >= 1 << (8 * (planes - 1)));
    }
}

/// A part of a plan, a header above all, may say anything.
#[test]
fn changed_plans_give_an_error_or_other_bytes() {
    let mut numbers = Numbers(7);
    let mut outcomes = [0; 2];
    for seed in 0..4 {
        for (raw, part) in encoded(&drafts(seed, 50, 60, true)) {
            let fields = match part {
                Part::Core => fields::of_core(&raw),
                Part::Border => fields::of_border(&raw),
            };
            let right = encode_plan::encode(&raw, &fields.unwrap()).bytes;
            let mut out = vec![0; raw.len()];
            plan::decode(&right, &mut out).unwrap();
            assert_eq!(out, raw);
            for length in (0..right.len()).chain([right.len() + 1]) {
                let mut cut = right.clone();
                cut.resize(length, 0);
                assert!(plan::decode(&cut, &mut out).is_err(), "{length}");
            }
            for _ in 0..5000 {
                let mut plan = right.clone();
                for _ in 0..=numbers.below(3) {
                    let at = match numbers.below(2) {
                        0 => numbers.below(plan.len() as u64),
                        _ => numbers.below(300),
                    } as usize;
                    plan[at] =
                        [0, 1, 2, 8, 0x7f, 0xff, plan[at] ^ 1, plan[at].wrapping_add(1)][numbers.below(8) as usize];
                }
                outcomes[usize::from(plan::decode(&plan, &mut out).is_ok())] += 1;
            }
        }
    }
    assert!(outcomes.iter().all(|&n| n > 1000), "{outcomes:?}");
}

#[test]
fn wrong_lengths_of_plans_and_buffers_are_refused() {
    let (raw, part) = encoded(&drafts(1, 100, 150, true)).into_iter().next().unwrap();
    let stored = Codec::Zstandard.store(raw.clone(), part);
    for length in [
        0,
        raw.len() as u32 / 2,
        raw.len() as u32 - 1,
        raw.len() as u32 + 1,
        64 << 20,
    ] {
        assert!(Codec::Zstandard.decode(&stored.bytes, length).is_err(), "{length}");
    }
    for length in [0, 1, 100, u32::MAX] {
        let mut bytes = stored.bytes.to_vec();
        bytes[..4].copy_from_slice(&length.to_le_bytes());
        assert!(
            Codec::Zstandard.decode(&bytes.into(), raw.len() as u32).is_err(),
            "{length}"
        );
    }
    for end in 0..stored.bytes.len() {
        let cut = stored.bytes.slice(..end);
        assert!(Codec::Zstandard.decode(&cut, raw.len() as u32).is_err(), "{end}");
    }
}
