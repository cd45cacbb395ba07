//! Segments that cross: the report and the split depend only on the set of segments.

use delaunay_tiles::geometry::{Point, crossing_point};
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::store::{Digest, LineKind};
use delaunay_tiles::{
    BuildError, BuildOptions, BuildSummary, Builder, Crossing, Crossings, MemoryShortage, MemoryUse, MissingZ,
};
use distributions::Kind;
use futures::TryStreamExt;

use super::{ENOUGH, Segment, Way};
use crate::support::{Random, Scratch, batches, points_of, runtime};

const WAYS: [Way; 4] = [
    (8, 16, 1, ENOUGH),
    (20, 1 << 16, 2, ENOUGH),
    (300, 1 << 16, 3, ENOUGH),
    (1 << 16, 1 << 16, 1, ENOUGH),
];

/// Returns segments of random length and direction; each is a line of its own.
fn segments(count: usize, length: f64, seed: u64) -> Vec<Segment> {
    let mut random = Random(seed);
    let mut point = || Point::new(random.unit(), random.unit());
    let segment = |_| {
        let (a, along) = (point(), point());
        [
            a,
            Point::new(a.x + length * (along.x - 0.5), a.y + length * (along.y - 0.5)),
        ]
    };
    (0..count).map(segment).collect()
}

/// Builds from numbered lines, in the given order. Returns the summary and the file's digest.
async fn build(
    points: &[Point],
    lines: &[(u64, Segment)],
    crossings: Crossings,
    (tile_vertices, merge_vertices, threads, memory): Way,
) -> Result<(BuildSummary, Digest), BuildError> {
    let scratch = Scratch::new();
    let options = BuildOptions::default()
        .tile_vertices(tile_vertices)
        .merge_vertices(merge_vertices)
        .threads(threads)
        .memory(memory)
        .crossings(crossings);
    let mut builder = Builder::new(&scratch.path, options)?;
    let batch = SegmentBatch {
        ends: lines.iter().map(|(_, ends)| *ends).collect(),
        lines: lines.iter().map(|(line, _)| *line).collect(),
        ..SegmentBatch::default()
    };
    builder.push_lines(LineKind::Wall, 0, &batch)?;
    for batch in batches(points, &[]) {
        builder.push(&batch).await?;
    }
    let summary = builder.finish().await?;
    let reader = scratch.open().await;
    if let Err(error) = reader.verify(true).await {
        panic!("tiles of {tile_vertices}: {error}");
    }
    Ok((summary, reader.recompute_digest().await.unwrap()))
}

/// Returns the lines in another order, each with its ends swapped.
fn turned(lines: &[(u64, Segment)]) -> Vec<(u64, Segment)> {
    let mut turned: Vec<_> = lines.iter().map(|&(line, [a, b])| (line, [b, a])).collect();
    Random(9).shuffle(&mut turned);
    turned
}

fn numbered(segments: Vec<Segment>) -> Vec<(u64, Segment)> {
    (0..).zip(segments).collect()
}

#[test]
fn an_error_for_crossings_reports_the_first_ten_and_their_number() {
    let points = points_of(Kind::Uniform, 2000, 4);
    for (count, length, seed) in [(400, 0.02, 1), (300, 0.2, 2), (60, 2.0, 3)] {
        let lines = numbered(segments(count, length, seed));
        let mut expected: Vec<(u64, u64, Point)> = Vec::new();
        for (i, &(_, [a, b])) in lines.iter().enumerate() {
            for (j, &(_, [c, d])) in lines.iter().enumerate().skip(i + 1) {
                expected.extend(crossing_point(a, b, c, d).map(|point| (i as u64, j as u64, point)));
            }
        }
        assert!(!expected.is_empty());
        let reported = |crossing: &Crossing| {
            let [one, other] = crossing.lines.map(|line| line.number());
            (one, other, crossing.point)
        };
        runtime().block_on(async {
            for way in WAYS {
                for lines in [&lines, &turned(&lines)] {
                    let built = build(&points, lines, Crossings::Error, way).await;
                    let Err(BuildError::Crossings { first, count }) = built else {
                        panic!("{built:?}");
                    };
                    assert_eq!(count, expected.len() as u64);
                    let first: Vec<_> = first.iter().map(reported).collect();
                    assert_eq!(first, expected[..expected.len().min(10)]);
                }
            }
        });
    }
}

#[test]
fn crossing_lines_are_split_alike_in_any_tiles_order_and_direction() {
    let points = points_of(Kind::Uniform, 1000, 4);
    for (count, length, seed) in [(400, 0.02, 1), (200, 0.3, 2), (40, 2.0, 3)] {
        let lines = numbered(segments(count, length, seed));
        let crossing = |(i, &(_, [a, b])): (usize, &(u64, Segment))| {
            let others = lines[i + 1..].iter();
            others
                .filter(|&&(_, [c, d])| crossing_point(a, b, c, d).is_some())
                .count() as u64
        };
        let expected: u64 = lines.iter().enumerate().map(crossing).sum();
        runtime().block_on(async {
            let mut digests = Vec::new();
            for way in WAYS {
                for lines in [&lines, &turned(&lines)] {
                    let (summary, digest) = build(&points, lines, Crossings::Split, way).await.unwrap();
                    assert!(summary.crossings >= expected);
                    assert!(summary.constraint_edges >= count as u64 + 2 * expected);
                    digests.push(digest);
                }
            }
            assert!(digests.windows(2).all(|pair| pair[0] == pair[1]));
        });
    }
}

/// Lines of a kind: their kind, the number of the first, their ends, and the z of their ends or
/// none.
type LineSet<'a> = (LineKind, u64, &'a [Segment], &'a [[f64; 2]]);

/// Builds from lines of several kinds, whose batches have z or none. Returns all vertices with
/// their z.
async fn heights(sets: &[LineSet<'_>], tile_vertices: usize) -> Vec<(Point, Option<f64>)> {
    let scratch = Scratch::new();
    let options = BuildOptions::default()
        .tile_vertices(tile_vertices)
        .crossings(Crossings::Split)
        .missing_z(MissingZ::Zero);
    let mut builder = Builder::new(&scratch.path, options).unwrap();
    for &(kind, first, ends, z) in sets {
        let batch = SegmentBatch {
            ends: ends.to_vec(),
            z: z.to_vec(),
            lines: (0..ends.len() as u64).collect(),
            ..SegmentBatch::default()
        };
        builder.push_lines(kind, first, &batch).unwrap();
    }
    builder.finish().await.unwrap();
    let mut heights = Vec::new();
    for tile in scratch.open().await.tiles().try_collect::<Vec<_>>().await.unwrap() {
        heights.extend(tile.vertex_indices().map(|vertex| (tile.point(vertex), tile.z(vertex))));
    }
    heights.sort_by(|(a, _), (b, _)| a.lex_cmp(*b));
    heights
}

#[test]
fn crossing_points_have_the_z_of_the_first_line_with_z() {
    let line = |[a, b]: [[f64; 2]; 2]| [Point::new(a[0], a[1]), Point::new(b[0], b[1])];
    let flat = [[[0.0, 1.0], [8.0, 1.0]]].map(line);
    let upright = [[[1.0, 0.0], [1.0, 4.0]], [[6.0, 0.0], [6.0, 4.0]]].map(line);
    let (slope, walls) = ([[20.0, 28.0]], [[4.0, 8.0], [0.0, 40.0]]);
    let turned = |ends: &[Segment]| ends.iter().map(|&[a, b]| [b, a]).collect::<Vec<_>>();
    let swapped = |z: &[[f64; 2]]| z.iter().map(|&[a, b]| [b, a]).collect::<Vec<_>>();
    let at = |heights: &[(Point, Option<f64>)], x| {
        let found = heights.iter().find(|(point, _)| *point == Point::new(x, 1.0));
        found.expect("a vertex where lines cross").1
    };
    runtime().block_on(async {
        for tile_vertices in [4, 1 << 16] {
            for (first, second, flat_has_z, expected) in [
                (LineKind::BreakLine, LineKind::Wall, true, [21.0, 26.0]),
                (LineKind::BreakLine, LineKind::Wall, false, [5.0, 10.0]),
            ] {
                let z = if flat_has_z { &slope[..] } else { &[] };
                let sets = [(first, 0, &flat[..], z), (second, 1, &upright[..], &walls[..])];
                let once = heights(&sets, tile_vertices).await;
                assert_eq!([at(&once, 1.0), at(&once, 6.0)], expected.map(Some));
                let (flat, upright) = (turned(&flat), turned(&upright));
                let (z, walls) = (swapped(z), swapped(&walls));
                let sets = [(second, 1, &*upright, &*walls), (first, 0, &*flat, &*z)];
                assert_eq!(heights(&sets, tile_vertices).await, once);
            }
            let sets: [(_, _, &[Segment], &[_]); 2] =
                [(LineKind::Wall, 0, &flat, &[]), (LineKind::Wall, 1, &upright, &[])];
            let none = heights(&sets, tile_vertices);
            assert!(none.await.iter().all(|(_, z)| z.is_none()));
        }
    });
}

/// A line that is bent at a crossing still passes through the points and sites on it, in memory and
/// on disk.
#[test]
fn points_on_a_line_stay_on_it_when_it_is_bent_at_a_crossing() {
    let p = Point::new;
    let lines = numbered(vec![
        [p(0.0, 0.0), p(9.0, 3.0)],
        [p(5.0, -1.0), p(4.0, 3.0)],
        [p(0.0, 10.0), p(1.0, 10.0)],
    ]);
    let mut random = Random(4);
    // None of these points is on the lines.
    let mut points: Vec<Point> = (0..60_000).map(|_| p(random.unit() + 20.0, random.unit())).collect();
    points.splice(30_000..30_000, [p(6.0, 2.0), p(3.0, 1.0)]);
    runtime().block_on(async {
        let mut digests = Vec::new();
        for way in [
            (500, 1 << 16, 2, ENOUGH),
            (500, 1 << 16, 2, 3 << 19),
            (1 << 16, 1 << 16, 1, ENOUGH),
        ] {
            for lines in [&lines, &turned(&lines)] {
                let (summary, digest) = build(&points, lines, Crossings::Split, way).await.unwrap();
                assert_eq!((summary.crossings, summary.constraint_edges), (1, 4 + 2 + 1));
                assert_eq!(summary.blocks > 1, way.3 < ENOUGH);
                digests.push(digest);
            }
        }
        assert!(digests.windows(2).all(|pair| pair[0] == pair[1]));
    });
}

#[test]
fn splitting_with_too_little_memory_returns_a_memory_error() {
    let lines = numbered(segments(60_000, 0.001, 1));
    let way = (500, 1 << 16, 1, 8 << 20);
    let built = runtime().block_on(build(&[], &lines, Crossings::Split, way));
    assert!(
        matches!(
            built,
            Err(BuildError::Memory(MemoryShortage {
                of: MemoryUse::Split,
                ..
            }))
        ),
        "{built:?}"
    );
}
