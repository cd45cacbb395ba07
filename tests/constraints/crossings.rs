//! Segments that cross: the report and the split are those of the set of segments.

use delaunay_tiles::build::{BuildError, BuildOptions, BuildSummary, Builder, Crossing, Crossings};
use delaunay_tiles::geometry::{Point, crossing_point};
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::store::{Digest, LineKind};
use distributions::Kind;

use super::support::{Random, Scratch, batches, points_of, runtime};
use super::{ENOUGH, Segment, Way};

const WAYS: [Way; 4] = [
    (8, 16, 1, ENOUGH),
    (20, 1 << 16, 2, ENOUGH),
    (300, 1 << 16, 3, ENOUGH),
    (1 << 16, 1 << 16, 1, ENOUGH),
];

/// Segments of random length and direction; each is a line.
fn segments(count: usize, length: f64, seed: u64) -> Vec<Segment> {
    let mut random = Random(seed);
    let mut place = || Point::new(random.unit(), random.unit());
    let segment = |_| {
        let (a, along) = (place(), place());
        [
            a,
            Point::new(a.x + length * (along.x - 0.5), a.y + length * (along.y - 0.5)),
        ]
    };
    (0..count).map(segment).collect()
}

/// Builds from numbered lines, in some order, and the file's digest.
async fn build(
    points: &[Point],
    lines: &[(u64, Segment)],
    crossings: Crossings,
    (tile_vertices, merge_vertices, threads, memory): Way,
) -> Result<(BuildSummary, Digest), BuildError> {
    let scratch = Scratch::new();
    let options = BuildOptions {
        tile_vertices,
        merge_vertices,
        threads,
        memory,
        crossings,
        ..BuildOptions::default()
    };
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
    Ok((summary, reader.digest().await.unwrap()))
}

/// The lines in another order and direction.
fn turned(lines: &[(u64, Segment)]) -> Vec<(u64, Segment)> {
    let mut turned: Vec<_> = lines.iter().map(|&(line, [a, b])| (line, [b, a])).collect();
    Random(9).shuffle(&mut turned);
    turned
}

fn numbered(segments: Vec<Segment>) -> Vec<(u64, Segment)> {
    (0..).zip(segments).collect()
}

#[test]
fn the_first_ten_are_told() {
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
        let told = |crossing: &Crossing| {
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
                    let first: Vec<_> = first.iter().map(told).collect();
                    assert_eq!(first, expected[..expected.len().min(10)]);
                }
            }
        });
    }
}

#[test]
fn what_crosses_is_split_alike() {
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

#[test]
fn splitting_takes_memory() {
    let lines = numbered(segments(60_000, 0.001, 1));
    let way = (500, 1 << 16, 1, 8 << 20);
    let built = runtime().block_on(build(&[], &lines, Crossings::Split, way));
    assert!(matches!(built, Err(BuildError::SplitMemory { .. })), "{built:?}");
}
