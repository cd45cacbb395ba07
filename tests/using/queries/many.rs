//! `locate_many` and `surface_z_many` against `locate` and `surface_z`, point by point.

use std::collections::HashMap;
use std::time::Duration;

use super::{Whole, named, options};
use crate::support::{Random, Scratch, batches, build_batches, built, points_of, runtime};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::query::{BulkOptions, Location, Place};
use delaunay_tiles::store::{Cache, LineKind, OpenOptions, TileReader};
use delaunay_tiles::terrain::Surface;
use delaunay_tiles::{BuildOptions, Builder};
use distributions::Kind;

fn threads(threads: usize) -> BulkOptions {
    BulkOptions::default().threads(threads)
}

/// Compares the places of points with their locations, and with the places in other orders and batches.
async fn check(reader: &TileReader, targets: &[Point], random: &mut Random) {
    let places = reader.locate_many(targets, BulkOptions::default()).await.unwrap();
    assert_eq!(places.len(), targets.len());
    for (p, place) in targets.iter().zip(&places) {
        let expected = reader.locate(p.x, p.y).await.unwrap();
        check_place(reader, *p, place, expected).await;
    }
    for count in [1, 2, 4] {
        let mut order: Vec<usize> = (0..targets.len()).collect();
        random.shuffle(&mut order);
        for part in order.chunks(targets.len().div_ceil(count).max(1)) {
            let shuffled: Vec<Point> = part.iter().map(|&i| targets[i]).collect();
            let again = reader.locate_many(shuffled, threads(count)).await.unwrap();
            let expected: Vec<Place> = part.iter().map(|&i| places[i]).collect();
            assert_eq!(again, expected);
        }
    }
    for (p, place) in targets.iter().zip(&places).step_by(17) {
        assert_eq!(reader.locate_many([*p], threads(1)).await.unwrap(), [*place], "{p:?}");
    }
}

async fn check_place(reader: &TileReader, p: Point, place: &Place, expected: Location) {
    let Some(id) = place.tile() else {
        assert_eq!((*place, expected), (Place::Outside, Location::Outside), "{p:?}");
        return;
    };
    let tile = reader.tile(id).await.unwrap();
    if let Some(triangle) = place.triangle() {
        assert!(triangle.0 < tile.triangle_count());
    }
    match (place.location(&tile), expected) {
        (Location::InTriangle(a), Location::InTriangle(b)) => {
            assert_eq!(named(&a.vertices), named(&b.vertices), "{p:?}");
            assert_eq!(Some(a.triangle), place.triangle());
        }
        (Location::OnEdge { ends: a, triangle }, Location::OnEdge { ends: b, .. }) => {
            let sorted = |mut ends: [delaunay_tiles::store::Vertex; 2]| {
                ends.sort_unstable_by_key(|end| end.id);
                ends
            };
            assert_eq!(sorted(a), sorted(b), "{p:?}");
            assert!((0..3).any(|i| [triangle.vertices[i], triangle.vertices[(i + 1) % 3]] == a));
        }
        (Location::OnVertex(a), Location::OnVertex(b)) => {
            assert_eq!((a, a.id.tile), (b, id), "{p:?}");
            let has_triangles = reader.metadata().triangles > 0;
            assert_eq!(place.triangle().is_some(), has_triangles, "{p:?}");
            let corners = place.triangle().map(|triangle| tile.vertices(triangle));
            assert!(corners.is_none_or(|corners| corners.contains(&a)), "{p:?}");
        }
        (found, expected) => panic!("{p:?}: {found:?} and {expected:?}"),
    }
}

#[test]
fn places_are_the_locations_whatever_the_order_and_the_threads() {
    let runtime = runtime();
    let mut kinds = HashMap::new();
    for (kind, seed) in Kind::ALL.into_iter().zip(0u64..) {
        let points = points_of(kind, 300, seed);
        for tile_vertices in [4, 64, 65536] {
            println!("{kind}, tiles of {tile_vertices}");
            runtime.block_on(async {
                let (_scratch, reader) = built(&points, options(tile_vertices)).await;
                let whole = Whole::read(&reader).await;
                let mut random = Random(seed);
                let targets = whole.targets(&mut random, 60);
                check(&reader, &targets, &mut random).await;
                for place in reader.locate_many(targets, threads(2)).await.unwrap() {
                    *kinds.entry(std::mem::discriminant(&place)).or_insert(0) += 1;
                }
            });
        }
    }
    assert!(
        kinds.len() == 4 && kinds.values().all(|&count| count > 200),
        "{kinds:?}"
    );
}

#[test]
fn places_on_the_edges_and_vertices_of_a_grid_do_not_depend_on_the_batch() {
    let points: Vec<Point> = (0..144)
        .map(|i| Point::new(f64::from(i % 12), f64::from(i / 12)))
        .collect();
    let steps = (-2..26).flat_map(|i| (-2..26).map(move |j| Point::new(f64::from(i) / 2.0, f64::from(j) / 2.0)));
    let targets: Vec<Point> = steps.collect();
    for tile_vertices in [4, 8, 64, 65536] {
        runtime().block_on(async {
            let (_scratch, reader) = built(&points, options(tile_vertices)).await;
            check(&reader, &targets, &mut Random(tile_vertices as u64)).await;
        });
    }
}

#[test]
fn files_without_triangles_have_places_only_on_vertices() {
    let line: Vec<Point> = (0..40).map(|i| Point::new(f64::from(i), f64::from(-2 * i))).collect();
    let triangle = [(0.0, 0.0), (4.0, 0.0), (0.0, 4.0)].map(|(x, y)| Point::new(x, y));
    let files = [&line[..0], &line[..1], &line[..2], &line[..], &triangle[..]];
    for points in files {
        runtime().block_on(async {
            let (_scratch, reader) = built(points, options(8)).await;
            let targets = (-3..90).map(|i| Point::new(f64::from(i) / 2.0, f64::from(-i)));
            let targets: Vec<Point> = targets.chain([Point::new(1.0, 1.0), Point::new(2.0, 2.0)]).collect();
            check(&reader, &targets, &mut Random(1)).await;
            assert!(reader.locate_many([], threads(2)).await.unwrap().is_empty());
        });
    }
}

/// A ring of points round a wide lake: in the lake, few cells have a vertex of the triangle at a point.
#[test]
fn places_in_triangles_that_span_many_cells_are_found() {
    let mut random = Random(7);
    let ring = (0..900).map(|_| {
        let (angle, radius) = (std::f64::consts::TAU * random.unit(), 0.8 + 0.2 * random.unit());
        Point::new(radius * angle.cos(), radius * angle.sin())
    });
    let mut points: Vec<Point> = ring.collect();
    points.extend([Point::new(0.25, 0.0), Point::new(-0.25, 0.0)]);
    let mut targets: Vec<Point> = (0..400)
        .map(|_| Point::new(2.4 * random.unit() - 1.2, 2.4 * random.unit() - 1.2))
        .collect();
    // On an edge that crosses cells in which it has no end.
    targets.extend((-20..20).map(|i| Point::new(f64::from(i) / 64.0, 0.0)));
    for tile_vertices in [4, 16, 100] {
        runtime().block_on(async {
            let (_scratch, reader) = built(&points, options(tile_vertices)).await;
            check(&reader, &targets, &mut random).await;
        });
    }
}

/// Builds a file with an obstacle and a wall, and with z.
async fn town(points: &[Point], tile_vertices: usize, has_z: bool) -> Scratch {
    let scratch = Scratch::new();
    let mut builder = Builder::new(&scratch.path, options(tile_vertices)).unwrap();
    let corners = [(3.0, 2.0), (8.5, 4.0), (4.0, 9.5)].map(|(x, y)| Point::new(x, y));
    let ends: Vec<_> = (0..3).map(|i| [corners[i], corners[(i + 1) % 3]]).collect();
    let house = SegmentBatch {
        z: if has_z { vec![[2.0; 2]; 3] } else { Vec::new() },
        lines: vec![0; 3],
        ends,
        ..SegmentBatch::default()
    };
    builder.push_lines(LineKind::Obstacle, 0, &house).unwrap();
    let z: Vec<f64> = points.iter().map(|p| (p.x * 0.7).sin() + p.y * 0.3).collect();
    for batch in batches(points, if has_z { &z } else { &[] }) {
        builder.push(&batch).await.unwrap();
    }
    builder.finish().await.unwrap();
    scratch
}

/// Returns points of a half-step grid with noise, so that many targets lie on vertices and edges.
fn town_points(random: &mut Random) -> Vec<Point> {
    let grid = (0..169).map(|i| Point::new(f64::from(i % 13), f64::from(i / 13)));
    let mut points: Vec<Point> = grid.collect();
    points.extend((0..200).map(|_| Point::new(12.0 * random.unit(), 12.0 * random.unit())));
    points
}

#[test]
fn heights_have_the_bits_of_single_heights() {
    let mut random = Random(11);
    let points = town_points(&mut random);
    let mut targets: Vec<Point> = (-2..28)
        .flat_map(|i| (-2..28).map(move |j| Point::new(f64::from(i) / 2.0, f64::from(j) / 2.0)))
        .collect();
    targets.extend((0..300).map(|_| Point::new(14.0 * random.unit() - 1.0, 14.0 * random.unit() - 1.0)));
    targets.extend(points.iter().step_by(3));
    targets.extend(
        (0..=16)
            .map(|i| f64::from(i) / 16.0)
            .map(|t| Point::new(3.0 + 5.5 * t, 2.0 + 2.0 * t)),
    );
    targets.extend([(f64::NAN, 1.0), (1.0, f64::INFINITY), (1e-300, 3.0)].map(|(x, y)| Point::new(x, y)));
    let surfaces = [
        Surface::default(),
        Surface::default().holes(true),
        Surface::default().max_edge(Some(1.2)),
        Surface::default().max_edge(Some(1.2)).from_hull(true),
        Surface::default().holes(true).max_edge(Some(0.9)).from_hull(true),
        Surface::default().max_edge(Some(1e9)).from_hull(true),
    ];
    for tile_vertices in [4, 30, 65536] {
        runtime().block_on(async {
            let scratch = town(&points, tile_vertices, true).await;
            let reader = scratch.open().await;
            for surface in surfaces {
                let mut expected = Vec::new();
                for p in &targets {
                    expected.push(reader.surface_z(p.x, p.y, surface).await.unwrap().unwrap_or(f64::NAN));
                }
                let bits = |z: &[f64]| z.iter().map(|z| z.to_bits()).collect::<Vec<_>>();
                for count in [1, 2, 4] {
                    let found = reader
                        .surface_z_many(&targets[..], surface, threads(count))
                        .await
                        .unwrap();
                    assert_eq!(bits(&found), bits(&expected), "{surface:?}, tiles of {tile_vertices}");
                }
            }
            check(&reader, &targets, &mut random).await;
        });
    }
}

#[test]
fn files_without_z_have_no_heights_and_lone_vertices_have_theirs() {
    runtime().block_on(async {
        let scratch = town(&town_points(&mut Random(2)), 30, false).await;
        let reader = scratch.open().await;
        let targets = [Point::new(1.25, 1.5), Point::new(99.0, 0.0)];
        let z = reader
            .surface_z_many(targets, Surface::default(), threads(2))
            .await
            .unwrap();
        assert!(z.len() == 2 && z.iter().all(|z| z.is_nan()));

        let line: Vec<Point> = (0..40).map(|i| Point::new(f64::from(i), f64::from(i))).collect();
        let heights: Vec<f64> = (0..40).map(f64::from).collect();
        let scratch = Scratch::new();
        let options = BuildOptions::default().tile_vertices(8);
        build_batches(&scratch.path, &batches(&line, &heights), options)
            .await
            .unwrap();
        let reader = scratch.open().await;
        let targets: Vec<Point> = (0..80)
            .map(|i| Point::new(f64::from(i) / 2.0, f64::from(i) / 2.0))
            .collect();
        let surface = Surface::default().max_edge(Some(0.5)).from_hull(true);
        let z = reader.surface_z_many(targets, surface, threads(2)).await.unwrap();
        for (z, i) in z.iter().zip(0..) {
            assert!(if i % 2 == 0 { *z == f64::from(i / 2) } else { z.is_nan() }, "{i}");
        }
    });
}

#[test]
fn many_points_are_placed_with_a_tiny_cache_and_after_calls_that_were_dropped() {
    let points = points_of(Kind::Clusters, 3000, 3);
    runtime().block_on(async {
        let scratch = Scratch::new();
        build_batches(&scratch.path, &batches(&points, &[]), options(32))
            .await
            .unwrap();
        let expected_reader = scratch.open().await;
        let targets = Whole::read(&expected_reader).await.targets(&mut Random(4), 3000);
        let expected = expected_reader.locate_many(&targets[..], threads(1)).await.unwrap();
        let cache = Cache::new(20_000);
        let reader = TileReader::open(&scratch.path, OpenOptions::default().cache(&cache))
            .await
            .unwrap();
        for microseconds in [0, 50, 500, 2000, 5000, 20_000] {
            let patience = Duration::from_micros(microseconds);
            let call = reader.locate_many(&targets[..], threads(2));
            if let Ok(places) = tokio::time::timeout(patience, call).await {
                assert_eq!(places.unwrap(), expected);
            }
        }
        assert_eq!(reader.locate_many(&targets[..], threads(4)).await.unwrap(), expected);
    });
}

#[test]
fn a_damaged_tile_is_an_error_of_the_batch() {
    runtime().block_on(async {
        let (scratch, reader) = built(&points_of(Kind::Uniform, 500, 1), options(64)).await;
        let entry = reader.directory().await.unwrap().tiles[2];
        drop(reader);
        let mut bytes = std::fs::read(&scratch.path).unwrap();
        bytes[entry.core.offset as usize + 40] ^= 1;
        std::fs::write(&scratch.path, bytes).unwrap();
        let reader = scratch.open().await;
        let targets = points_of(Kind::Uniform, 1000, 2);
        let error = reader.locate_many(targets, threads(2)).await.unwrap_err();
        assert!(error.to_string().contains("tile 2"), "{error}");
    });
}
