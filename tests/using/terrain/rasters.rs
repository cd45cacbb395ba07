//! Rasters, against a direct computation from all triangles.

use std::ops::Range;
use std::sync::Arc;

use crate::support::{Random, Scratch, batches, points_of, runtime};
use delaunay_tiles::export::{ExportError, RasterFormat, RasterOutput, Samples, export_raster};
use delaunay_tiles::geometry::{Orientation, Point, Rect, orient2d};
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::store::{LineKind, OpenOptions, TileReader};
use delaunay_tiles::terrain::{Clip, Grid, Measure, RasterOptions, Surface};
use delaunay_tiles::{BuildOptions, Builder};
use distributions::Kind;
use futures::StreamExt;

const MEASURES: [&str; 4] = ["z", "slope", "aspect", "hillshade"];

/// A triangular obstacle.
pub(super) fn obstacle() -> SegmentBatch {
    let corners = [(0.25, 0.25), (0.625, 0.375), (0.375, 0.75)].map(|(x, y)| Point::new(x, y));
    let ends: Vec<_> = (0..3).map(|i| [corners[i], corners[(i + 1) % 3]]).collect();
    SegmentBatch {
        z: vec![[2.0; 2]; 3],
        ends,
        lines: vec![0; 3],
        ..SegmentBatch::default()
    }
}

pub(super) async fn build(
    points: &[Point],
    z: &[f64],
    lines: &SegmentBatch,
    tile_vertices: usize,
    threads: usize,
) -> Scratch {
    let scratch = Scratch::new();
    let options = BuildOptions::default().tile_vertices(tile_vertices).threads(threads);
    let mut builder = Builder::new(&scratch.path, options).unwrap();
    builder.push_lines(LineKind::Obstacle, 0, lines).unwrap();
    for batch in batches(points, z) {
        builder.push(&batch).await.unwrap();
    }
    builder.finish().await.unwrap();
    scratch
}

/// Random points, some of them on the centres of a grid of 40 by 40 cells, with random heights of
/// which some are equal.
pub(super) fn terrain(seed: u64) -> (Vec<Point>, Vec<f64>) {
    let mut random = Random(seed);
    let mut points = points_of(Kind::Uniform, 1200, seed);
    let at = |cell: usize| (cell as f64 + 0.5) / 40.0;
    points.extend((0..400).map(|_| Point::new(at(random.below(40)), at(random.below(40)))));
    let z = points.iter().map(|_| match random.below(3) {
        0 => 1.0,
        _ => 10.0 * random.unit() - 5.0,
    });
    let z = z.collect();
    (points, z)
}

pub(super) fn grid() -> Grid {
    Grid::covering(Rect::new(-0.05, -0.05, 1.05, 1.05), 0.025, Point::default()).unwrap()
}

pub(super) struct Triangle {
    pub(super) corners: [Point; 3],
    pub(super) z: [f64; 3],
}

impl Triangle {
    pub(super) fn contains(&self, p: Point) -> bool {
        let [a, b, c] = self.corners;
        [(a, b), (b, c), (c, a)]
            .into_iter()
            .all(|(from, to)| orient2d(from, to, p) != Orientation::Clockwise)
    }

    fn longest(&self) -> f64 {
        let [a, b, c] = self.corners;
        let lengths = [(a, b), (b, c), (c, a)].map(|(p, q)| (p.x - q.x).hypot(p.y - q.y));
        lengths.into_iter().fold(0.0, f64::max)
    }

    pub(super) fn area(a: Point, b: Point, c: Point) -> f64 {
        (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
    }

    /// The weights of the corners.
    pub(super) fn z_at(&self, p: Point) -> f64 {
        let [a, b, c] = self.corners;
        let weights = [Self::area(b, c, p), Self::area(c, a, p), Self::area(a, b, p)];
        let sum: f64 = weights.iter().zip(self.z).map(|(weight, z)| weight * z).sum();
        sum / Self::area(a, b, c)
    }

    /// In degrees.
    fn slope(&self) -> f64 {
        let [a, b, c] = self.corners;
        let [za, zb, zc] = self.z;
        let u = [b.x - a.x, b.y - a.y, zb - za];
        let v = [c.x - a.x, c.y - a.y, zc - za];
        let normal = [
            u[1] * v[2] - u[2] * v[1],
            u[2] * v[0] - u[0] * v[2],
            u[0] * v[1] - u[1] * v[0],
        ];
        normal[0].hypot(normal[1]).atan2(normal[2]).to_degrees()
    }
}

/// Returns the triangles that count.
pub(super) async fn triangles(reader: &TileReader, holes: bool, max_edge: f64) -> Vec<Triangle> {
    let mut found = Vec::new();
    let mut tiles = reader.tiles();
    while let Some(tile) = tiles.next().await {
        let tile = tile.unwrap();
        let owned = tile
            .owned_triangles()
            .filter(|&triangle| holes || !tile.is_hole(triangle));
        found.extend(owned.map(|triangle| Triangle {
            corners: tile.triangle_points(triangle),
            z: tile.corners(triangle).map(|corner| tile.z(corner).unwrap()),
        }));
    }
    found.retain(|triangle| triangle.longest() <= max_edge);
    found
}

pub(super) async fn whole(reader: &TileReader, options: &RasterOptions) -> Vec<f64> {
    let grid = options.grid();
    reader.raster(options, 0..grid.columns(), 0..grid.rows()).await.unwrap()
}

fn bits(values: &[f64]) -> Vec<u64> {
    values
        .iter()
        .map(|value| if value.is_nan() { u64::MAX } else { value.to_bits() })
        .collect()
}

#[test]
fn every_cell_has_the_height_and_slope_of_a_triangle_at_its_centre() {
    runtime().block_on(async {
        let (points, z) = terrain(1);
        let scratch = build(&points, &z, &obstacle(), 64, 2).await;
        let reader = scratch.open().await;
        for (holes, max_edge) in [(false, f64::INFINITY), (true, f64::INFINITY), (false, 0.06)] {
            let triangles = triangles(&reader, holes, max_edge).await;
            let limit = Some(max_edge).filter(|length| length.is_finite());
            let options = RasterOptions::new(grid()).surface(Surface::default().holes(holes).max_edge(limit));
            let heights = whole(&reader, &options).await;
            let slopes = whole(&reader, &options.clone().measure(Measure::Slope)).await;
            let mut on_boundaries = 0;
            for (cell, (&z, &slope)) in heights.iter().zip(&slopes).enumerate() {
                let columns = grid().columns() as usize;
                let centre = grid().centre((cell % columns) as u32, (cell / columns) as u32);
                let touching: Vec<_> = triangles.iter().filter(|triangle| triangle.contains(centre)).collect();
                on_boundaries += usize::from(touching.len() > 1);
                assert_eq!(z.is_nan(), touching.is_empty(), "{centre:?}");
                assert_eq!(slope.is_nan(), touching.is_empty(), "{centre:?}");
                for triangle in &touching {
                    assert!((z - triangle.z_at(centre)).abs() <= 1e-9 * 5.0, "{centre:?}");
                }
                let is_slope = |triangle: &&&Triangle| (triangle.slope() - slope).abs() < 1e-9 * 90.0;
                assert_eq!(
                    touching.iter().find(is_slope).is_some(),
                    !touching.is_empty(),
                    "{centre:?}"
                );
            }
            assert!(on_boundaries > 100, "{on_boundaries}");
        }
    });
}

#[test]
fn rasters_do_not_depend_on_tiles_threads_memory_and_windows() {
    runtime().block_on(async {
        for seed in 2..5 {
            let (points, z) = terrain(seed);
            let mut first: Option<Vec<Vec<u64>>> = None;
            for (tile_vertices, threads) in [(5000, 1), (64, 2), (8, 1)] {
                let scratch = build(&points, &z, &obstacle(), tile_vertices, threads).await;
                let reader = scratch.open().await;
                let mut found = Vec::new();
                for name in MEASURES {
                    let surface = Surface::default().max_edge(Some(0.1));
                    let options = RasterOptions::new(grid())
                        .measure(name.parse().unwrap())
                        .surface(surface);
                    let values = whole(&reader, &options).await;
                    assert_eq!(
                        bits(&values),
                        bits(&in_windows(&reader, &options).await),
                        "{name} in windows"
                    );
                    found.push(bits(&values));
                }
                let first = first.get_or_insert_with(|| found.clone());
                assert!(*first == found, "tiles of {tile_vertices}");
            }
        }
    });
}

/// Returns a raster from windows of 7 columns and 5 rows.
async fn in_windows(reader: &TileReader, options: &RasterOptions) -> Vec<f64> {
    let (columns, rows) = (options.grid().columns(), options.grid().rows());
    let mut values = vec![0.0; (columns * rows) as usize];
    for top in (0..rows).step_by(5) {
        for left in (0..columns).step_by(7) {
            let window: [Range<u32>; 2] = [left..columns.min(left + 7), top..rows.min(top + 5)];
            let found = reader
                .raster(options, window[0].clone(), window[1].clone())
                .await
                .unwrap();
            let width = window[0].len();
            for (row, of_row) in window[1].clone().zip(found.chunks(width)) {
                let start = (row * columns + left) as usize;
                values[start..start + width].copy_from_slice(of_row);
            }
        }
    }
    values
}

#[test]
fn a_grid_of_heights_comes_back_exactly_at_its_own_points() {
    runtime().block_on(async {
        let mut random = Random(9);
        let points: Vec<Point> = (0..50 * 40)
            .map(|i| Point::new(f64::from(i % 50), f64::from(i / 50)))
            .collect();
        let z: Vec<f64> = points.iter().map(|_| 1000.0 * random.unit()).collect();
        let scratch = build(&points, &z, &SegmentBatch::default(), 100, 2).await;
        let grid = Grid::starting_at(Rect::new(-0.5, -0.5, 49.5, 39.5), 1.0).unwrap();
        let values = whole(&scratch.open().await, &RasterOptions::new(grid)).await;
        let expected: Vec<f64> = (0..40)
            .rev()
            .flat_map(|row| z[row * 50..(row + 1) * 50].to_vec())
            .collect();
        assert_eq!(values, expected);
    });
}

fn parsed(asc: &[u8]) -> (Vec<f64>, Vec<f64>) {
    let text = std::str::from_utf8(asc).unwrap();
    let mut lines = text.lines();
    let header = lines
        .by_ref()
        .take(6)
        .map(|line| line.split(' ').nth(1).unwrap().parse().unwrap());
    let header: Vec<f64> = header.collect();
    let values = lines.flat_map(|line| line.split(' ').map(|cell| cell.parse().unwrap()));
    (header, values.collect())
}

#[test]
fn an_ascii_grid_has_the_same_bits_in_every_memory() {
    runtime().block_on(async {
        let (points, z) = terrain(5);
        let scratch = build(&points, &z, &obstacle(), 64, 2).await;
        let reader = scratch.open().await;
        let triangle = [(0.5, -1.0), (2.0, 0.5), (-1.0, 2.0)].map(|(x, y)| Point::new(x, y));
        let clip = Clip::new((0..3).map(|i| [triangle[i], triangle[(i + 1) % 3]]).collect());
        let options = RasterOptions::new(grid()).clip(Some(Arc::new(clip)));
        let values = whole(&reader, &options).await;
        let how = RasterOutput::new(RasterFormat::Asc);
        let exported = export_raster(&reader, options.clone(), &how, Vec::new(), |_, _| ())
            .await
            .unwrap();
        let (header, found) = parsed(&exported.output);
        let bounds = grid().bounds();
        assert_eq!(header, [44.0, 44.0, bounds.min_x, bounds.min_y, 0.025, -9999.0]);
        let expected: Vec<f64> = values.iter().map(|v| if v.is_nan() { -9999.0 } else { *v }).collect();
        assert_eq!(found, expected);
        assert!(values.iter().filter(|v| v.is_nan()).count() > 400);
        // The least memory that suffices, found by bisection, gives many blocks.
        let memory = least_memory(&scratch, &options).await;
        let small = TileReader::open(&scratch.path, OpenOptions::default().memory(memory))
            .await
            .unwrap();
        let mut reads = 0;
        let again = export_raster(&small, options, &how, Vec::new(), |_, total| reads = total)
            .await
            .unwrap();
        assert!(again.output == exported.output);
        assert!(reads > 2 * u64::from(reader.metadata().tiles), "{reads} tiles read");
    });
}

/// Returns the least memory, in KiB steps, in which the options can be exported.
async fn least_memory(scratch: &Scratch, options: &RasterOptions) -> u64 {
    let (mut fails, mut works) = (1u64 << 20, 1u64 << 28);
    while works - fails > 1024 {
        let middle = fails.midpoint(works);
        let reader = TileReader::open(&scratch.path, OpenOptions::default().memory(middle)).await;
        let how = RasterOutput::new(RasterFormat::Asc);
        let done = match reader {
            Ok(reader) => export_raster(&reader, options.clone(), &how, Vec::new(), |_, _| ())
                .await
                .is_ok(),
            Err(_) => false,
        };
        if done { works = middle } else { fails = middle }
    }
    works
}

#[test]
fn a_file_without_heights_is_refused() {
    runtime().block_on(async {
        let points = points_of(Kind::Uniform, 100, 1);
        let scratch = build(&points, &[], &SegmentBatch::default(), 50, 1).await;
        let options = RasterOptions::new(grid());
        let how = RasterOutput::new(RasterFormat::Asc).samples(Samples::Float32);
        let error = export_raster(&scratch.open().await, options, &how, Vec::new(), |_, _| ())
            .await
            .unwrap_err();
        assert!(
            matches!(error, ExportError::Terrain(_)) && error.to_string().contains("has no z"),
            "{error}"
        );
    });
}
