//! The directions of rings, compared with the inside that counting a ray's crossings gives.
//!
//! All randomness comes from fixed seeds.

use crate::input::obstacles::polygon;
use crate::input::segments::{drain, open};
use crate::input::{data, shared};
use delaunay_tiles::geometry::{Orientation, Point, orient2d};
use delaunay_tiles::input::SegmentSource;
use proptest::collection::vec;
use proptest::prelude::*;
use std::path::PathBuf;

/// Returns the winding number of segments around a point, counter-clockwise; `None` if the point is
/// on a segment.
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

/// Returns points near the vertices, where an error shows, and points all over.
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

/// Checks a polygon of earcutr: the segments wind around a point once if an odd number of rings
/// contains it, and else not at all. This holds for degenerate polygons too, as long as no ring
/// crosses itself.
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
fn segments_of_earcut_fixtures_wind_once_around_inner_points() {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(data("earcutr"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|suffix| suffix == "json"))
        .collect();
    assert_eq!(paths.len(), 30);
    // The large polygons are beside the project, if at all. The rings of water-huge and water-huge2
    // cross themselves.
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
fn segments_of_islands_have_the_inside_on_their_left() {
    let source = SegmentSource::open_obstacles(&[data("indonesia/indonesia_ne10m.geojson")]).unwrap();
    let all = drain(source).unwrap();
    let lines = all.lines.iter().max().unwrap() + 1;
    assert_eq!(all.source.sources()[0].1, lines);
    let mut depths = [0; 2];
    for (n, segment) in all.ends.iter().enumerate().step_by(90) {
        // A little to the left of a segment, and to its right.
        let [x1, y1, x2, y2] = *segment;
        for offset in [1e-7, -1e-7] {
            let p = Point::new(
                0.5 * (x1 + x2) - offset * (y2 - y1),
                0.5 * (y1 + y2) + offset * (x2 - x1),
            );
            let depth = winding(&all.ends, p).expect("it is beside the segment");
            assert_eq!(depth, i64::from(offset > 0.0), "segment {n}");
            depths[depth as usize] += 1;
        }
    }
    assert!(depths.iter().all(|&points| points > 100), "{depths:?}");
}

/// Returns twice the area of closed segments with small integer coordinates.
fn double_area(segments: &[[f64; 4]]) -> i64 {
    let cross = segments.iter().map(|[x1, y1, x2, y2]| x1 * y2 - x2 * y1);
    cross.map(|cross| cross as i64).sum()
}

/// Returns whether closed segments are collinear, or occur equally often in both directions.
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

    /// Any rings at all: the result has the right area, and has every segment of the rings.
    #[test]
    fn any_rings_keep_their_segments_and_area(rings in vec(vec((0..5, 0..5), 0..9), 1..4)) {
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
                // The lobes cancel out: the ring is returned unchanged.
            } else if !has_area || of_ring == 0 {
                segments.extend(segments.clone());
            } else {
                area += if n == 0 { of_ring } else { -of_ring };
            }
            expected.extend(segments);
        }
        prop_assert_eq!(double_area(&found), area);
        prop_assert_eq!(undirected(&found), undirected(&expected));
        // Equal numbers of segments enter and leave each vertex.
        let mut ends: Vec<[[f64; 2]; 2]> = found.iter().map(|[a, b, c, d]| [[*a, *b], [*c, *d]]).collect();
        let mut vertices = [0, 1].map(|end| ends.iter().map(|ends| ends[end]).collect::<Vec<_>>());
        vertices.iter_mut().for_each(|ends| ends.sort_by(|a, b| a.partial_cmp(b).unwrap()));
        prop_assert_eq!(&vertices[0], &vertices[1]);
        // If a polygon encloses nothing, every segment has a reverse.
        if !has_area {
            ends.sort_by(|a, b| a.partial_cmp(b).unwrap());
            let mut back: Vec<[[f64; 2]; 2]> = ends.iter().map(|[a, b]| [*b, *a]).collect();
            back.sort_by(|a, b| a.partial_cmp(b).unwrap());
            prop_assert_eq!(ends, back);
        }
    }
}
