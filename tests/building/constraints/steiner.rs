//! Segments that are split at the borders of cells: where they are split, and that nothing else
//! changes.

use delaunay_tiles::geometry::{Point, segments_cross};
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::store::{Digest, EdgeSource, LineBatch, LineKind};
use delaunay_tiles::{BuildError, BuildOptions, BuildSummary, Builder, LinesToSplit, Steiner};

use super::{ENOUGH, Segment};
use crate::support::{Random, Scratch, batches, runtime, verify_lines};

/// Little enough memory for 60,000 points to go to disk.
const LITTLE: u64 = 3 << 19;

/// Returns nested polygons, and lines that end on their edges, across all cells.
fn town() -> (Vec<Point>, Vec<LabelledSegment>) {
    let p = Point::new;
    let mut random = Random(4);
    let points = (0..60_000)
        .map(|_| p(100.0 * random.unit(), 100.0 * random.unit()))
        .collect();
    let mut lines = Vec::new();
    for (line, r) in [(0, 45.0), (1, 44.5), (2, 20.25)] {
        let mut corners = [
            p(50.0, 50.0 - r),
            p(50.0 + r, 50.0),
            p(50.0, 50.0 + r),
            p(50.0 - r, 50.0),
        ];
        if line == 1 {
            corners.reverse();
        }
        lines.extend((0..4).map(|i| (LineKind::Obstacle, line, [corners[i], corners[(i + 1) % 4]])));
    }
    // From the outermost edge to the corner, exactly on it, and another segment on this line.
    lines.push((LineKind::Wall, 3, [p(72.5, 27.5), p(99.0, 1.0)]));
    lines.push((LineKind::BreakLine, 4, [p(90.0, 10.0), p(99.75, 60.0)]));
    (points, lines)
}

type LabelledSegment = (LineKind, u64, Segment);

async fn try_build(
    scratch: &Scratch,
    points: &[Point],
    lines: &[LabelledSegment],
    steiner: Steiner,
    (tile_vertices, threads, memory): (usize, usize, u64),
) -> Result<BuildSummary, BuildError> {
    let options = BuildOptions::default()
        .tile_vertices(tile_vertices)
        .threads(threads)
        .memory(memory)
        .steiner(steiner);
    let mut builder = Builder::new(&scratch.path, options)?;
    for &(kind, line, ends) in lines {
        let batch = SegmentBatch {
            ends: vec![ends],
            lines: vec![0],
            // Ring 1 is a hole in the polygon of ring 0.
            polygons: vec![line.max(1)],
            ..SegmentBatch::default()
        };
        builder.push_lines(kind, line, &batch)?;
    }
    for batch in batches(points, &[]) {
        builder.push(&batch).await?;
    }
    builder.finish().await
}

async fn build(
    points: &[Point],
    lines: &[LabelledSegment],
    steiner: Steiner,
    way: (usize, usize, u64),
) -> (Scratch, BuildSummary, Digest) {
    let scratch = Scratch::new();
    let summary = try_build(&scratch, points, lines, steiner, way).await.unwrap();
    let reader = scratch.open().await;
    reader.verify(true).await.unwrap();
    let digest = reader.recompute_digest().await.unwrap();
    (scratch, summary, digest)
}

#[test]
fn lines_are_split_at_borders_and_nothing_else_changes() {
    let (points, lines) = town();
    // The direction of a ring says which side is its inside, so rings keep theirs.
    let turned = lines.iter().rev().map(|&(kind, line, [a, b])| match kind {
        LineKind::Obstacle => (kind, line, [a, b]),
        _ => (kind, line, [b, a]),
    });
    let turned: Vec<_> = turned.collect();
    runtime().block_on(async {
        let (_, plain, plain_digest) = build(&points, &lines, Steiner::Never, (500, 2, LITTLE)).await;
        assert!(plain.blocks > 1 && plain.split_points == 0);
        // Points that fit in memory are in one cell.
        let (_, whole, digest) = build(&points, &lines, Steiner::Borders, (500, 2, ENOUGH)).await;
        assert_eq!((digest, whole.split_points), (plain_digest, 0));
        let (scratch, summary, digest) = build(&points, &lines, Steiner::Borders, (500, 2, LITTLE)).await;
        assert!(summary.split_points > 10, "{}", summary.split_points);
        assert_eq!(summary.vertices, plain.vertices + summary.split_points);
        assert!(summary.constraint_edges > plain.constraint_edges);
        // The rings enclose the same regions, and the lines still end on them.
        assert_eq!(
            (summary.regions, summary.hole_regions),
            (plain.regions, plain.hole_regions)
        );
        let (_, _, other) = build(&points, &turned, Steiner::Borders, (500, 2, LITTLE)).await;
        assert_eq!(other, digest);

        // The file stores where lines are split: the subsegments cross no border, and are those of
        // the file.
        let reader = scratch.open().await;
        let borders = reader.lists().await.unwrap().cell_borders.clone();
        let all = LineBatch {
            ends: lines.iter().map(|line| line.2).collect(),
            sources: lines
                .iter()
                .map(|&(kind, line, _)| EdgeSource::new(kind, line).into())
                .collect(),
        };
        let crossed = |ends: &Segment| {
            borders
                .iter()
                .filter(|[c, d]| segments_cross(ends[0], ends[1], *c, *d))
                .count()
        };
        assert!(all.ends.iter().map(crossed).sum::<usize>() >= summary.split_points as usize);
        let mut again = LinesToSplit::new(ENOUGH).at_borders(&borders);
        let polygons: Vec<u64> = lines.iter().map(|line| line.1.max(1)).collect();
        again.push(&all, &[], &polygons).unwrap();
        let split = again
            .split(|_, take| {
                take(&points);
                Ok::<_, BuildError>(())
            })
            .unwrap();
        let mut subsegments = Vec::new();
        for batch in split.subsegments() {
            assert!(batch.ends.iter().all(|ends| crossed(ends) == 0));
            subsegments.extend(batch.ends.into_iter().zip(batch.sources));
        }
        verify_lines(&reader, subsegments).await.unwrap();
        assert!(
            verify_lines(&reader, all.ends.into_iter().zip(all.sources).collect())
                .await
                .is_err()
        );
    });
}

#[test]
fn crossings_are_reported_alike_with_and_without_splits_at_borders() {
    let (points, mut lines) = town();
    let ends = [Point::new(1.0, 3.0), Point::new(99.0, 97.0)];
    lines.push((LineKind::Wall, 5, ends));
    runtime().block_on(async {
        let mut reported = Vec::new();
        for steiner in [Steiner::Never, Steiner::Borders] {
            let way = (500, 2, LITTLE);
            let error = try_build(&Scratch::new(), &points, &lines, steiner, way).await;
            let Err(BuildError::Crossings { first, count }) = error else {
                panic!("{error:?}")
            };
            assert!(first.iter().all(|crossing| crossing.lines[1].number() == 5));
            reported.push((first, count));
        }
        assert_eq!(reported[0], reported[1]);
    });
}
