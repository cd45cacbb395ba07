//! Profiles, against a direct computation from all triangles.

use super::rasters::{Triangle, build, obstacle, terrain, triangles};
use crate::support::{Random, built, runtime};
use delaunay_tiles::BuildOptions;
use delaunay_tiles::geometry::{Point, Rect, crossing_point};
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::store::{OpenOptions, TileReader};
use delaunay_tiles::terrain::{Profile, Surface, TerrainError};

/// Returns lines in all positions: random ones, along rows of vertices, through vertices, and with
/// corners, some of them outside.
fn lines(points: &[Point]) -> Vec<Vec<Point>> {
    let mut random = Random(3);
    let mut lines: Vec<Vec<Point>> = (0..12)
        .map(|i| {
            let corners = 2 + i % 3;
            (0..corners)
                .map(|_| Point::new(1.4 * random.unit() - 0.2, 1.4 * random.unit() - 0.2))
                .collect()
        })
        .collect();
    lines.push([(-0.5, 0.5125), (1.5, 0.5125)].map(|(x, y)| Point::new(x, y)).to_vec());
    lines.push(
        [(0.25, 0.25), (0.625, 0.375), (0.375, 0.75)]
            .map(|(x, y)| Point::new(x, y))
            .to_vec(),
    );
    lines.push(points.iter().copied().step_by(300).collect());
    // There and back.
    lines.push(vec![points[3], points[400], points[3]]);
    lines
}

/// Checks each point of a profile, and that no edge which a segment of the line crosses was left out.
fn check(profile: &Profile, line: &[Point], counted: &[Triangle]) {
    let length: f64 = line
        .windows(2)
        .map(|ends| (ends[1].x - ends[0].x).hypot(ends[1].y - ends[0].y))
        .sum();
    assert!((profile.length - length).abs() < 1e-12);
    let mut all: Vec<(f64, Point)> = Vec::new();
    for part in &profile.parts {
        assert!(!part.points.is_empty());
        for point in &part.points {
            let at = counted.iter().filter(|t| t.z_at(point.point).is_finite());
            // A rounded crossing point is beside its triangles by a rounding.
            let near = at.filter(|t| {
                let [a, b, c] = t.corners;
                let whole = Triangle::area(a, b, c);
                [(a, b), (b, c), (c, a)]
                    .iter()
                    .all(|&(p, q)| Triangle::area(p, q, point.point) > -1e-15 - 1e-12 * whole)
            });
            let heights: Vec<f64> = near.map(|t| t.z_at(point.point)).collect();
            let close = heights
                .iter()
                .any(|z| (z - point.z).abs() < 1e-9 * (1.0 + z.abs()) * 100.0);
            assert!(close, "{point:?}: {heights:?}");
            all.push((point.distance, point.point));
        }
    }
    for pair in all.windows(2) {
        let is_twice = pair[0] == pair[1] && crossed_at(pair[0].1, line, counted) > 1;
        assert!(
            pair[0].0 < pair[1].0 || is_twice,
            "a point is there twice, or not in order: {pair:?}"
        );
    }
    // The edges of triangles that count.
    let mut before = 0.0;
    for ends in line.windows(2) {
        let (a, b) = (ends[0], ends[1]);
        for triangle in counted {
            for i in 0..3 {
                let (p, q) = (triangle.corners[i], triangle.corners[(i + 1) % 3]);
                if let Some(crossing) = crossing_point(a, b, p, q) {
                    let distance = before + (crossing.x - a.x).hypot(crossing.y - a.y);
                    let is_there = all
                        .iter()
                        .any(|&(at, point)| point == crossing && (at - distance).abs() < 1e-12);
                    assert!(is_there, "{crossing:?}");
                }
            }
        }
        before += (b.x - a.x).hypot(b.y - a.y);
    }
    check_gaps(profile, line, counted);
}

/// Returns the number of edges that cross the line at a point, rounded.
fn crossed_at(point: Point, line: &[Point], counted: &[Triangle]) -> usize {
    let mut edges = Vec::new();
    for (triangle, ends) in counted.iter().flat_map(|t| line.windows(2).map(move |ends| (t, ends))) {
        for i in 0..3 {
            let mut edge = [triangle.corners[i], triangle.corners[(i + 1) % 3]];
            edge.sort_by(|p, q| p.lex_cmp(*q));
            if crossing_point(ends[0], ends[1], edge[0], edge[1]) == Some(point) && !edges.contains(&edge) {
                edges.push(edge);
            }
        }
    }
    edges.len()
}

/// Between two points that follow each other, the surface is linear, and in gaps there is none.
fn check_gaps(profile: &Profile, line: &[Point], counted: &[Triangle]) {
    let at = |distance: f64| {
        let mut rest = distance;
        for ends in line.windows(2) {
            let (dx, dy) = (ends[1].x - ends[0].x, ends[1].y - ends[0].y);
            let length = dx.hypot(dy);
            if rest <= length {
                return Point::new(ends[0].x + dx * rest / length, ends[0].y + dy * rest / length);
            }
            rest -= length;
        }
        line[line.len() - 1]
    };
    let height = |p: Point| counted.iter().find(|t| t.contains(p)).map(|t| t.z_at(p));
    for part in &profile.parts {
        for pair in part.points.windows(2) {
            if pair[1].distance - pair[0].distance > 1e-6 {
                let middle = at((pair[0].distance + pair[1].distance) / 2.0);
                // Along an edge of a hole, the middle may be rounded into the hole.
                if let Some(z) = height(middle) {
                    assert!((z - (pair[0].z + pair[1].z) / 2.0).abs() < 1e-6, "{pair:?}: {z}");
                }
            }
        }
    }
    for [from, to] in profile.gaps() {
        for i in 1..8 {
            let p = at(from + (to - from) * f64::from(i) / 8.0);
            assert!(to - from < 1e-9 || height(p).is_none(), "{p:?} in {from} to {to}");
        }
    }
}

#[test]
fn a_profile_has_every_edge_that_the_line_crosses_whatever_the_tiles() {
    let (points, z) = terrain(7);
    let lines = lines(&points);
    runtime().block_on(async {
        let (mut crossings, mut gaps) = (0, 0);
        let limited = Surface::default().max_edge(Some(0.06));
        for (surface, holes, longest) in [(Surface::default(), false, f64::INFINITY), (limited, false, 0.06)] {
            let mut of_all = Vec::new();
            for (tile_vertices, threads) in [(8, 1), (60, 2), (5000, 1)] {
                let scratch = build(&points, &z, &obstacle(), tile_vertices, threads).await;
                let reader = scratch.open().await;
                let counted = triangles(&reader, holes, longest).await;
                let mut profiles = Vec::new();
                for line in &lines {
                    let profile = reader.profile(line, surface).await.unwrap();
                    if tile_vertices == 60 {
                        check(&profile, line, &counted);
                    }
                    crossings += profile.parts.iter().map(|part| part.points.len()).sum::<usize>();
                    gaps += profile.gaps().len();
                    profiles.push(profile);
                }
                of_all.push(profiles);
            }
            let bits = |profiles: &[Profile]| -> Vec<[u64; 4]> {
                let points = profiles
                    .iter()
                    .flat_map(|profile| &profile.parts)
                    .flat_map(|part| &part.points);
                points
                    .map(|p| [p.distance, p.point.x, p.point.y, p.z].map(f64::to_bits))
                    .collect()
            };
            for profiles in &of_all {
                assert_eq!(profiles, &of_all[0]);
                assert_eq!(bits(profiles), bits(&of_all[0]));
            }
        }
        assert!(crossings > 2000 && gaps > 50, "{crossings} {gaps}");
    });
}

/// A square grid of 50 by 50 points whose z is x + 2 y.
async fn slope(tile_vertices: usize) -> (crate::support::Scratch, TileReader) {
    let points: Vec<Point> = (0..2500)
        .map(|i| Point::new(f64::from(i % 50), f64::from(i / 50)))
        .collect();
    let z: Vec<f64> = points.iter().map(|p| p.x + 2.0 * p.y).collect();
    let scratch = build(&points, &z, &SegmentBatch::default(), tile_vertices, 2).await;
    let reader = scratch.open().await;
    (scratch, reader)
}

#[test]
fn lines_along_edges_and_through_vertices_have_no_point_twice() {
    runtime().block_on(async {
        let (_scratch, reader) = slope(30).await;
        let profile = async |corners: &[(f64, f64)]| {
            let line: Vec<Point> = corners.iter().map(|&(x, y)| Point::new(x, y)).collect();
            reader.profile(&line, Surface::default()).await.unwrap()
        };
        // Along a row of vertices, then up a column, and back on it.
        let rows = profile(&[(0.5, 7.0), (10.0, 7.0), (10.0, 9.5), (10.0, 7.0)]).await;
        let points = &rows.parts[0].points;
        let expected: Vec<(f64, f64)> = std::iter::once((0.5, 7.0))
            .chain((1..=10).map(|x| (f64::from(x), 7.0)))
            .chain([
                (10.0, 8.0),
                (10.0, 9.0),
                (10.0, 9.5),
                (10.0, 9.0),
                (10.0, 8.0),
                (10.0, 7.0),
            ])
            .collect();
        assert_eq!(
            points.iter().map(|p| (p.point.x, p.point.y)).collect::<Vec<_>>(),
            expected
        );
        assert!(points.iter().all(|p| p.z == p.point.x + 2.0 * p.point.y));
        assert_eq!((rows.parts.len(), rows.gaps()), (1, vec![]));
        // Through vertices, across diagonals in one of the two directions.
        let diagonal = profile(&[(3.0, 3.0), (6.0, 6.0)]).await;
        let heights: Vec<f64> = diagonal.parts[0].points.iter().map(|p| p.z).collect();
        let full = vec![9.0, 12.0, 15.0, 18.0];
        let half = vec![9.0, 10.5, 12.0, 13.5, 15.0, 16.5, 18.0];
        assert!(heights == full || heights == half, "{heights:?}");
        // Along the hull, touching it at a corner, and outside.
        let hull = profile(&[(-1.0, 49.0), (50.0, 49.0)]).await;
        assert_eq!(
            (hull.parts[0].points.len(), hull.gaps()),
            (50, vec![[0.0, 1.0], [50.0, 51.0]])
        );
        let touching = profile(&[(-1.0, 1.0), (1.0, -1.0)]).await;
        assert_eq!((touching.parts.len(), touching.parts[0].points.len()), (1, 1));
        assert_eq!((touching.parts[0].points[0].z, touching.gaps().len()), (0.0, 2));
        let outside = profile(&[(-1.0, 1.0), (-1.0, -1.0)]).await;
        assert_eq!((outside.parts.len(), outside.gaps()), (0, vec![[0.0, 2.0]]));
    });
}

#[test]
fn only_the_tiles_that_the_line_meets_are_read() {
    runtime().block_on(async {
        let (scratch, reader) = slope(30).await;
        let directory = reader.directory().await.unwrap();
        for line in [
            [(3.3, 4.4), (45.0, 6.1)],
            [(12.5, -3.0), (12.5, 70.0)],
            [(60.0, 1.0), (70.0, 2.0)],
        ] {
            let line = line.map(|(x, y)| Point::new(x, y));
            let meets = |bounds: Rect| {
                let beside = |t: f64| {
                    Point::new(
                        line[0].x + t * (line[1].x - line[0].x),
                        line[0].y + t * (line[1].y - line[0].y),
                    )
                };
                (0..=10_000).any(|i| bounds.contains(beside(f64::from(i) / 10_000.0)))
            };
            let expected = directory.tiles.iter().filter(|tile| meets(tile.bounds)).count();
            let reader = TileReader::open(&scratch.path, OpenOptions::default()).await.unwrap();
            reader.profile(&line, Surface::default()).await.unwrap();
            let read = reader.cache().statistics().misses as usize;
            assert_eq!(read, expected, "{line:?}");
            assert!(read < directory.tiles.len() / 2);
        }
    });
}

#[test]
fn bad_lines_and_files_without_z_are_errors() {
    runtime().block_on(async {
        let (_scratch, reader) = slope(100).await;
        let p = Point::new(3.0, 4.0);
        for line in [
            vec![],
            vec![p],
            vec![p, p],
            vec![p, Point::new(f64::NAN, 1.0)],
            vec![p, Point::new(1e300, 1.0)],
        ] {
            let error = reader.profile(&line, Surface::default()).await.unwrap_err();
            assert!(matches!(error, TerrainError::Line { .. }), "{error}");
        }
        let (_flat, flat) = built(
            &[p, Point::new(5.0, 5.0), Point::new(1.0, 9.0)],
            BuildOptions::default(),
        )
        .await;
        let error = flat
            .profile(&[p, Point::new(5.0, 5.0)], Surface::default())
            .await
            .unwrap_err();
        assert!(matches!(error, TerrainError::NoZ { .. }), "{error}");
    });
}
