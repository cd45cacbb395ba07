//! Heights at points, against a direct computation and against rasters.

use super::rasters::{build, grid, obstacle, terrain, triangles, whole};
use crate::support::{Scratch, batches, build_batches, runtime};
use delaunay_tiles::BuildOptions;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::query::Location;
use delaunay_tiles::terrain::{RasterOptions, Surface};

/// Returns points in all places: in triangles, on vertices, on edges, outside, in and around the hole.
fn targets(points: &[Point]) -> Vec<Point> {
    let grid = grid();
    let centres = (0..grid.columns()).flat_map(|column| (0..grid.rows()).map(move |row| grid.centre(column, row)));
    let sides = [
        [(0.25, 0.25), (0.625, 0.375)],
        [(0.625, 0.375), (0.375, 0.75)],
        [(0.375, 0.75), (0.25, 0.25)],
    ];
    let on_sides = sides.iter().flat_map(|[a, b]| {
        (0..=8)
            .map(|i| f64::from(i) / 8.0)
            .map(|t| Point::new(a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1)))
    });
    let inside = [(0.4, 0.4), (0.375, 0.5)].map(|(x, y)| Point::new(x, y));
    centres
        .chain(points.iter().copied().step_by(7))
        .chain(on_sides)
        .chain(inside)
        .collect()
}

#[test]
fn a_height_is_that_of_a_triangle_that_counts_whatever_the_tiles() {
    let (points, z) = terrain(5);
    let targets = targets(&points);
    runtime().block_on(async {
        let mut in_hole = 0;
        for surface in [
            Surface::default(),
            Surface::default().holes(true),
            Surface::default().max_edge(Some(0.05)),
        ] {
            let has_holes = surface == Surface::default().holes(true);
            let longest = if surface == Surface::default().max_edge(Some(0.05)) {
                0.05
            } else {
                f64::INFINITY
            };
            let mut of_all = Vec::new();
            for (tile_vertices, threads) in [(8, 1), (60, 2), (5000, 1)] {
                let scratch = build(&points, &z, &obstacle(), tile_vertices, threads).await;
                let reader = scratch.open().await;
                let counted = triangles(&reader, has_holes, longest).await;
                let mut found = Vec::new();
                for &p in &targets {
                    let height = reader.surface_z(p.x, p.y, surface).await.unwrap();
                    let mut expected = counted
                        .iter()
                        .filter(|triangle| triangle.contains(p))
                        .map(|t| t.z_at(p));
                    match (height, expected.next()) {
                        (Some(height), Some(expected)) => assert!((height - expected).abs() < 1e-9, "{p:?}"),
                        (height, expected) => assert_eq!(height, expected, "{p:?}"),
                    }
                    if surface == Surface::default() {
                        assert_eq!(reader.z_at(p.x, p.y).await.unwrap(), height);
                    }
                    in_hole += usize::from(
                        height.is_none() && !matches!(reader.locate(p.x, p.y).await.unwrap(), Location::Outside),
                    );
                    found.push(height.map(f64::to_bits));
                }
                of_all.push(found);
            }
            assert!(of_all.iter().all(|found| *found == of_all[0]), "{surface:?}");
        }
        assert!(in_hole > 50, "{in_hole}");
    });
}

#[test]
fn a_raster_has_the_same_bits_at_the_same_point() {
    let (points, z) = terrain(6);
    runtime().block_on(async {
        let scratch = build(&points, &z, &obstacle(), 30, 2).await;
        let reader = scratch.open().await;
        let grid = grid();
        let cells = whole(&reader, &RasterOptions::new(grid)).await;
        let (mut inside, mut outside) = (0, 0);
        for (cell, i) in cells.iter().zip(0u32..) {
            let p = grid.centre(i % grid.columns(), i / grid.columns());
            let height = reader.z_at(p.x, p.y).await.unwrap();
            assert_eq!(height.unwrap_or(f64::NAN).to_bits(), cell.to_bits(), "{p:?}");
            *(if height.is_some() { &mut inside } else { &mut outside }) += 1;
        }
        assert!(inside > 1000 && outside > 100, "{inside} {outside}");
    });
}

#[test]
fn the_points_of_a_dem_have_their_heights() {
    let points: Vec<Point> = (0..2500)
        .map(|i| Point::new(500_000.0 + 0.1 * f64::from(i % 50), 0.3 * f64::from(i / 50)))
        .collect();
    let z: Vec<f64> = (0..2500).map(|i| (f64::from(i) * 1.7).sin() * 1000.0).collect();
    runtime().block_on(async {
        for tile_vertices in [8, 1000] {
            let scratch = build(&points, &z, &SegmentBatch::default(), tile_vertices, 2).await;
            let reader = scratch.open().await;
            for (p, &z) in points.iter().zip(&z) {
                assert_eq!(reader.z_at(p.x, p.y).await.unwrap(), Some(z), "{p:?}");
            }
        }
    });
}

#[test]
fn collinear_points_are_the_surface_of_a_file_without_triangles() {
    let points: Vec<Point> = (0..40).map(|i| Point::new(f64::from(i), f64::from(2 * i))).collect();
    let z: Vec<f64> = (0..40).map(f64::from).collect();
    runtime().block_on(async {
        let scratch = Scratch::new();
        let options = BuildOptions::default().tile_vertices(8);
        build_batches(&scratch.path, &batches(&points, &z), options)
            .await
            .unwrap();
        let reader = scratch.open().await;
        assert_eq!(reader.z_at(7.0, 14.0).await.unwrap(), Some(7.0));
        assert_eq!(reader.z_at(7.5, 15.0).await.unwrap(), None);
    });
}
