//! Vertices without z in a file where others have z.
//!
//! Break lines without z in terrain of 800 m once gave vertices at z = 0, 105 pits. A build told of
//! them in a note at most, an edit not at all.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{PointBatch, SegmentBatch, SiteBatch, SiteId};
use delaunay_tiles::store::LineKind;
use delaunay_tiles::{
    BuildError, BuildOptions, BuildSummary, Builder, Crossings, Duplicates, EditError, EditOptions, Editor, MissingZ,
    VertexWithoutZ, WithoutZ,
};
use futures::TryStreamExt;

use super::{ENOUGH, Segment};
use crate::support::{Random, Scratch, runtime};

const NONE: f64 = f64::NAN;

fn p(x: f64, y: f64) -> Point {
    Point::new(x, y)
}

/// Returns terrain of 800 m: a grid of 10 by 10 points, one unit apart.
fn terrain() -> PointBatch {
    let points: Vec<Point> = (0..100).map(|n| p(f64::from(n % 10), f64::from(n / 10))).collect();
    PointBatch {
        z: vec![800.0; points.len()],
        records: (0..100).collect(),
        points,
    }
}

fn lines(ends: &[Segment], z: &[[f64; 2]]) -> SegmentBatch {
    SegmentBatch {
        ends: ends.to_vec(),
        z: z.to_vec(),
        lines: (0..ends.len() as u64).collect(),
        ..SegmentBatch::default()
    }
}

struct Input {
    points: PointBatch,
    lines: SegmentBatch,
    walls: SegmentBatch,
    sites: SiteBatch,
}

impl Input {
    fn new(lines: SegmentBatch) -> Self {
        Self {
            points: terrain(),
            lines,
            walls: SegmentBatch::default(),
            sites: SiteBatch::default(),
        }
    }

    async fn build(&self, scratch: &Scratch, options: BuildOptions) -> Result<BuildSummary, BuildError> {
        let mut builder = Builder::new(&scratch.path, options)?;
        builder.push_lines(LineKind::BreakLine, 0, &self.lines)?;
        builder.push_lines(LineKind::Wall, self.lines.lines.len() as u64, &self.walls)?;
        builder.push_sites(&self.sites)?;
        builder.push(&self.points).await?;
        builder.finish().await
    }

    /// Builds and returns the error's first vertex and its count. Checks that no file is left.
    fn error(&self, options: BuildOptions) -> (VertexWithoutZ, u64) {
        runtime().block_on(async {
            let scratch = Scratch::new();
            let built = self.build(&scratch, options).await;
            assert!(!scratch.path.exists(), "nothing is published");
            match built {
                Err(BuildError::NoZ { first, count }) => (first, count),
                other => panic!("{other:?}"),
            }
        })
    }

    /// Builds and returns the z at `point` and the number of vertices that got 0.
    fn z_at(&self, point: Point, options: BuildOptions) -> (f64, u64) {
        runtime().block_on(async {
            let scratch = Scratch::new();
            let summary = self.build(&scratch, options).await.unwrap();
            (z_at(&scratch, point).await, summary.without_z)
        })
    }
}

async fn z_at(scratch: &Scratch, point: Point) -> f64 {
    let tiles: Vec<_> = scratch.open().await.tiles().try_collect().await.unwrap();
    let mut found = tiles.iter().flat_map(|tile| {
        let vertices = tile.vertex_indices().filter(|&vertex| tile.point(vertex) == point);
        vertices.map(|vertex| tile.z(vertex).expect("the file has z"))
    });
    found.next().expect("a vertex lies there")
}

fn options(missing_z: MissingZ) -> BuildOptions {
    BuildOptions::default().missing_z(missing_z)
}

#[test]
fn line_ends_without_z_get_zero_only_on_request() {
    let input = Input::new(lines(&[[p(1.0, 1.0), p(2.0, 2.0)], [p(1.5, 7.25), p(7.5, 7.25)]], &[]));
    let (first, count) = input.error(options(MissingZ::Error));
    assert_eq!((first.what, first.point, count), (WithoutZ::End, p(1.5, 7.25), 2));
    assert_eq!(
        first.line.map(|line| (line.kind(), line.number())),
        Some((LineKind::BreakLine, 1))
    );
    assert_eq!(input.z_at(p(7.5, 7.25), options(MissingZ::Zero)), (0.0, 2));
}

#[test]
fn a_line_end_without_z_takes_the_z_of_a_point_or_end_there() {
    let on_points = Input::new(lines(&[[p(1.0, 1.0), p(7.0, 8.0)]], &[]));
    assert_eq!(on_points.z_at(p(7.0, 8.0), options(MissingZ::Error)), (800.0, 0));
    // The line without z comes first and shares an end with one that has z.
    let both = lines(
        &[[p(1.0, 1.0), p(4.5, 4.25)], [p(4.5, 4.25), p(8.0, 1.0)]],
        &[[NONE; 2], [795.0, NONE]],
    );
    let both = Input::new(both);
    for missing_z in [MissingZ::Error, MissingZ::Drape] {
        assert_eq!(both.z_at(p(4.5, 4.25), options(missing_z)), (795.0, 0));
    }
}

#[test]
fn points_crossings_and_sites_without_z_get_zero_only_on_request() {
    let mut flat = Input::new(lines(&[[p(0.0, 0.0), p(9.0, 9.0)]], &[[700.0, 700.0]]));
    flat.points.z.clear();
    let (first, count) = flat.error(BuildOptions::default());
    assert_eq!((first.what, count), (WithoutZ::Point(0), 100));

    let mut crossing = Input::new(lines(&[[p(0.0, 0.0), p(9.0, 8.0)]], &[]));
    crossing.walls = lines(&[[p(0.0, 8.0), p(9.0, 0.0)]], &[]);
    let split = |missing_z| options(missing_z).crossings(Crossings::Split);
    let (first, count) = crossing.error(split(MissingZ::Error));
    assert_eq!((first.what, first.point, count), (WithoutZ::Crossing, p(4.5, 4.0), 1));
    assert_eq!(first.line.map(|line| line.number()), Some(0));
    assert_eq!(crossing.z_at(p(4.5, 4.0), split(MissingZ::Zero)), (0.0, 1));

    let mut shops = Input::new(SegmentBatch::default());
    shops.sites = SiteBatch {
        points: vec![p(3.0, 3.0), p(3.5, 3.25)],
        z: Vec::new(),
        ids: [0, 1].map(SiteId::Number).to_vec(),
    };
    let (first, count) = shops.error(options(MissingZ::Error));
    assert_eq!((first.what, count), (WithoutZ::Site(1), 1));
    assert_eq!(shops.z_at(p(3.0, 3.0), options(MissingZ::Zero)), (800.0, 1));
}

#[test]
fn equal_points_with_z_keep_it() {
    for duplicates in [Duplicates::Lowest, Duplicates::Highest] {
        let mut input = Input::new(SegmentBatch::default());
        input.points.points.push(p(3.0, 3.0));
        input.points.records.push(100);
        // All points have z, this one too.
        input.points.z.push(800.0);
        let options = BuildOptions::default().duplicates(duplicates);
        assert_eq!(input.z_at(p(3.0, 3.0), options), (800.0, 0));
    }
}

#[test]
fn the_reported_vertex_without_z_does_not_depend_on_tiles_threads_or_memory() {
    let mut random = Random(11);
    let points: Vec<Point> = (0..100_000).map(|_| p(random.unit(), random.unit())).collect();
    let ends: Vec<Segment> = (0..200)
        .map(|_| {
            let a = p(random.unit(), random.unit());
            [a, p(a.x + 1e-7, a.y)]
        })
        .collect();
    let mut input = Input::new(lines(&ends, &[]));
    // Every third line has z.
    input.lines.z = (0..200)
        .map(|n| if n % 3 == 0 { [5.0; 2] } else { [NONE; 2] })
        .collect();
    input.points = PointBatch {
        z: vec![1.0; points.len()],
        records: (0..points.len() as u64).collect(),
        points,
    };
    let ways = [(65536, 1, ENOUGH), (1000, 2, ENOUGH), (1000, 2, 3 << 20)].map(|(tile_vertices, threads, memory)| {
        input.error(
            options(MissingZ::Error)
                .tile_vertices(tile_vertices)
                .threads(threads)
                .memory(memory),
        )
    });
    let (first, count) = ways[0];
    assert_eq!((first.what, first.point, count), (WithoutZ::End, ends[1][0], 2 * 133));
    assert_eq!(first.line.map(|line| line.number()), Some(1));
    assert!(ways.iter().all(|way| *way == ways[0]), "{ways:?}");
}

#[test]
fn an_edit_gives_zero_to_vertices_without_z_only_on_request() {
    let later = lines(
        &[
            [p(1.0, 1.0), p(2.0, 2.0)],
            [p(1.5, 7.25), p(7.5, 7.25)],
            [p(7.5, 7.25), p(8.0, 2.0)],
        ],
        &[[NONE; 2], [NONE; 2], [790.0, NONE]],
    );
    runtime().block_on(async {
        let scratch = Scratch::new();
        let input = Input::new(SegmentBatch::default());
        input.build(&scratch, BuildOptions::default()).await.unwrap();
        let before = scratch.open().await.recompute_digest().await.unwrap();
        let edit = async |missing_z| {
            let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(ENOUGH))
                .await
                .unwrap()
                .begin()
                .await
                .unwrap();
            transaction.missing_z(missing_z);
            transaction.constrain(LineKind::BreakLine, 0, &later).unwrap();
            transaction.commit().await
        };
        match edit(MissingZ::Error).await {
            Err(EditError::NoZ { line, point, count }) => assert_eq!((line, point, count), (1, p(1.5, 7.25), 1)),
            other => panic!("{other:?}"),
        }
        assert_eq!(
            scratch.open().await.recompute_digest().await.unwrap(),
            before,
            "the file is as it was"
        );
        edit(MissingZ::Zero).await.unwrap();
        assert_eq!(z_at(&scratch, p(1.5, 7.25)).await, 0.0);
        assert_eq!(z_at(&scratch, p(7.5, 7.25)).await, 790.0);
        assert_eq!(z_at(&scratch, p(2.0, 2.0)).await, 800.0);
    });
}
