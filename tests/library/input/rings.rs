//! The direction of rings against what a person would call inside: by counting how often a ray crosses a ring.
//!
//! All randomness is by a fixed seed.

use crate::input::obstacles::polygon;
use crate::input::segments::{drain, open};
use crate::input::{data, shared};
use delaunay_tiles::geometry::{Orientation, Point, orient2d};
use delaunay_tiles::input::SegmentSource;
use proptest::collection::vec;
use proptest::prelude::*;
use std::path::PathBuf;

/// How often segments go around a point, counter-clockwise; `None` if it is on one.
fn winding(segments: &[[f64; 4]], p: Point) -> Option<i64> {
    let mut winding = 0;
    for &[x1, y1, x2, y2] in segments {
        let (upwards, downwards) = (y1 <= p.y && p.y < y2, y2 <= p.y && p.y < y1);
        if upwards || downwards {
            winding += match orient2d(Point::new(x1, y1), Point::new(x2, y2), p) {
                Orientation::CounterClockwise if upwards => 1,
                Orientation::Clockwise if downwards => -1,
                Orientation::Collinear => return None,
                _ => 0,
            };
        }
    }
    Some(winding)
}

fn segments_of(ring: &[[f64; 2]]) -> Vec<[f64; 4]> {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| [a[0], a[1], b[0], b[1]]).collect()
}

/// Points near the vertices, where an error shows, and all over the place.
fn samples(rings: &[Vec<[f64; 2]>]) -> Vec<Point> {
    let vertices: Vec<[f64; 2]> = rings.concat();
    let near = vertices
        .windows(3)
        .map(|w| [0, 1].map(|k| (w[0][k] + w[1][k] + w[2][k]) / 3.0));
    let far = vertices.iter().zip(vertices.iter().skip(7).step_by(3));
    let far = far.map(|(a, b)| [0, 1].map(|k| 0.61 * a[k] + 0.39 * b[k]));
    let all: Vec<[f64; 2]> = near.chain(far).collect();
    let step = 1 + all.len() / 200;
    all.iter().step_by(step).map(|&[x, y]| Point::new(x, y)).collect()
}

/// A polygon of earcutr: what comes out goes around a point once where an odd number of rings has it in, and else not at
/// all. This holds for degenerate ones too, as long as no ring crosses itself.
fn check_fixture(path: &std::path::Path) {
    let text = std::fs::read_to_string(path).unwrap();
    let rings: Vec<Vec<[f64; 2]>> = serde_json::from_str(&text).unwrap();
    let slices: Vec<&[[f64; 2]]> = rings.iter().map(Vec::as_slice).collect();
    let found = open(
        &[("fixture.json", polygon(&slices).as_bytes())],
        SegmentSource::open_obstacles,
    );
    let found = found.unwrap().ends;
    assert!(!found.is_empty(), "{}", path.display());
    let mut checked = 0;
    for p in samples(&rings) {
        let parity: Option<i64> = rings.iter().map(|ring| winding(&segments_of(ring), p)).sum();
        let (Some(parity), Some(depth)) = (parity, winding(&found, p)) else {
            continue;
        };
        checked += 1;
        assert_eq!(depth, parity.rem_euclid(2), "{}: {p:?}", path.display());
    }
    println!("{}: {checked} points", path.display());
}

#[test]
fn earcut_fixtures() {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(data("earcutr"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|suffix| suffix == "json"))
        .collect();
    assert_eq!(paths.len(), 30);
    // The large ones are beside the project, if at all; the rings of water-huge and water-huge2 cross themselves.
    let large = ["eberly-6", "water", "water2"];
    paths.extend(
        large
            .iter()
            .filter_map(|name| shared(&format!("fixtures/earcutr-0.5.0/{name}.json"))),
    );
    paths.iter().for_each(|path| check_fixture(path));
}

/// Islands that do not overlap: every point is in one of them, or in none.
#[test]
fn an_archipelago() {
    let source = SegmentSource::open_obstacles(&[data("indonesia/indonesia_ne10m.geojson")]).unwrap();
    let all = drain(source).unwrap();
    let lines = all.lines.iter().max().unwrap() + 1;
    assert_eq!(all.source.sources()[0].1, lines);
    let mut depths = [0; 2];
    for (n, segment) in all.ends.iter().enumerate().step_by(90) {
        // To the left of a segment, by a little, and to its right.
        let [x1, y1, x2, y2] = *segment;
        for side in [1e-7, -1e-7] {
            let p = Point::new(0.5 * (x1 + x2) - side * (y2 - y1), 0.5 * (y1 + y2) + side * (x2 - x1));
            let depth = winding(&all.ends, p).expect("it is beside the segment");
            assert_eq!(depth, i64::from(side > 0.0), "segment {n}");
            depths[depth as usize] += 1;
        }
    }
    assert!(depths.iter().all(|&points| points > 100), "{depths:?}");
}

/// Twice the area of closed segments with small whole coordinates.
fn double_area(segments: &[[f64; 4]]) -> i64 {
    let cross = segments.iter().map(|[x1, y1, x2, y2]| x1 * y2 - x2 * y1);
    cross.map(|cross| cross as i64).sum()
}

/// Whether closed segments lie on one line, or come as often in either direction.
fn is_flat(segments: &[[f64; 4]]) -> bool {
    let on_line = |[x1, y1, x2, y2]: &[f64; 4]| {
        let mut turns = segments
            .iter()
            .map(|[x, y, ..]| (x2 - x1) * (y - y1) - (y2 - y1) * (x - x1));
        turns.all(|turn| turn == 0.0)
    };
    let first = segments.iter().find(|[x1, y1, x2, y2]| [x1, y1] != [x2, y2]);
    let count = |wanted: &[f64; 4]| segments.iter().filter(|segment| *segment == wanted).count();
    first.is_none_or(on_line) || segments.iter().all(|s| count(s) == count(&[s[2], s[3], s[0], s[1]]))
}

fn undirected(segments: &[[f64; 4]]) -> Vec<[i64; 4]> {
    let mut all: Vec<[i64; 4]> = segments
        .iter()
        .map(|segment| segment.map(|value| value as i64))
        .map(|[a, b, c, d]| if [a, b] < [c, d] { [a, b, c, d] } else { [c, d, a, b] })
        .collect();
    all.sort_unstable();
    all
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    /// Any rings at all: their area counts as it should, and every segment of theirs is there.
    #[test]
    fn any_rings(rings in vec(vec((0..5, 0..5), 0..9), 1..4)) {
        let rings: Vec<Vec<[f64; 2]>> = rings
            .into_iter()
            .map(|ring| ring.into_iter().map(|(x, y)| [f64::from(x), f64::from(y)]).collect())
            .collect();
        let slices: Vec<&[[f64; 2]]> = rings.iter().map(Vec::as_slice).collect();
        let found = open(&[("any.json", polygon(&slices).as_bytes())], SegmentSource::open_obstacles).unwrap().ends;
        let has_area = !is_flat(&segments_of(&rings[0]));
        let (mut area, mut expected) = (0, Vec::new());
        for (n, ring) in rings.iter().enumerate() {
            let mut segments = segments_of(ring);
            segments.retain(|[x1, y1, x2, y2]| [x1, y1] != [x2, y2]);
            let of_ring = double_area(&segments).abs();
            if n == 0 && of_ring == 0 && has_area {
                // Its lobes cancel out: it comes as it is.
            } else if !has_area || of_ring == 0 {
                segments.extend(segments.clone());
            } else {
                area += if n == 0 { of_ring } else { -of_ring };
            }
            expected.extend(segments);
        }
        prop_assert_eq!(double_area(&found), area);
        prop_assert_eq!(undirected(&found), undirected(&expected));
        // As many segments come to a vertex as leave it.
        let mut ends: Vec<[[f64; 2]; 2]> = found.iter().map(|[a, b, c, d]| [[*a, *b], [*c, *d]]).collect();
        let mut sides = [0, 1].map(|side| ends.iter().map(|ends| ends[side]).collect::<Vec<_>>());
        sides.iter_mut().for_each(|side| side.sort_by(|a, b| a.partial_cmp(b).unwrap()));
        prop_assert_eq!(&sides[0], &sides[1]);
        // Where a polygon encloses nothing, every segment has one that goes back.
        if !has_area {
            ends.sort_by(|a, b| a.partial_cmp(b).unwrap());
            let mut back: Vec<[[f64; 2]; 2]> = ends.iter().map(|[a, b]| [*b, *a]).collect();
            back.sort_by(|a, b| a.partial_cmp(b).unwrap());
            prop_assert_eq!(ends, back);
        }
    }
}
