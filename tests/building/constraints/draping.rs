//! Lines, obstacles and sites without z take it from the triangulation of the points alone.

use std::collections::BTreeMap;

use delaunay_tiles::geometry::{Point, Rect};
use delaunay_tiles::input::{PointBatch, SegmentBatch, SiteBatch, SiteId};
use delaunay_tiles::store::{LineKind, TileReader};
use delaunay_tiles::{
    BuildError, BuildOptions, BuildSummary, Builder, Crossings, EditError, EditOptions, Editor, MissingZ, WithoutZ,
};
use futures::TryStreamExt;

use super::{ENOUGH, Segment};
use crate::support::{Random, Scratch, runtime};

pub(super) fn p(x: f64, y: f64) -> Point {
    Point::new(x, y)
}

/// Points of the unit square and its corners, with the z of a function.
pub(super) fn ground(count: usize, z: impl Fn(Point, &mut Random) -> f64) -> PointBatch {
    let mut random = Random(7);
    let corners = [p(0.0, 0.0), p(1.0, 0.0), p(1.0, 1.0), p(0.0, 1.0)];
    let inside: Vec<Point> = (0..count).map(|_| p(random.unit(), random.unit())).collect();
    let points: Vec<Point> = corners.into_iter().chain(inside).collect();
    PointBatch {
        z: points.iter().map(|&point| z(point, &mut random)).collect(),
        records: (0..points.len() as u64).collect(),
        points,
    }
}

fn slope(point: Point) -> f64 {
    3.0 * point.x - 2.0 * point.y + 5.0
}

pub(super) fn lines(ends: Vec<Segment>) -> SegmentBatch {
    SegmentBatch {
        lines: (0..ends.len() as u64).collect(),
        ends,
        ..SegmentBatch::default()
    }
}

/// Break lines that cross each other, a square obstacle and sites, all within the unit square.
struct Without {
    break_lines: Vec<Segment>,
    obstacle: Vec<Segment>,
    sites: Vec<Point>,
}

impl Without {
    fn z() -> Self {
        let mut random = Random(3);
        let mut point = || p(0.1 + 0.8 * random.unit(), 0.1 + 0.8 * random.unit());
        let ring = [p(0.41, 0.43), p(0.57, 0.43), p(0.57, 0.58), p(0.41, 0.58)];
        Self {
            break_lines: (0..12).map(|_| [point(), point()]).collect(),
            obstacle: (0..4).map(|i| [ring[i], ring[(i + 1) % 4]]).collect(),
            sites: (0..50).map(|_| point()).collect(),
        }
    }

    async fn build(&self, scratch: &Scratch, ground: &PointBatch, options: BuildOptions) -> BuildSummary {
        let mut builder = Builder::new(&scratch.path, options.crossings(Crossings::Split)).unwrap();
        let broken = lines(self.break_lines.clone());
        builder.push_lines(LineKind::BreakLine, 0, &broken).unwrap();
        let mut obstacle = lines(self.obstacle.clone());
        obstacle.lines = vec![0; 4];
        obstacle.polygons = vec![0; 4];
        let first = broken.lines.len() as u64;
        builder.push_lines(LineKind::Obstacle, first, &obstacle).unwrap();
        let sites = SiteBatch {
            points: self.sites.clone(),
            z: Vec::new(),
            ids: (0..self.sites.len() as u64).map(SiteId::Number).collect(),
        };
        builder.push_sites(&sites).unwrap();
        builder.push(ground).await.unwrap();
        builder.finish().await.unwrap()
    }
}

/// Returns all vertices: their coordinates, as bits, with their z and whether a point of the input
/// lies there.
pub(super) async fn vertices(reader: &TileReader) -> BTreeMap<[u64; 2], (f64, bool)> {
    let tiles: Vec<_> = reader.tiles().try_collect().await.unwrap();
    let mut all = BTreeMap::new();
    for tile in &tiles {
        for vertex in tile.vertex_indices() {
            let Point { x, y } = tile.point(vertex);
            let of_vertex = (tile.z(vertex).unwrap(), tile.is_input_point(vertex));
            assert_eq!(all.insert([x, y].map(f64::to_bits), of_vertex), None);
        }
    }
    all
}

pub(super) fn at([x, y]: [u64; 2]) -> Point {
    p(f64::from_bits(x), f64::from_bits(y))
}

pub(super) const WAYS: [(usize, usize, u64); 3] = [(65536, 1, ENOUGH), (1000, 2, ENOUGH), (1000, 2, 3 << 20)];

pub(super) fn options((tile_vertices, threads, memory): (usize, usize, u64)) -> BuildOptions {
    BuildOptions::default()
        .tile_vertices(tile_vertices)
        .threads(threads)
        .memory(memory)
}

#[test]
fn lines_obstacles_crossings_and_sites_without_z_lie_on_the_plane_of_the_points() {
    runtime().block_on(async {
        let ground = ground(60_000, |point, _| slope(point));
        for way in WAYS {
            let scratch = Scratch::new();
            let summary = Without::z().build(&scratch, &ground, options(way)).await;
            assert!(summary.split_points > 10, "lines cross");
            assert_eq!((summary.draped, summary.draped_outside), (summary.added_vertices, 0));
            assert_eq!(summary.without_z, 0);
            assert_eq!(way.2 < ENOUGH, summary.blocks > 1, "{} blocks", summary.blocks);
            assert_eq!((summary.points, summary.duplicates), (60_004, 0));
            let reader = scratch.open().await;
            reader.verify(true).await.unwrap();
            let all = vertices(&reader).await;
            let added = all.iter().filter(|(_, (_, is_point))| !is_point);
            assert_eq!(added.clone().count() as u64, summary.draped);
            for (&key, (z, _)) in added {
                assert!((z - slope(at(key))).abs() < 1e-12, "{:?}: {z}", at(key));
            }
        }
    });
}

#[test]
fn draped_heights_are_those_of_the_points_alone_whatever_the_tiles_threads_and_memory() {
    runtime().block_on(async {
        let rough = ground(60_000, |_, random| random.unit());
        let mut found = Vec::new();
        for way in WAYS {
            let scratch = Scratch::new();
            Without::z().build(&scratch, &rough, options(way)).await;
            found.push(vertices(&scratch.open().await).await);
        }
        assert!(found.iter().all(|all| *all == found[0]));
        // Against the triangle of the points around each vertex, found by all edges.
        let alone = Scratch::new();
        let mut builder = Builder::new(&alone.path, options(WAYS[1])).unwrap();
        builder.push(&rough).await.unwrap();
        builder.finish().await.unwrap();
        let alone = alone.open().await;
        for (&key, (z, _)) in found[0].iter().filter(|(_, (_, is_point))| !is_point) {
            let expected = z_by_area(&alone, at(key)).await;
            assert!((z - expected).abs() < 1e-9, "{:?}: {z}, not {expected}", at(key));
        }
    });
}

/// Returns z at a point by the areas of the three parts of its triangle.
async fn z_by_area(reader: &TileReader, point: Point) -> f64 {
    let rect = Rect::new(point.x, point.y, point.x, point.y);
    let around: Vec<_> = reader.triangles_in(rect).try_collect().await.unwrap();
    let corners = around[0].vertices;
    let area = |a: Point, b: Point, c: Point| (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    let [a, b, c] = corners.map(|corner| corner.point);
    let parts = [area(point, b, c), area(a, point, c), area(a, b, point)];
    let mut z = 0.0;
    for (part, corner) in parts.into_iter().zip(corners) {
        z += part / area(a, b, c) * reader.z_of(corner.id).await.unwrap().unwrap();
    }
    z
}

/// Builds with one break line and returns z at both ends.
async fn z_of_line(points: &[(Point, f64)], line: Segment) -> ([f64; 2], BuildSummary) {
    let scratch = Scratch::new();
    let mut builder = Builder::new(&scratch.path, BuildOptions::default()).unwrap();
    builder.push_lines(LineKind::BreakLine, 0, &lines(vec![line])).unwrap();
    let batch = PointBatch {
        points: points.iter().map(|(point, _)| *point).collect(),
        z: points.iter().map(|(_, z)| *z).collect(),
        records: (0..points.len() as u64).collect(),
    };
    builder.push(&batch).await.unwrap();
    let summary = builder.finish().await.unwrap();
    let all = vertices(&scratch.open().await).await;
    (line.map(|end| all[&[end.x, end.y].map(f64::to_bits)].0), summary)
}

#[test]
fn outside_the_hull_the_z_is_that_of_its_nearest_point() {
    runtime().block_on(async {
        // A grid of 20 by 20 whose z is x.
        let grid: Vec<(Point, f64)> = (0..400)
            .map(|n| (p((n % 20).into(), (n / 20).into()), (n % 20).into()))
            .collect();
        let (z, summary) = z_of_line(&grid, [p(5.5, 3.25), p(7.25, -30.0)]).await;
        assert_eq!((z, summary.draped, summary.draped_outside), ([5.5, 7.25], 2, 1));
        let (z, summary) = z_of_line(&grid, [p(-3.0, 40.0), p(25.0, 9.5)]).await;
        assert_eq!((z, summary.draped, summary.draped_outside), ([0.0, 19.0], 2, 2));
        // Points on a line, and a single one, have no triangle.
        let (z, _) = z_of_line(&grid[3..=5], [p(3.5, 1.0), p(9.0, 1.0)]).await;
        assert_eq!(z, [3.5, 5.0]);
        let (z, _) = z_of_line(&grid[7..8], [p(3.5, 1.0), p(9.0, 1.0)]).await;
        assert_eq!(z, [7.0, 7.0]);
    });
}

#[test]
fn outside_the_hull_the_z_does_not_depend_on_the_tiles() {
    runtime().block_on(async {
        let mut random = Random(11);
        let turn = |i: u32, count: u32, radius: f64| {
            let angle = f64::from(i) / f64::from(count) * std::f64::consts::TAU;
            p(radius * angle.cos(), radius * angle.sin())
        };
        // All points of a circle are on the hull.
        let points: Vec<Point> = (0..300)
            .map(|i| turn(i, 300, 1.0))
            .chain((0..300).map(|i| turn(i * 7, 300, random.unit())))
            .collect();
        let batch = PointBatch {
            z: points.iter().map(|_| random.unit()).collect(),
            records: (0..600).collect(),
            points,
        };
        let around = lines((0..500).map(|i| [turn(i, 500, 1.1), turn(i, 500, 1.2)]).collect());
        let mut found = Vec::new();
        for tile_vertices in [65536, 4, 16, 100] {
            let scratch = Scratch::new();
            let options = BuildOptions::default().tile_vertices(tile_vertices);
            let mut builder = Builder::new(&scratch.path, options).unwrap();
            builder.push_lines(LineKind::BreakLine, 0, &around).unwrap();
            builder.push(&batch).await.unwrap();
            let summary = builder.finish().await.unwrap();
            assert_eq!(summary.draped_outside, 1000);
            found.push(vertices(&scratch.open().await).await);
        }
        assert!(found.iter().all(|all| *all == found[0]));
    });
}

#[test]
fn without_points_that_have_z_there_is_no_surface() {
    runtime().block_on(async {
        let build = async |z_of_points: &[f64]| {
            let scratch = Scratch::new();
            let mut builder = Builder::new(&scratch.path, BuildOptions::default())?;
            let mut batch = lines(vec![[p(0.1, 0.2), p(0.8, 0.3)], [p(0.1, 0.6), p(0.8, 0.7)]]);
            batch.z = vec![[1.0; 2], [f64::NAN; 2]];
            builder.push_lines(LineKind::BreakLine, 0, &batch)?;
            let mut points = ground(10, |_, _| 0.0);
            points.z = z_of_points.to_vec();
            builder.push(&points).await?;
            let built = builder.finish().await;
            assert!(!scratch.path.exists() || built.is_ok());
            built
        };
        match build(&[]).await {
            Err(BuildError::NoZ { first, count }) => assert_eq!((first.what, count), (WithoutZ::Point(0), 16)),
            other => panic!("{other:?}"),
        }
        assert_eq!(build(&[2.0; 14]).await.unwrap().draped, 2);
    });
}

#[test]
fn an_edit_drapes_ends_on_the_triangulation_before_it() {
    runtime().block_on(async {
        let scratch = Scratch::new();
        let rough = ground(3000, |_, random| random.unit());
        let mut builder = Builder::new(&scratch.path, BuildOptions::default().tile_vertices(200)).unwrap();
        builder.push(&rough).await.unwrap();
        builder.finish().await.unwrap();
        let before = scratch.open().await;
        // Many ends in few triangles: each would change the surface for the next.
        let mut random = Random(5);
        let end = |random: &mut Random, x: f64| p(x + 0.02 * random.unit(), 0.5 + 0.02 * random.unit());
        let ends: Vec<Segment> = (0..40)
            .map(|n| {
                let x = 0.1 + 0.02 * f64::from(n);
                [end(&mut random, x), p(x + 0.021, 0.47)]
            })
            .collect();
        let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(ENOUGH))
            .await
            .unwrap()
            .begin()
            .await
            .unwrap();
        transaction
            .constrain(LineKind::BreakLine, 0, &lines(ends.clone()))
            .unwrap();
        let edited = transaction.commit().await.unwrap();
        assert_eq!(edited.added_vertices, 80);
        let reader = scratch.open().await;
        reader.verify(true).await.unwrap();
        let all = vertices(&reader).await;
        for end in ends.iter().flatten() {
            let expected = before.z_at(end.x, end.y).await.unwrap().unwrap();
            assert_eq!(all[&[end.x, end.y].map(f64::to_bits)].0, expected, "{end:?}");
        }
        // Refused on request, and nothing changes.
        let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(ENOUGH))
            .await
            .unwrap()
            .begin()
            .await
            .unwrap();
        transaction.missing_z(MissingZ::Error);
        transaction
            .constrain(LineKind::BreakLine, 0, &lines(vec![[p(0.3, 0.8), p(0.31, 0.8)]]))
            .unwrap();
        let refused = transaction.commit().await;
        assert!(matches!(refused, Err(EditError::NoZ { count: 2, .. })), "{refused:?}");
        assert_eq!(vertices(&scratch.open().await).await, all);
    });
}
