//! In ponds all vertices have one z, the lowest of the shore on the triangulation of the points.

use std::collections::BTreeMap;

use delaunay_tiles::geometry::{Orientation, Point, orient2d};
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::store::{LineKind, TileReader};
use delaunay_tiles::terrain::{Shores, Surface};
use delaunay_tiles::{BuildError, BuildOptions, BuildSummary, Builder, Crossings, MissingZ};
use futures::TryStreamExt;

use super::Segment;
use super::draping::{WAYS, at, ground, lines, options, p, vertices};
use crate::support::{Random, Scratch, runtime};

/// Convex rings of ponds, counter-clockwise, and an island in the first one.
struct Lakes {
    ponds: Vec<Vec<Point>>,
    island: Vec<Point>,
}

fn circle(center: Point, radius: f64, corners: usize) -> Vec<Point> {
    let turn = |i: usize| i as f64 / corners as f64 * std::f64::consts::TAU;
    let corner = |i: usize| p(center.x + radius * turn(i).cos(), center.y + radius * turn(i).sin());
    (0..corners).map(corner).collect()
}

fn edges(ring: &[Point]) -> impl Iterator<Item = Segment> {
    (0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()]])
}

fn is_in(ring: &[Point], point: Point) -> bool {
    edges(ring).all(|[a, b]| orient2d(a, b, point) != Orientation::Clockwise)
}

fn is_inside(ring: &[Point], point: Point) -> bool {
    edges(ring).all(|[a, b]| orient2d(a, b, point) == Orientation::CounterClockwise)
}

impl Lakes {
    fn new() -> Self {
        Self {
            ponds: vec![circle(p(0.3, 0.3), 0.18, 40), circle(p(0.7, 0.65), 0.11, 7)],
            island: circle(p(0.33, 0.27), 0.05, 9),
        }
    }

    /// Returns the polygons as a file of polygons is read.
    fn batch(&self) -> SegmentBatch {
        let mut batch = SegmentBatch::default();
        for (pond, ring) in self.ponds.iter().enumerate() {
            batch.ends.extend(edges(ring));
            if pond == 0 {
                batch.ends.extend(edges(&self.island).map(|[a, b]| [b, a]));
            }
            // Both are of one line: a MultiPolygon.
            batch.lines.resize(batch.ends.len(), 0);
            batch.polygons.resize(batch.ends.len(), pond as u64);
        }
        batch
    }

    /// Returns the pond of a point, in it or on its shore.
    fn pond_of(&self, point: Point) -> Option<usize> {
        let pond = self.ponds.iter().position(|ring| is_in(ring, point))?;
        (pond > 0 || !is_inside(&self.island, point)).then_some(pond)
    }
}

/// Lines that cross the shores, some of them with z.
fn crossing_lines() -> SegmentBatch {
    let mut random = Random(3);
    let ends = (0..12)
        .map(|_| [p(0.2, random.unit()), p(0.9, random.unit())])
        .collect();
    let mut batch = lines(ends);
    batch.z = (0..12).map(|i| [if i % 2 == 0 { 9.0 } else { f64::NAN }; 2]).collect();
    batch
}

async fn build(
    scratch: &Scratch,
    ponds: &SegmentBatch,
    z: fn(Point, &mut Random) -> f64,
    options: BuildOptions,
) -> Result<BuildSummary, BuildError> {
    let mut builder = Builder::new(&scratch.path, options.crossings(Crossings::Split))?;
    builder.push_ponds(0, ponds)?;
    builder.push_lines(LineKind::BreakLine, 1, &crossing_lines())?;
    builder.push(&ground(60_000, z)).await?;
    builder.finish().await
}

fn rough(_: Point, random: &mut Random) -> f64 {
    random.unit()
}

#[test]
fn ponds_are_flat_at_the_lowest_z_of_their_shore_whatever_the_tiles_threads_and_memory() {
    runtime().block_on(async {
        let lakes = Lakes::new();
        let alone = Scratch::new();
        let mut builder = Builder::new(&alone.path, options(WAYS[1])).unwrap();
        builder.push(&ground(60_000, rough)).await.unwrap();
        builder.finish().await.unwrap();
        let alone = alone.open().await;
        let mut lowest = [f64::INFINITY; 2];
        for (pond, rings) in [vec![&lakes.ponds[0], &lakes.island], vec![&lakes.ponds[1]]]
            .iter()
            .enumerate()
        {
            for edge in rings.iter().flat_map(|ring| edges(ring)) {
                let profile = alone.profile(&edge, Surface::default()).await.unwrap();
                let points = profile.parts.iter().flat_map(|part| &part.points);
                lowest[pond] = points.fold(lowest[pond], |lowest, point| lowest.min(point.z));
            }
        }
        let before = vertices(&alone).await;
        let mut found: Vec<BTreeMap<_, _>> = Vec::new();
        for way in WAYS {
            let scratch = Scratch::new();
            let summary = build(&scratch, &lakes.batch(), rough, options(way)).await.unwrap();
            let reader = scratch.open().await;
            reader.verify(true).await.unwrap();
            let all = vertices(&reader).await;
            let in_ponds = before.keys().filter(|&&key| lakes.pond_of(at(key)).is_some());
            assert_eq!((summary.ponds, summary.flattened), (2, in_ponds.count() as u64));
            for (&key, &(z, is_point)) in &all {
                match lakes.pond_of(at(key)) {
                    Some(pond) => assert_eq!(z, lowest[pond], "{:?}", at(key)),
                    None if is_point => assert_eq!(Some(&(z, true)), before.get(&key)),
                    None => {}
                }
            }
            // Rounded crossing points may be beside the shore.
            let on_shore = shore_ends(&reader).await;
            assert!(on_shore.len() > 70, "{}", on_shore.len());
            for key in on_shore {
                assert!(lowest.contains(&all[&key].0), "{:?}", at(key));
            }
            found.push(all);
        }
        assert!(found.iter().all(|all| *all == found[0]));
    });
}

/// Returns the ends of all constraint edges of line 0, which is the shores.
async fn shore_ends(reader: &TileReader) -> Vec<[u64; 2]> {
    let tiles: Vec<_> = reader.tiles().try_collect().await.unwrap();
    let mut ends = Vec::new();
    for tile in &tiles {
        for edge in tile.owned_constraints() {
            if tile.edge_sources(edge).any(|source| source.number() == 0) {
                ends.extend(tile.ends(edge).map(|end| [end.point.x, end.point.y].map(f64::to_bits)));
            }
        }
    }
    ends.sort_unstable();
    ends.dedup();
    ends
}

/// Builds with one square pond, whose corners have the given z, on a slope, z = 10 x. Returns its z.
async fn z_of_square(corner: f64, z: [f64; 4], missing_z: MissingZ) -> f64 {
    let ring = [p(0.0, 0.0), p(0.5, 0.0), p(0.5, 0.5), p(0.0, 0.5)].map(|at| p(at.x + corner, at.y + 0.25));
    let mut ponds = lines(edges(&ring).collect());
    ponds.lines = vec![0; 4];
    ponds.z = (0..4).map(|i| [z[i], z[(i + 1) % 4]]).collect();
    let scratch = Scratch::new();
    let mut options = BuildOptions::default();
    options.missing_z = missing_z;
    let mut builder = Builder::new(&scratch.path, options).unwrap();
    builder.push_ponds(0, &ponds).unwrap();
    builder.push(&ground(500, |point, _| 10.0 * point.x)).await.unwrap();
    builder.finish().await.unwrap();
    let reader = scratch.open().await;
    let all = vertices(&reader).await;
    let inside: Vec<f64> = all
        .iter()
        .filter(|(key, _)| is_in(&ring, at(**key)))
        .map(|(_, (z, _))| *z)
        .collect();
    assert!(
        inside.len() > 20 && inside.iter().all(|z| *z == inside[0]),
        "{inside:?}"
    );
    inside[0]
}

#[test]
fn corners_with_z_count_with_it_and_corners_outside_with_the_nearest_point_of_the_hull() {
    const NONE: f64 = f64::NAN;
    runtime().block_on(async {
        for missing_z in [MissingZ::Drape, MissingZ::Error, MissingZ::Zero] {
            let lowest = z_of_square(0.25, [NONE; 4], missing_z).await;
            assert!((lowest - 2.5).abs() < 1e-12, "{lowest}");
        }
        assert_eq!(z_of_square(0.25, [7.0, 8.0, 6.5, 9.0], MissingZ::Drape).await, 6.5);
        // The surface counts between corners without z.
        let lowest = z_of_square(0.25, [7.0, 8.0, NONE, NONE], MissingZ::Drape).await;
        assert!((lowest - 2.5).abs() < 1e-12, "{lowest}");
        // Half outside of the square, whose western side has z = 0.
        let lowest = z_of_square(-0.25, [NONE; 4], MissingZ::Drape).await;
        assert!(lowest.abs() < 1e-12, "{lowest}");
    });
}

#[test]
fn ponds_need_points_with_z_and_valid_shores() {
    runtime().block_on(async {
        let scratch = Scratch::new();
        let mut builder = Builder::new(&scratch.path, BuildOptions::default()).unwrap();
        builder.push_ponds(0, &Lakes::new().batch()).unwrap();
        let mut flat = ground(10, rough);
        flat.z.clear();
        builder.push(&flat).await.unwrap();
        assert!(matches!(
            builder.push_ponds(0, &SegmentBatch::default()),
            Err(BuildError::Order { .. })
        ));
        assert!(matches!(builder.finish().await, Err(BuildError::PondsWithoutZ)));
        assert!(!scratch.path.exists());
        let mut builder = Builder::new(&scratch.path, BuildOptions::default()).unwrap();
        let mut bad = Lakes::new().batch();
        bad.ends[3][1].x = f64::INFINITY;
        assert!(matches!(builder.push_ponds(0, &bad), Err(BuildError::Constraint(_))));
        bad.lines.pop();
        assert!(matches!(builder.push_ponds(0, &bad), Err(BuildError::Constraint(_))));
    });
}

#[test]
fn the_first_of_several_ponds_counts() {
    let mut shores = Shores::default();
    for (ring, number) in [circle(p(0.0, 0.0), 2.0, 30), circle(p(1.0, 0.0), 2.0, 5)]
        .iter()
        .zip(0..)
    {
        let mut batch = lines(edges(ring).collect());
        batch.lines.fill(number);
        shores.push(&batch);
    }
    assert_eq!((shores.count(), shores.corners()), (2, vec![p(2.0, 0.0), p(3.0, 0.0)]));
    let ponds = shores.with_z(vec![4.0, 3.0]);
    for (x, z) in [
        (-1.5, Some(4.0)),
        (1.0, Some(4.0)),
        (2.0, Some(4.0)),
        (2.5, Some(3.0)),
        (3.0, Some(3.0)),
        (3.5, None),
    ] {
        assert_eq!(ponds.z_at(p(x, 0.0)), z, "{x}");
    }
}
