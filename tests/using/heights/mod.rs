//! The promise: every tile has the z of all corners of its triangles, those that other tiles own
//! too. The z of a point does not depend on tiles, threads, memory, lines, interruptions and edits.

use std::sync::Arc;
use std::time::Duration;

use crate::support::{Random, Scratch, batches, build_batches, points_of, runtime};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{SegmentBatch, SiteBatch, SiteId};
use delaunay_tiles::query::Location;
use delaunay_tiles::store::{LineKind, OpenOptions, TileReader};
use delaunay_tiles::{BuildError, BuildOptions, BuildSummary, Builder, EditOptions, Editor, Phase};
use distributions::{Kind, LongSegments};
use futures::TryStreamExt;

const ENOUGH: u64 = 1 << 30;

/// The z of any point of the terrain.
fn height(p: Point) -> f64 {
    3.0 * p.x - p.y * p.y + 0.1
}

fn heights(points: &[Point]) -> Vec<f64> {
    points.iter().map(|&p| height(p)).collect()
}

fn options(tile_vertices: usize, threads: usize, memory: u64) -> BuildOptions {
    BuildOptions::default()
        .tile_vertices(tile_vertices)
        .threads(threads)
        .memory(memory)
}

/// Verifies a file, and checks the z of each corner of each tile. Returns the number of corners
/// that other tiles own.
async fn check(reader: &TileReader, way: &str) -> usize {
    if let Err(error) = reader.verify(true).await {
        panic!("{way}: {error}");
    }
    assert!(reader.metadata().has_z, "{way}");
    let mut of_others = 0;
    let tiles: Vec<_> = reader.tiles().try_collect().await.unwrap();
    for tile in tiles {
        let of_triangles = tile.triangle_ids().flat_map(|triangle| tile.corners(triangle));
        for corner in tile.vertex_indices().chain(of_triangles) {
            let (z, p) = (tile.z(corner).expect("the file has z"), tile.point(corner));
            assert_eq!(z.to_bits(), height(p).to_bits(), "{way}: {p:?}");
            of_others += usize::from(!tile.has_vertex(corner));
        }
    }
    of_others
}

/// A line of its own for each segment. Its ends have z.
fn lines(ends: Vec<[Point; 2]>) -> SegmentBatch {
    SegmentBatch {
        z: ends.iter().map(|ends| ends.map(height)).collect(),
        lines: (0..ends.len() as u64).collect(),
        ends,
        ..SegmentBatch::default()
    }
}

async fn build(
    scratch: &Scratch,
    points: &[Point],
    lines: &SegmentBatch,
    options: BuildOptions,
) -> Result<BuildSummary, BuildError> {
    let mut builder = Builder::new(&scratch.path, options)?;
    builder.push_lines(LineKind::BreakLine, 0, lines)?;
    // A site at a place of its own.
    let site = Point::new(0.375, 0.4375);
    builder.push_sites(&SiteBatch {
        points: vec![site],
        z: vec![height(site)],
        ids: vec![SiteId::Number(7)],
    })?;
    for batch in batches(points, &heights(points)) {
        builder.push(&batch).await?;
    }
    builder.finish().await
}

#[test]
fn all_tiles_have_the_z_of_all_corners_whatever_their_size_the_threads_and_the_memory() {
    runtime().block_on(async {
        for kind in [Kind::Uniform, Kind::Kuzmin, Kind::Grid, Kind::Line] {
            let points = points_of(kind, 20_000, 3);
            let mut digests = Vec::new();
            for (tile_vertices, threads, memory) in [(8, 1, ENOUGH), (100, 3, ENOUGH), (100, 2, 600_000)] {
                let way = format!("{kind}: tiles of {tile_vertices}, {threads} threads, {memory}");
                let scratch = Scratch::new();
                let options = options(tile_vertices, threads, memory);
                let built = build_batches(&scratch.path, &batches(&points, &heights(&points)), options).await;
                match built {
                    // All collinear points are in all seams.
                    Err(BuildError::Memory(_)) if kind == Kind::Line && memory < ENOUGH => continue,
                    built => _ = built.unwrap(),
                }
                let reader = scratch.open().await;
                let of_others = check(&reader, &way).await;
                assert!(of_others > 1000 || kind == Kind::Line, "{way}: {of_others}");
                digests.push(reader.recompute_digest().await.unwrap());
            }
            assert!(digests.iter().all(|digest| *digest == digests[0]), "{kind}");
        }
    });
}

#[test]
fn all_tiles_have_the_z_of_all_corners_in_files_with_lines() {
    let long = LongSegments::new(2000, 40, 3).unwrap();
    let points: Vec<Point> = long.points().map(|[x, y]| Point::new(x, y)).collect();
    let ends = long.segments().map(|ends| ends.map(|end| points[end as usize]));
    let lines = lines(ends.collect());
    runtime().block_on(async {
        let mut deferred = 0;
        // With the least memory, lines are inserted after the build.
        for (tile_vertices, threads, memory) in [(8, 1, ENOUGH), (50, 2, 1 << 20), (1000, 2, ENOUGH)] {
            let scratch = Scratch::new();
            let options = options(tile_vertices, threads, memory);
            deferred += build(&scratch, &points, &lines, options)
                .await
                .unwrap()
                .deferred_segments;
            let way = format!("tiles of {tile_vertices}");
            assert!(check(&scratch.open().await, &way).await > 100, "{way}");
        }
        assert!(deferred > 0, "nothing was deferred");
    });
}

#[test]
fn collinear_points_with_lines_have_the_z_of_the_next_tile() {
    let points: Vec<Point> = (0..40).map(|i| Point::new(f64::from(i), f64::from(3 * i))).collect();
    runtime().block_on(async {
        let scratch = Scratch::new();
        let mut builder = Builder::new(&scratch.path, options(8, 2, ENOUGH)).unwrap();
        let along = lines(vec![[points[39], points[2]]]);
        builder.push_lines(LineKind::Wall, 0, &along).unwrap();
        for batch in batches(&points, &heights(&points)) {
            builder.push(&batch).await.unwrap();
        }
        builder.finish().await.unwrap();
        let reader = scratch.open().await;
        reader.verify(true).await.unwrap();
        let tiles: Vec<_> = reader.tiles().try_collect().await.unwrap();
        let mut of_others = 0;
        for tile in &tiles {
            // The corners of other tiles come after the tile's own, and here is one at most.
            let next = tile.owned_constraints().flat_map(|edge| tile.ends(edge));
            let next: Vec<_> = next.filter(|end| end.id.tile != tile.id()).collect();
            for end in next {
                let corner = delaunay_tiles::geometry::VertexIndex(tile.vertex_count());
                assert_eq!(tile.vertex(corner), end);
                assert_eq!(tile.z(corner), Some(height(end.point)));
                of_others += 1;
            }
        }
        assert!(of_others > 2, "{of_others}");
    });
}

/// A resumed build takes z from the journal and from the log of borders.
#[test]
fn interrupted_builds_with_z_resume_to_the_same_bytes() {
    let points = points_of(Kind::Kuzmin, 200_000, 2);
    let resumable = |resume: bool| {
        let memo = Some("points: 1".to_owned());
        options(1000, 2, 4_000_000).resumable(memo).resume(resume)
    };
    // Builds until that many points are done.
    let build_until = async |scratch: &Scratch, options: BuildOptions, until: u64| {
        let progress = Arc::clone(&options.progress);
        let watch = tokio::spawn(async move {
            while !matches!(progress.state(), (Phase::Conquer, done, _) if done >= until) {
                tokio::time::sleep(Duration::from_micros(200)).await;
            }
            progress.cancel();
        });
        let mut builder = Builder::new(&scratch.path, options)?;
        if builder.needs_points() {
            for batch in batches(&points, &heights(&points)) {
                builder.push(&batch).await?;
            }
        }
        let built = builder.finish().await;
        watch.abort();
        built
    };
    runtime().block_on(async {
        let whole = Scratch::new();
        build_until(&whole, resumable(false), u64::MAX).await.unwrap();
        check(&whole.open().await, "at once").await;
        let mut resumed_blocks = 0;
        for until in [50_000, 100_000, 180_000] {
            let scratch = Scratch::new();
            if build_until(&scratch, resumable(false), until).await.is_ok() {
                continue;
            }
            let summary = build_until(&scratch, resumable(true), u64::MAX).await.unwrap();
            resumed_blocks += summary.resumed_blocks;
            let [resumed, at_once] = [&scratch, &whole].map(|scratch| std::fs::read(&scratch.path).unwrap());
            assert!(resumed == at_once, "the file differs");
        }
        assert!(resumed_blocks > 0, "no build went on from a finished block");
    });
}

#[test]
fn edits_keep_the_z_of_all_corners_and_add_that_of_new_vertices() {
    let mut random = Random(4);
    let points = points_of(Kind::Uniform, 3000, 8);
    let rows: Vec<[Point; 2]> = (1..9)
        .map(|row| {
            let y = f64::from(row) / 9.0 + 0.001 * random.unit();
            // New vertices at both ends, and the line between them crosses many tiles.
            [Point::new(0.1 + 0.01 * random.unit(), y), Point::new(0.9, y + 0.001)]
        })
        .collect();
    runtime().block_on(async {
        let built = Scratch::new();
        let all = lines(rows.clone());
        build(&built, &points, &all, options(30, 2, ENOUGH)).await.unwrap();
        let expected = built.open().await.recompute_digest().await.unwrap();
        let scratch = Scratch::new();
        build(&scratch, &points, &SegmentBatch::default(), options(30, 2, ENOUGH))
            .await
            .unwrap();
        for (ends, number) in rows.chunks(4).zip([0, 4]) {
            let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(64 << 20))
                .await
                .unwrap()
                .begin()
                .await
                .unwrap();
            let batch = lines(ends.to_vec());
            transaction.constrain(LineKind::BreakLine, number, &batch).unwrap();
            assert!(transaction.commit().await.unwrap().added_vertices >= 8);
            assert!(check(&scratch.open().await, "edited").await > 1000);
        }
        let reader = scratch.open().await;
        assert_eq!(reader.recompute_digest().await.unwrap(), expected);
        reader.compact(&scratch.path).await.unwrap();
        check(&scratch.open().await, "compacted").await;
    });
}

#[test]
fn a_height_is_found_in_the_tiles_that_locate_reads() {
    let points = points_of(Kind::Uniform, 3000, 8);
    runtime().block_on(async {
        let scratch = Scratch::new();
        let batches = batches(&points, &heights(&points));
        build_batches(&scratch.path, &batches, options(10, 2, ENOUGH))
            .await
            .unwrap();
        let open = async || TileReader::open(&scratch.path, OpenOptions::default()).await.unwrap();
        let mut random = Random(6);
        let mut others = 0;
        let targets = (0..200).map(|_| Point::new(random.unit(), random.unit()));
        for target in targets.chain(points.iter().copied().step_by(50)) {
            let (one, other) = (open().await, open().await);
            let z = one.z_at(target.x, target.y).await.unwrap();
            let location = other.locate(target.x, target.y).await.unwrap();
            let misses = [&one, &other].map(|reader| reader.cache().statistics().misses);
            assert_eq!(misses[0], misses[1], "{target:?}");
            match location {
                Location::Outside => assert_eq!(z, None),
                Location::OnVertex(vertex) => assert_eq!(z, Some(height(vertex.point))),
                Location::OnEdge { triangle, .. } | Location::InTriangle(triangle) => {
                    let corners = triangle.vertices.map(|vertex| height(vertex.point));
                    let [least, most] = [f64::min, f64::max].map(|f| corners.into_iter().reduce(f).unwrap());
                    let z = z.unwrap();
                    assert!(least - 1e-9 <= z && z <= most + 1e-9, "{target:?}: {z}");
                    others += usize::from(triangle.vertices.iter().any(|v| v.id.tile != triangle.tile));
                }
            }
        }
        assert!(others > 50, "{others}");
    });
}
