//! Stars: many lines that share a vertex. They are deferred when memory is short, or added to a
//! file later.
//!
//! A build of 230 lines in a star once ended with "no triangle around a vertex is on the way of a
//! line", and one of 100,000 with "a line between two vertices leaves the triangulation". The hub
//! was on the cut between two tiles. The neighbouring tile treated each line as one that passes
//! through, since the line touched its cell, and handed it up to the root. The line itself was
//! within the tile of its ends, where it was deferred. So at the root nothing was in the line's
//! way, and the root kept triangles there that went to no tile.

use std::fs;

use super::*;

/// Reads a case of `tests/data/star`: segments between points, by index.
fn case(name: &'static str) -> Input {
    let bytes = |kind: &str| fs::read(data(&format!("star/{name}.{kind}"))).unwrap();
    let coordinates = bytes("f64");
    let coordinates = coordinates.as_chunks().0.iter().map(|&bytes| f64::from_le_bytes(bytes));
    let coordinates: Vec<f64> = coordinates.collect();
    let points = coordinates
        .as_chunks()
        .0
        .iter()
        .map(|&[x, y]| Point::new(x, y))
        .collect();
    let numbers: Vec<u32> = bytes("u32")
        .as_chunks()
        .0
        .iter()
        .map(|&b| u32::from_le_bytes(b))
        .collect();
    Input::between(name, points, numbers.as_chunks().0.iter().copied())
}

/// Returns a star around `hub`, whose lines end at different distances. Some vertices on the lines
/// are points, others are ends of other lines.
fn star(hub: (f64, f64), degree: u32, from: f64, to: f64) -> (Vec<Point>, Vec<Segment>) {
    let mut random = Random(7);
    let (mut points, mut segments) = (Vec::new(), Vec::new());
    let hub_point = Point::new(hub.0, hub.1);
    for spoke in 0..degree {
        let angle = from + (to - from) * f64::from(spoke) / f64::from(degree);
        let radius = 500.0 + random.below(300) as f64;
        let step = [(radius * angle.cos()).round(), (radius * angle.sin()).round()];
        let at = |steps: f64| Point::new(hub.0 + steps * step[0], hub.1 + steps * step[1]);
        match spoke % 5 {
            0 => segments.push([hub_point, at(1.0)]),
            1 => points.push(at(1.0)),
            _ => {}
        }
        segments.push(if spoke % 2 == 0 {
            [hub_point, at(2.0)]
        } else {
            [at(2.0), hub_point]
        });
    }
    (points, segments)
}

const LITTLE: [Way; 4] = [
    (128, 1 << 16, 1, 2 << 20),
    (128, 1 << 16, 2, 1 << 20),
    (30, 1 << 16, 2, 1 << 20),
    (16, 64, 1, 2 << 20),
];

#[test]
fn deferred_lines_that_share_a_vertex_on_a_cut_equal_the_in_core_triangulation() {
    for name in ["star230", "star600"] {
        assert!(check(case(name), &LITTLE) > 0, "none was deferred");
    }
}

#[test]
fn two_stars_with_vertices_on_their_lines_equal_the_in_core_triangulation() {
    let (mut points, mut segments) = star((-4000.0, 0.0), 300, 0.0, TAU);
    let (more, others) = star((4000.0, 9.0), 200, 0.0, TAU);
    points.extend(more);
    segments.extend(others);
    segments.push([Point::new(-4000.0, 0.0), Point::new(4000.0, 9.0)]);
    points.extend(
        [-7000.0, 7000.0]
            .map(|x| [Point::new(x, -3000.0), Point::new(x, 3000.0)])
            .as_flattened(),
    );
    let input = Input {
        name: "two stars",
        points,
        segments,
    };
    assert!(check(input, &LITTLE) > 0, "none was deferred");
}

#[test]
fn a_fan_of_lines_from_a_hull_corner_equals_the_in_core_triangulation() {
    let (points, segments) = star((0.0, 0.0), 400, 0.0, TAU / 4.0);
    let input = Input {
        name: "fan",
        points,
        segments,
    };
    assert!(check(input, &LITTLE) > 0, "none was deferred");
}

#[test]
fn an_edit_does_not_walk_the_whole_star_of_a_hub_for_each_line() {
    let degree = 4000;
    let (points, segments) = star((0.0, 0.0), degree, 0.0, TAU);
    let ends = segments.as_flattened().iter().copied();
    let start = Input {
        name: "star",
        points: points.into_iter().chain(ends).collect(),
        segments: Vec::new(),
    };
    runtime().block_on(async {
        let scratch = Scratch::new();
        let options = BuildOptions::default().tile_vertices(1000);
        let tiles = start.build(&scratch, options).await.unwrap().tiles;
        let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(64 << 20))
            .await
            .unwrap()
            .begin()
            .await
            .unwrap();
        let batch = SegmentBatch {
            lines: (0..).take(segments.len()).collect(),
            ends: segments,
            ..SegmentBatch::default()
        };
        transaction.constrain(LineKind::BreakLine, 0, &batch).unwrap();
        let summary = transaction.commit().await.unwrap();
        // Walking half of the hub's triangles for each line would take 2,000. All tiles fit in
        // memory, so each is read once.
        assert!(
            summary.triangles_visited < 100 * summary.segments,
            "{} triangles for {} lines",
            summary.triangles_visited,
            summary.segments
        );
        assert_eq!(summary.tile_reads, tiles);
        scratch.open().await.verify(true).await.unwrap();
    });
}
