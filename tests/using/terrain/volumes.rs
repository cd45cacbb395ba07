//! Volumes, against closed forms and against sums over all triangles.

use std::sync::Arc;

use super::rasters::{Triangle, build, obstacle, terrain, triangles};
use crate::support::{Scratch, built, runtime};
use delaunay_tiles::BuildOptions;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::store::{OpenOptions, TileReader};
use delaunay_tiles::terrain::{Clip, Surface, TerrainError, Volume};

fn ring(corners: &[(f64, f64)]) -> Vec<[Point; 2]> {
    let corner = |i: usize| Point::new(corners[i % corners.len()].0, corners[i % corners.len()].1);
    (0..corners.len()).map(|i| [corner(i), corner(i + 1)]).collect()
}

fn square(x: f64, y: f64, size: f64) -> Vec<[Point; 2]> {
    ring(&[(x, y), (x + size, y), (x + size, y + size), (x, y + size)])
}

fn turned(ring: Vec<[Point; 2]>) -> Vec<[Point; 2]> {
    ring.into_iter().map(|[a, b]| [b, a]).collect()
}

async fn volume(reader: &TileReader, level: f64, polygons: Option<Vec<[Point; 2]>>) -> Volume {
    let clip = polygons.map(|edges| Arc::new(Clip::new(edges)));
    reader.volume(level, Surface::default(), clip).await.unwrap()
}

#[track_caller]
fn assert_close(found: f64, expected: f64, what: &str) {
    let error = (found - expected).abs();
    assert!(
        error <= 1e-9 * expected.abs().max(1e-3),
        "{what}: {found}, not {expected}"
    );
}

fn bits(volume: Volume) -> [u64; 5] {
    let Volume {
        cut,
        fill,
        area,
        area_above,
        area_below,
        ..
    } = volume;
    [cut, fill, area, area_above, area_below].map(f64::to_bits)
}

async fn surface_of(points: &[Point], height: impl Fn(Point) -> f64, tile_vertices: usize) -> (Scratch, TileReader) {
    let z: Vec<f64> = points.iter().map(|&p| height(p)).collect();
    let scratch = build(points, &z, &SegmentBatch::default(), tile_vertices, 2).await;
    let reader = scratch.open().await;
    (scratch, reader)
}

/// A square grid of points from 0 to `last`, moved by `far`.
fn grid(last: u32, far: f64) -> Vec<Point> {
    let count = last + 1;
    let at = |i: u32| Point::new(far + f64::from(i % count), far + f64::from(i / count));
    (0..count * count).map(at).collect()
}

#[test]
fn a_slope_has_its_wedges_also_in_polygons() {
    runtime().block_on(async {
        for (tile_vertices, far) in [(8, 0.0), (100, 4_000_000.0)] {
            let height = |p: Point| p.x - far;
            let (_scratch, reader) = surface_of(&grid(20, far), height, tile_vertices).await;
            let whole = volume(&reader, 5.0, None).await;
            assert_close(whole.cut, 20.0 * 15.0 * 15.0 / 2.0, "cut");
            assert_close(whole.fill, 20.0 * 5.0 * 5.0 / 2.0, "fill");
            assert_close(whole.area_above, 300.0, "above");
            assert_close(whole.area_below, 100.0, "below");
            assert_close(whole.area, 400.0, "area");
            let moved = |edges: Vec<[Point; 2]>| -> Vec<[Point; 2]> {
                edges
                    .into_iter()
                    .map(|ends| ends.map(|p| Point::new(p.x + far, p.y + far)))
                    .collect()
            };
            let hollow = [square(2.0, 3.0, 10.0), turned(square(5.5, 5.5, 3.0))].concat();
            // The mean height of a region, times its area, is the difference of cut and fill.
            for (edges, area, mean, what) in [
                (square(2.25, 3.125, 0.5), 0.25, 2.5, "in one cell"),
                (square(6.0, 6.0, 4.0), 16.0, 8.0, "along edges"),
                (square(-50.0, -50.0, 900.0), 400.0, 10.0, "all"),
                (square(10.0, -50.0, 900.0), 200.0, 15.0, "half"),
                (hollow, 91.0, 7.0, "with a hole"),
                (square(30.0, 1.0, 3.0), 0.0, 0.0, "beside"),
                (
                    [square(1.0, 1.0, 2.0), square(2.0, 2.0, 2.0)].concat(),
                    7.0,
                    (8.0 + 12.0 - 2.5) / 7.0,
                    "overlapping",
                ),
                (
                    ring(&[(0.0, 0.0), (20.0, 0.0), (0.0, 20.0)]),
                    200.0,
                    20.0 / 3.0,
                    "a triangle",
                ),
            ] {
                let found = volume(&reader, 5.0, Some(moved(edges.clone()))).await;
                assert_close(found.area, area, what);
                assert_close(found.cut - found.fill, area * (mean - 5.0), what);
                assert_close(found.area_above + found.area_below, area, what);
                let deep = volume(&reader, -1.0, Some(moved(edges))).await;
                assert_close(deep.cut, area * (mean + 1.0), what);
                assert_eq!(deep.fill, 0.0, "{what}");
            }
            // The part of a polygon on either side of the level.
            let across = volume(&reader, 5.0, Some(moved(square(4.0, 3.3, 3.0)))).await;
            assert_close(across.cut, 3.0 * 2.0 * 2.0 / 2.0, "cut across");
            assert_close(across.fill, 3.0 * 1.0 / 2.0, "fill across");
        }
    });
}

#[test]
fn a_pyramid_and_a_cone_have_their_volumes() {
    runtime().block_on(async {
        // The corners of a square, and the top.
        let square = [(0.0, 0.0), (6.0, 0.0), (6.0, 6.0), (0.0, 6.0), (3.0, 3.0)].map(|(x, y)| Point::new(x, y));
        let (_pyramid, reader) = surface_of(&square, |p| if p.x == 3.0 { 9.0 } else { 0.0 }, 8).await;
        for (level, share) in [(0.0, 1.0), (3.0, 2.0 / 3.0), (8.0, 1.0 / 9.0)] {
            let found = volume(&reader, level, None).await;
            let whole = 36.0 * 9.0 / 3.0;
            let cut = whole * f64::powi(share, 3);
            assert_close(found.cut, cut, "cut");
            assert_close(found.fill, cut + 36.0 * level - whole, "fill");
            assert_close(found.area_above, 36.0 * share * share, "above");
        }
        let above = volume(&reader, 100.0, None).await;
        assert_eq!((above.cut, above.area_above), (0.0, 0.0));
        assert_close(above.fill, 36.0 * 100.0 - 108.0, "fill");
        // A cone of many sides: a polygon of n corners, and the top.
        let sides = 360;
        let corner = |i: u32| f64::from(i) / f64::from(sides) * std::f64::consts::TAU;
        let mut points: Vec<Point> = (0..sides)
            .map(|i| Point::new(corner(i).cos(), corner(i).sin()))
            .collect();
        points.push(Point::new(0.0, 0.0));
        let (_cone, reader) = surface_of(&points, |p| if p == Point::new(0.0, 0.0) { 2.0 } else { 0.0 }, 8).await;
        let base: f64 = (0..sides as usize)
            .map(|i| {
                let (p, q) = (points[i], points[(i + 1) % sides as usize]);
                (p.x * q.y - p.y * q.x) / 2.0
            })
            .sum();
        let found = volume(&reader, 0.0, None).await;
        assert_close(found.cut, base * 2.0 / 3.0, "cone");
        assert_close(volume(&reader, 1.0, None).await.cut, base / 12.0, "its tip");
    });
}

#[test]
fn what_is_in_the_plane_is_neither_above_nor_below() {
    runtime().block_on(async {
        let (_scratch, reader) = surface_of(&grid(10, 0.0), |p| (p.x - 4.0).max(0.0), 20).await;
        let found = volume(&reader, 0.0, None).await;
        assert_close(found.area, 100.0, "area");
        assert_close(found.area_above, 60.0, "above");
        assert_eq!((found.area_below, found.fill), (0.0, 0.0));
    });
}

/// Returns the sums over all triangles, by subdividing those that the level cuts.
fn direct(counted: &[Triangle], level: f64) -> [f64; 2] {
    fn add(triangle: &Triangle, level: f64, depth: u32, sums: &mut [f64; 2]) {
        let heights = triangle.z.map(|z| z - level);
        let [a, b, c] = triangle.corners;
        let volume = Triangle::area(a, b, c) / 2.0 * heights.iter().sum::<f64>() / 3.0;
        if heights.iter().all(|&h| h >= 0.0) {
            sums[0] += volume;
        } else if heights.iter().all(|&h| h <= 0.0) {
            sums[1] -= volume;
        } else if depth == 0 {
            sums[usize::from(volume < 0.0)] += volume.abs();
        } else {
            let middle = |i: usize, j: usize| {
                let (p, q) = (triangle.corners[i], triangle.corners[j]);
                (
                    Point::new((p.x + q.x) / 2.0, (p.y + q.y) / 2.0),
                    (triangle.z[i] + triangle.z[j]) / 2.0,
                )
            };
            let corner = |i: usize| (triangle.corners[i], triangle.z[i]);
            let [ab, bc, ca] = [middle(0, 1), middle(1, 2), middle(2, 0)];
            for parts in [
                [corner(0), ab, ca],
                [ab, corner(1), bc],
                [ca, bc, corner(2)],
                [ab, bc, ca],
            ] {
                let part = Triangle {
                    corners: parts.map(|(p, _)| p),
                    z: parts.map(|(_, z)| z),
                };
                add(&part, level, depth - 1, sums);
            }
        }
    }
    let mut sums = [0.0; 2];
    counted.iter().for_each(|triangle| add(triangle, level, 6, &mut sums));
    sums
}

#[test]
fn volumes_are_those_of_all_triangles_and_do_not_depend_on_the_tiles() {
    let (points, z) = terrain(9);
    let polygons = [
        ring(&[(0.1, 0.1), (0.93, 0.2), (0.7, 0.95), (0.5, 0.3), (0.2, 0.8)]),
        ring(&[(0.6, 0.1), (0.9, 0.1), (0.75, 1.4)]),
        turned(square(0.7125, 0.2, 0.1)),
    ]
    .concat();
    runtime().block_on(async {
        let mut of_all = Vec::new();
        for (tile_vertices, threads, memory) in
            [(8, 1, 1 << 30), (60, 2, 1 << 20), (60, 2, 1 << 30), (5000, 1, 1 << 30)]
        {
            let scratch = build(&points, &z, &obstacle(), tile_vertices, threads).await;
            let options = OpenOptions::default().memory(memory);
            let reader = TileReader::open(&scratch.path, options).await.unwrap();
            for surface in [
                Surface::default(),
                Surface::default().holes(true),
                Surface::default().max_edge(Some(0.06)),
            ] {
                for clip in [None, Some(Arc::new(Clip::new(polygons.clone())))] {
                    of_all.push(bits(reader.volume(0.5, surface, clip).await.unwrap()));
                }
            }
            if tile_vertices == 60 {
                let counted = triangles(&reader, false, f64::INFINITY).await;
                let [cut, fill] = direct(&counted, 0.5);
                let found = volume(&reader, 0.5, None).await;
                assert!((found.cut - cut).abs() < 1e-3 * cut && (found.fill - fill).abs() < 1e-3 * fill);
                assert_close(found.cut - found.fill, cut - fill, "cut and fill");
                let area: f64 = counted
                    .iter()
                    .map(|t| Triangle::area(t.corners[0], t.corners[1], t.corners[2]) / 2.0)
                    .sum();
                assert_close(found.area, area, "area");
            }
        }
        for run in of_all.chunks(6) {
            assert_eq!(run, &of_all[..6]);
        }
        assert!(
            (0..6).all(|i| (0..i).all(|j| of_all[i] != of_all[j])),
            "all of them differ"
        );
    });
}

/// The parts of the plane that a polygon and its complement cover add up.
#[test]
fn a_polygon_and_the_rest_add_up() {
    let (points, z) = terrain(10);
    runtime().block_on(async {
        let scratch = build(&points, &z, &obstacle(), 60, 2).await;
        let reader = scratch.open().await;
        let star: Vec<(f64, f64)> = (0..40u32)
            .map(|i| {
                let (angle, radius) = (
                    f64::from(i) / 40.0 * std::f64::consts::TAU,
                    [0.45, 0.11][i as usize % 2],
                );
                (0.5 + radius * angle.cos(), 0.5 + radius * angle.sin())
            })
            .collect();
        let whole = volume(&reader, 0.3, None).await;
        let inside = volume(&reader, 0.3, Some(ring(&star))).await;
        let outside = volume(
            &reader,
            0.3,
            Some([square(-9.0, -9.0, 20.0), turned(ring(&star))].concat()),
        )
        .await;
        assert!(inside.area > 0.05 && outside.area > 0.5, "{inside:?} {outside:?}");
        assert_close(inside.cut + outside.cut, whole.cut, "cut");
        assert_close(inside.fill + outside.fill, whole.fill, "fill");
        assert_close(inside.area + outside.area, whole.area, "area");
        assert_close(inside.area_above + outside.area_above, whole.area_above, "above");
    });
}

#[test]
fn files_without_z_and_infinite_volumes_are_errors() {
    runtime().block_on(async {
        let corners = [Point::new(0.0, 0.0), Point::new(8.0, 0.0), Point::new(0.0, 8.0)];
        let (_flat, flat) = built(&corners, BuildOptions::default()).await;
        let error = flat.volume(0.0, Surface::default(), None).await.unwrap_err();
        assert!(matches!(error, TerrainError::NoZ { .. }), "{error}");
        let (_high, high) = surface_of(&corners, |_| 1e308, 8).await;
        let error = high.volume(0.0, Surface::default(), None).await.unwrap_err();
        assert!(matches!(error, TerrainError::TooLarge { .. }), "{error}");
    });
}
