//! Lines that overlap: any number of them may share edges, and the time is proportional to what the
//! edges store.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::store::{EdgeSource, LineKind};
use delaunay_tiles::{BuildError, BuildOptions, BuildSummary, Builder, MemoryShortage, MemoryUse};
use distributions::Kind;

use super::{ENOUGH, Input, Segment, check, ways};
use crate::support::{Random, Scratch, batches, points_of, runtime, verify_lines};

/// Returns the point at position `at` on one of three lines through the centre of the unit square.
fn on(line: usize, at: f64) -> Point {
    let direction = [(1.0, 0.25), (0.0, 1.0), (2.0, -1.0)][line];
    Point::new(0.5 + at * direction.0 / 1024.0, 0.5 + at * direction.1 / 1024.0)
}

/// Returns segments on three lines that cross in one vertex.
fn segments(count: usize, length: usize, seed: u64) -> Vec<Segment> {
    let mut random = Random(seed);
    let segment = |number: usize| {
        let from = random.below(800) as f64 - 400.0;
        let to = from + random.below(2 * length + 1) as f64 - length as f64;
        [from, to].map(|at| on(number % 3, at))
    };
    (0..count).map(segment).collect()
}

/// Builds with segments that all belong to one line.
async fn build_line(
    scratch: &Scratch,
    kind: LineKind,
    points: &[Point],
    ends: &[Segment],
    (tile_vertices, memory): (usize, u64),
) -> Result<BuildSummary, BuildError> {
    let options = BuildOptions::default()
        .tile_vertices(tile_vertices)
        .memory(memory)
        .threads(2);
    let mut builder = Builder::new(&scratch.path, options)?;
    let batch = SegmentBatch {
        ends: ends.to_vec(),
        lines: vec![0; ends.len()],
        ..SegmentBatch::default()
    };
    builder.push_lines(kind, 0, &batch)?;
    for batch in batches(points, &[]) {
        builder.push(&batch).await?;
    }
    builder.finish().await
}

#[test]
fn edges_store_all_lines_that_run_along_them() {
    let origin = on(0, 0.0);
    for (points, count, length) in [(300, 600, 400), (2000, 150, 1000), (0, 300, 300)] {
        let mut points = points_of(Kind::Uniform, points, 3);
        points.push(origin);
        let segments = segments(count, length, 5);
        check(
            Input {
                name: "overlaps",
                points,
                segments,
            },
            ways(),
        );
    }
}

/// A line that runs back and forth over itself. Walking each of its subsegments separately would
/// take some ten million steps.
#[test]
fn a_line_that_overlaps_itself_is_walked_once() {
    let mut random = Random(7);
    let mut line = |kind: LineKind| -> (Vec<Segment>, LineKind) {
        let mut corners: Vec<Point> = (0..6000)
            .map(|_| on(0, random.below(1 << 13) as f64 / 16.0 - 256.0))
            .collect();
        corners.push(corners[0]);
        (corners.windows(2).map(|pair| [pair[0], pair[1]]).collect(), kind)
    };
    let lines = [line(LineKind::BreakLine), line(LineKind::Wall)];
    for (points, tile_vertices) in [(2000, 1 << 16), (2000, 1000), (0, 1000)] {
        let points = points_of(Kind::Uniform, points, 3);
        for (segments, kind) in &lines {
            runtime().block_on(async {
                let scratch = Scratch::new();
                let built = build_line(&scratch, *kind, &points, segments, (tile_vertices, ENOUGH));
                let summary = built.await.unwrap();
                let along = segments.as_flattened();
                let mut along: Vec<Point> = along.to_vec();
                along.sort_by(|a, b| a.lex_cmp(*b));
                along.dedup();
                assert_eq!(summary.constraint_edges, along.len() as u64 - 1);
                let reader = scratch.open().await;
                let report = reader.verify(true).await.unwrap();
                assert_eq!(report.constraint_edges, summary.constraint_edges);
                let source = EdgeSource::new(*kind, 0);
                let lines = segments.iter().map(|&ends| (ends, source)).collect();
                verify_lines(&reader, lines).await.unwrap();
            });
        }
    }
}

#[test]
fn overlaps_that_exceed_the_memory_return_a_memory_error() {
    for points in [0, 1000] {
        let points = points_of(Kind::Uniform, points, 3);
        // Each segment is within the one before it, so edges store 2.25 million references to
        // lines.
        let nested = (0..1500).map(|i| [f64::from(i) - 1600.0, 1600.0 - f64::from(i)]);
        let segments: Vec<Segment> = nested.map(|ends| ends.map(|at| on(0, at))).collect();
        let input = Input {
            name: "nested",
            points,
            segments,
        };
        runtime().block_on(async {
            for (memory, is_enough) in [(64 << 20, false), (2 << 30, true)] {
                let scratch = Scratch::new();
                let options = BuildOptions::default().memory(memory).threads(1).tile_vertices(1 << 12);
                match input.build(&scratch, options).await {
                    Ok(summary) => assert!(is_enough && summary.constraint_edges >= 2999),
                    Err(BuildError::Memory(MemoryShortage {
                        of: MemoryUse::Overlaps { .. },
                        needed,
                        budget,
                    })) => {
                        assert!(!is_enough && budget < memory && needed > budget);
                    }
                    Err(error) => panic!("{error}"),
                }
            }
        });
    }
}
