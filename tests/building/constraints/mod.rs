//! The promise: the triangles and constraint edges are those of an in-core build. They do not
//! depend on the tile size, the fan-out, the memory, the threads, or the order and direction of the
//! segments. `verify` proves them.

mod crossings;
mod draping;
mod missing_z;
mod overlaps;
mod ponds;
mod stars;
mod steiner;

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::support::cases::{by_turns, cases};
use crate::support::test_data::data;
use crate::support::{Random, Scratch, batches, distinct, points_of, runtime, runtime_for, verify_lines};
use delaunay_tiles::geometry::{Orientation, Point, orient2d};
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::mesh::{Constrained, EngineKind, Inserter, Triangulation};
use delaunay_tiles::store::{Digest, EdgeSource, LineKind};
use delaunay_tiles::{BuildError, BuildOptions, BuildSummary, Builder, ConstraintError, EditOptions, Editor};
use distributions::{Kind, LongSegments, Pslg};
use proptest::prelude::*;

type Segment = [Point; 2];

/// Points, and segments given by their ends.
struct Input {
    name: &'static str,
    points: Vec<Point>,
    segments: Vec<Segment>,
}

impl Input {
    /// Creates an input whose segments are given by the indices of their points.
    fn between(name: &'static str, points: Vec<Point>, segments: impl IntoIterator<Item = [u32; 2]>) -> Self {
        let segments = segments.into_iter().map(|s| s.map(|v| points[v as usize])).collect();
        Self { name, points, segments }
    }

    /// Creates an input of points and of polylines given by their corners.
    fn lines(name: &'static str, points: Vec<Point>, lines: &[Vec<(f64, f64)>]) -> Self {
        let lines = lines.iter().flat_map(|line| line.windows(2));
        let segments = lines.map(|pair| [pair[0], pair[1]].map(|(x, y)| Point::new(x, y)));
        Self {
            name,
            segments: segments.collect(),
            points,
        }
    }

    /// Returns all vertices, in order. A segment of no length has none.
    fn vertices(&self) -> Vec<Point> {
        let ends = self
            .segments
            .iter()
            .filter(|ends| ends[0] != ends[1])
            .flatten()
            .copied();
        distinct(&self.points.iter().copied().chain(ends).collect::<Vec<_>>())
    }

    /// Triangulates in core and returns the digest. Segments that cross earlier ones are left out,
    /// and removed from the input.
    fn in_core(&mut self) -> Digest {
        let points = self.vertices();
        let number = |p: Point| points.binary_search_by(|q| q.lex_cmp(p.normalized())).unwrap() as u32;
        let mut mesh = Triangulation::default();
        EngineKind::Native.create().triangulate(&points, &mut mesh);
        let mut mesh = Constrained::new(mesh, points.len());
        let mut inserter = Inserter::default();
        let mut before = mesh.clone();
        self.segments.retain(|segment| {
            if segment[0] == segment[1] {
                return true;
            }
            let is_in = inserter.insert(&points, &mut mesh, segment.map(number)).is_ok();
            if is_in && points.len() < 1000 {
                before = mesh.clone();
            } else if !is_in {
                assert!(points.len() < 1000, "segments cross");
                mesh = before.clone();
            }
            is_in
        });
        // The ends of removed segments are no longer vertices.
        let left = self.vertices();
        if left.len() < points.len() {
            return self.in_core();
        }
        let mut digest = Digest::default();
        points.iter().for_each(|&p| digest.add_vertex(p));
        for triangle in &mesh.mesh().triangles {
            digest.add_triangle(triangle.map(|v| points[v as usize]));
        }
        for edge in mesh.constraints() {
            digest.add_constraint_edge(edge.map(|v| points[v as usize]));
        }
        // Each segment is a source of every edge between two neighbours on it.
        for segment in self.segments.iter().filter(|ends| ends[0] != ends[1]) {
            let mut ends = segment.map(Point::normalized);
            ends.sort_unstable_by(|a, b| a.lex_cmp(*b));
            let [from, to] = ends;
            let between = points.partition_point(|p| p.lex_cmp(from).is_lt())..=number(to) as usize;
            let on_it = points[between]
                .iter()
                .filter(|&&p| orient2d(from, to, p) == Orientation::Collinear);
            let on_it: Vec<Point> = on_it.copied().collect();
            for edge in on_it.windows(2) {
                digest.add_edge_source([edge[0], edge[1]], EdgeSource::new(LineKind::BreakLine, 0));
            }
        }
        digest
    }

    async fn build(&self, scratch: &Scratch, options: BuildOptions) -> Result<BuildSummary, BuildError> {
        let mut builder = Builder::new(&scratch.path, options)?;
        for segments in self.segments.chunks(100) {
            builder.push_segments(segments)?;
        }
        for batch in batches(&self.points, &[]) {
            builder.push(&batch).await?;
        }
        builder.finish().await
    }
}

impl Input {
    /// Builds with some of the segments, with the ends of all of them as points or not, and inserts
    /// the other segments in an edit.
    async fn check_edited(&self, tile_vertices: usize, expected: Digest, way: &str) {
        for (built, has_ends) in [
            (0, true),
            (0, false),
            (self.segments.len() / 3, true),
            (self.segments.len() / 3, false),
        ] {
            let (first, later) = self.segments.split_at(built);
            // The ends of segments of no length are no vertices.
            let ends = later.iter().filter(|ends| has_ends && ends[0] != ends[1]).flatten();
            let scratch = Scratch::new();
            let start = Input {
                name: self.name,
                points: self.points.iter().chain(ends).copied().collect(),
                segments: first.to_vec(),
            };
            let options = BuildOptions::default().tile_vertices(tile_vertices).memory(ENOUGH);
            match start.build(&scratch, options).await {
                Ok(built) if built.triangles > 0 => {}
                Ok(_) => continue,
                // The first segments meet in an end of a later one, so without that end they cross.
                Err(BuildError::Crossings { .. }) if !has_ends => continue,
                Err(error) => panic!("{way}: {error}"),
            }
            // So little memory that tiles must leave the cache and come back.
            let memory = (512 << 10) + 400 * later.len() as u64;
            let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(memory))
                .await
                .unwrap()
                .begin()
                .await
                .unwrap();
            let batch = SegmentBatch {
                lines: (built as u64..).take(later.len()).collect(),
                ends: later.to_vec(),
                ..SegmentBatch::default()
            };
            transaction.constrain(LineKind::BreakLine, 0, &batch).unwrap();
            let summary = match transaction.commit().await {
                Ok(summary) => summary,
                Err(error) => panic!("{way}, edited: {error}"),
            };
            assert_eq!(
                summary.added_vertices == 0,
                self.vertices().len() == start.vertices().len()
            );
            let reader = scratch.open().await;
            assert_eq!(reader.recompute_digest().await.unwrap(), expected, "{way}, edited");
            assert_eq!(reader.generation(), 2);
            match reader.verify(true).await {
                Ok(report) => assert_eq!(report.constraint_edges, summary.constraint_edges),
                Err(error) => panic!("{way}, edited: {error}"),
            }
            let lines = self.segments.iter().zip(0..);
            let lines = lines.map(|(&ends, number)| (ends, EdgeSource::new(LineKind::BreakLine, number)));
            if let Err(error) = verify_lines(&reader, lines.collect()).await {
                panic!("{way}, edited: {error}");
            }
        }
    }
}

/// (tile vertices, merge vertices, threads, memory)
type Way = (usize, usize, usize, u64);

const ENOUGH: u64 = 1 << 30;

const WAYS: [Way; 7] = [
    (8, 16, 1, ENOUGH),
    // The segments need more than the share of a leaf, so some are deferred.
    (50, 1 << 16, 2, 1 << 20),
    (8, 1 << 16, 2, ENOUGH),
    (50, 200, 3, ENOUGH),
    (64, 1 << 16, 1, ENOUGH),
    (1000, 1 << 16, 2, ENOUGH),
    (1 << 16, 1 << 16, 1, ENOUGH),
];

/// Returns the ways in which long tests build.
fn ways() -> &'static [Way] {
    match cases(4) {
        4 => &WAYS,
        // Among them is the one in which segments are deferred.
        _ => &WAYS[..3],
    }
}

/// Builds in all `ways`, by turns from the input and from its reverse, or from both where all cases
/// run, and compares with the in-core triangulation. Returns the number of deferred segments in all.
fn check(mut input: Input, ways: &[Way]) -> u64 {
    let expected = input.in_core();
    let mut deferred = 0;
    let mut turned = Input {
        name: input.name,
        points: input.points.iter().rev().copied().collect(),
        segments: input.segments.iter().rev().map(|&[a, b]| [b, a]).collect(),
    };
    Random(5).shuffle(&mut turned.segments);
    let inputs = ways.iter().enumerate().flat_map(|(round, way)| {
        let inputs = by_turns(&[&input, &turned], round);
        inputs.into_iter().map(move |input| (way, input))
    });
    for (&(tile_vertices, merge_vertices, threads, memory), input) in inputs {
        runtime_for(threads).block_on(async {
            let scratch = Scratch::new();
            let options = BuildOptions::default()
                .tile_vertices(tile_vertices)
                .merge_vertices(merge_vertices)
                .threads(threads)
                .memory(memory);
            let name = input.name;
            let way =
                format!("{name}: tiles of {tile_vertices}, merges of {merge_vertices}, {threads} threads, {memory}");
            let summary = match input.build(&scratch, options).await {
                Ok(summary) => summary,
                Err(error) => panic!("{way}: {error}"),
            };
            deferred += summary.deferred_segments;
            let reader = scratch.open().await;
            assert_eq!(reader.recompute_digest().await.unwrap(), expected, "{way}");
            match reader.verify(true).await {
                Ok(report) => assert_eq!(report.constraint_edges, summary.constraint_edges),
                Err(error) => panic!("{way}: {error}"),
            }
            // Each segment is a break line of its own.
            let lines = input.segments.iter().zip(0..);
            let mut lines: Vec<_> = lines
                .map(|(&ends, number)| (ends, EdgeSource::new(LineKind::BreakLine, number)))
                .collect();
            match verify_lines(&reader, lines.clone()).await {
                Ok(report) => assert_eq!(report.segments, lines.len() as u64),
                Err(error) => panic!("{way}: {error}"),
            }
            if let Some(last) = lines.pop_if(|(ends, _)| ends[0] != ends[1]) {
                assert!(verify_lines(&reader, lines).await.is_err(), "{way}: without {last:?}");
            }
            let points = distinct(&input.points).len() as u64;
            assert_eq!(summary.duplicates, input.points.len() as u64 - points, "{way}");
            assert_eq!(summary.added_vertices, summary.vertices - points, "{way}");
            if merge_vertices == 1 << 16 && tile_vertices <= 64 {
                input.check_edited(tile_vertices, expected, &way).await;
            }
        });
    }
    deferred
}

#[test]
fn collinear_points_keep_their_constraint_edges() {
    let on = |(dx, dy): (f64, f64), at: f64| Point::new(3.0 + dx * at, dy * at - 1.0);
    for (direction, seed) in [
        ((1.0, 0.0), 1),
        ((0.0, 1.0), 2),
        ((1.0, 3.0), 3),
        ((2.0, -1.0), 4),
        ((-1.0, -1.0), 5),
    ] {
        let mut random = Random(seed);
        for (points, segments, length) in [
            (0, 1, 9),
            (1, 3, 1),
            (2, 9, 7),
            (200, 40, 60),
            (300, 300, 9),
            (40, 400, 2),
        ] {
            let mut position = || random.below(1000) as f64;
            let points = (0..points).map(|_| on(direction, position())).collect();
            let ends: Vec<f64> = (0..segments).map(|_| position()).collect();
            let ends = ends
                .into_iter()
                .map(|at| (at, at + random.below(2 * length + 1) as f64 - length as f64));
            let segments = ends.map(|(from, to)| [from, to].map(|at| on(direction, at))).collect();
            let name = "points on one line";
            check(Input { name, points, segments }, ways());
        }
    }
}

#[test]
fn pslgs_of_the_thesis_equal_the_in_core_triangulation() {
    for (kind, alpha) in [
        (Kind::Uniform, 0.5),
        (Kind::Kuzmin, 0.5),
        (Kind::LineSingularity, 0.5),
        (Kind::Uniform, 0.9),
    ] {
        let pslg = Pslg::new(kind, cases(3000) as u64, alpha, 3).unwrap();
        let points = pslg.points().map(|[x, y]| Point::new(x, y)).collect();
        check(Input::between(kind.name(), points, pslg.segments()), ways());
    }
}

#[test]
fn long_segments_across_all_tiles_equal_the_in_core_triangulation() {
    for (points, segments) in [(2000, 40), (300, 100), (0, 60)] {
        let is_small = points == 0;
        let long = LongSegments::new(points, segments, 3).unwrap();
        let points = long.points().map(|[x, y]| Point::new(x, y)).collect();
        let deferred = check(Input::between("long segments", points, long.segments()), ways());
        assert!(deferred > 0 || is_small, "nothing was deferred");
    }
}

#[test]
fn stars_spirals_combs_and_nested_polygons_equal_the_in_core_triangulation() {
    let at = |turn: f64, r: f64| (0.5 + r * (TAU * turn).cos(), 0.5 + r * (TAU * turn).sin());
    let star: Vec<_> = (0..150)
        .map(|i| f64::from(i) / 150.0)
        .map(|turn| vec![(0.5, 0.5), at(turn, 0.49)])
        .collect();
    let spiral = (0..300)
        .map(|i| at(f64::from(i) / 40.0, 0.01 + 0.0015 * f64::from(i)))
        .collect();
    let comb = (0..200)
        .map(|i| (0.1 + 0.004 * f64::from(i), if i % 2 == 0 { 0.05 } else { 0.95 }))
        .collect();
    let nested: Vec<Vec<_>> = (1..20)
        .map(|ring| {
            let corners = 8 + ring % 5;
            let corner = |i: i32| at(f64::from(i % corners) / f64::from(corners), 0.012 * 1.2f64.powi(ring));
            (0..=corners).map(corner).collect()
        })
        .collect();
    let points = points_of(Kind::Uniform, 1500, 2);
    for (name, lines) in [
        ("star", star),
        ("spiral", vec![spiral]),
        ("comb", vec![comb]),
        ("nested", nested),
    ] {
        check(Input::lines(name, points.clone(), &lines), ways());
        check(Input::lines(name, Vec::new(), &lines), ways());
    }
}

/// Segments along cell borders, through vertices, on top of each other, and of length zero; ties
/// are everywhere.
#[test]
fn segments_on_grids_equal_the_in_core_triangulation() {
    let mut random = Random(11);
    for round in (0..12).step_by(12 / cases(12)) {
        let size = 8 + 2 * round;
        let point = |random: &mut Random| Point::new(random.below(size) as f64, random.below(size) as f64);
        let points = (0..size * size / 2).map(|_| point(&mut random)).collect();
        let segments = (0..60)
            .map(|i| {
                let a = point(&mut random);
                match i % 4 {
                    0 => [a, Point::new(a.x, random.below(size) as f64)],
                    1 => [a, Point::new(random.below(size) as f64, a.y)],
                    2 => [a, Point::new(a.x + 1.0, a.y + random.below(3) as f64 - 1.0)],
                    _ => [a, point(&mut random)],
                }
            })
            .collect();
        let name = "grid";
        check(
            Input { name, points, segments },
            &[WAYS[0], WAYS[1], (4, 8, 2, ENOUGH), WAYS[2], WAYS[5]],
        );
    }
}

/// Most tiles have collinear vertices only, so they have no triangles to walk through.
#[test]
fn points_on_three_parallel_lines_equal_the_in_core_triangulation() {
    let lines = [0.0, 1000.0, 2000.0];
    let along = (0..400).map(f64::from);
    let points: Vec<Point> = lines
        .iter()
        .flat_map(|&y| along.clone().map(move |x| Point::new(x, y)))
        .collect();
    let mut segments: Vec<Segment> = lines.map(|y| [Point::new(399.0, y), Point::new(0.0, y)]).into();
    segments.push([Point::new(7.0, 1000.0), Point::new(300.5, 1000.0)]);
    segments.extend(along.step_by(9).map(|x| [Point::new(x, 0.0), Point::new(x, 2000.0)]));
    let turned = points.iter().map(|p| Point::new(p.y, p.x)).collect();
    let turned_segments = segments.iter().map(|s| s.map(|p| Point::new(p.y, p.x))).collect();
    for (name, points, segments) in [("rows", points, segments), ("columns", turned, turned_segments)] {
        check(Input { name, points, segments }, ways());
    }
}

#[test]
fn builds_larger_than_memory_equal_the_in_core_triangulation() {
    let pslg = Pslg::new(Kind::Uniform, 60_000, 0.5, 3).unwrap();
    let points = pslg.points().map(|[x, y]| Point::new(x, y)).collect();
    let ways = [(500, 1 << 16, 2, 4 << 20), (500, 1 << 16, 1, ENOUGH)];
    check(Input::between("PSLG", points, pslg.segments()), &ways);
    let long = LongSegments::new(40_000, 10, 3).unwrap();
    let points = long.points().map(|[x, y]| Point::new(x, y)).collect();
    let ways = [(500, 1 << 16, 2, 5 << 20), (500, 1 << 16, 1, ENOUGH)];
    check(Input::between("long segments", points, long.segments()), &ways);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(150) as u32, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn small_grids_in_small_tiles_equal_the_in_core_triangulation(
        points in prop::collection::vec((0u8..7, 0u8..7), 0..60),
        segments in prop::collection::vec(((0u8..7, 0u8..7), (0u8..7, 0u8..7)), 1..25),
    ) {
        let point = |(x, y): (u8, u8)| Point::new(x.into(), y.into());
        let mut input = Input {
            name: "small grid",
            points: points.into_iter().map(point).collect(),
            segments: segments.into_iter().map(|(a, b)| [point(a), point(b)]).collect(),
        };
        // Crossing segments are left out. That may remove the only vertex that is not collinear
        // with the others.
        input.in_core();
        let vertices = input.vertices();
        let [first, second] = [0, 1].map(|i| vertices.get(i).copied().unwrap_or_default());
        let is_flat = vertices.iter().all(|&p| {
            orient2d(first, second, p) == Orientation::Collinear
        });
        if !is_flat {
            check(input, &[(4, 8, 1, ENOUGH), (5, 1 << 16, 2, ENOUGH), (16, 64, 1, ENOUGH)]);
        }
    }
}

#[test]
fn crossing_segments_and_invalid_ends_are_refused_and_leave_no_files() {
    let square = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)].map(|(x, y)| Point::new(x, y));
    let [a, b, c, d] = square;
    runtime().block_on(async {
        let build = async |points: &[Point], segments: &[Segment]| {
            let scratch = Scratch::new();
            let input = Input {
                name: "wrong",
                points: points.to_vec(),
                segments: segments.to_vec(),
            };
            let options = BuildOptions::default().progress(Arc::default());
            let built = input
                .build(&scratch, options)
                .await
                .map(|summary| summary.constraint_edges);
            (built, std::fs::read_dir(scratch.folder.path()).unwrap().count())
        };
        let (crossed, left) = build(&square, &[[a, c], [b, d]]).await;
        let Err(BuildError::Crossings { first, count: 1 }) = &crossed else {
            panic!("{crossed:?}");
        };
        assert_eq!(first[0].point, Point::new(2.0, 2.0));
        assert_eq!(first[0].lines.map(|line| line.number()), [0, 1]);
        assert_eq!(left, 0);
        let (invalid, _) = build(&square, &[[a, c], [b, Point::new(f64::NAN, 0.0)]]).await;
        assert!(
            matches!(
                invalid,
                Err(BuildError::Constraint(ConstraintError::InvalidEnd { segment: 1, .. }))
            ),
            "{invalid:?}"
        );
        // With a point at the crossing, the segments meet there instead of crossing.
        let centre = [square.to_vec(), vec![Point::new(2.0, 2.0)]].concat();
        assert_eq!(build(&centre, &[[a, c], [b, d], [a, a]]).await.0.unwrap(), 4);
    });
}
