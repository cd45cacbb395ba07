//! Contours, against a join of all triangles by brute force; all comparisons are of bits.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::contours_cut::star;
use super::rasters::{build, obstacle, terrain};
use crate::export::features::features;
use crate::support::{Random, Scratch, points_of, runtime};
use delaunay_tiles::export::{ContourOutput, ExportError, ExportedContours, Format, export_contours};
use delaunay_tiles::geometry::{Point, Rect, segments_cross};
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::store::{OpenOptions, ReadError, TileReader};
use delaunay_tiles::terrain::{Clip, ContourOptions, Levels, LevelsError, Surface, TerrainError};
use distributions::Kind;
use futures::StreamExt;

/// The bits of x and y, which name a vertex.
pub(super) type Position = [u64; 2];
pub(super) type Corner = (Point, f64);

/// A contour: its height, whether it is closed, and its points.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Contour {
    pub(super) z: u64,
    pub(super) is_closed: bool,
    pub(super) points: Vec<Position>,
}

fn position(p: Point) -> Position {
    [p.x, p.y].map(f64::to_bits)
}

pub(super) fn point([x, y]: Position) -> Point {
    Point::new(f64::from_bits(x), f64::from_bits(y))
}

pub(super) async fn exported(
    reader: &TileReader,
    options: ContourOptions,
    format: Format,
) -> Result<ExportedContours<Vec<u8>>, ExportError> {
    let mut last = (0, 0);
    let how = ContourOutput::new(format);
    let exported = export_contours(reader, options, &how, Vec::new(), |done, total| last = (done, total)).await?;
    // With polygons, not all tiles are read; they are read twice if triangles are peeled off the hull.
    assert!(
        last.0 == last.1 && last.0 <= 2 * u64::from(reader.metadata().tiles),
        "{last:?}"
    );
    Ok(exported)
}

pub(super) fn parsed(format: Format, bytes: &[u8]) -> Vec<Contour> {
    let (features, kind) = features(format, bytes);
    assert!(kind == "linestring" || features.is_empty(), "{kind}");
    let contours = features.into_iter().map(|feature| {
        let text = |key: &str| feature.values[key].to_string().trim_matches('"').to_owned();
        let z: f64 = text("z").parse().unwrap();
        let is_closed = ["true", "1"].contains(&&*text("closed"));
        let points = feature.corners.iter().map(|corner| {
            assert_eq!(corner[2].to_bits(), z.to_bits());
            position(Point::new(corner[0], corner[1]))
        });
        let points: Vec<_> = points.collect();
        assert!(points.len() > 1 && points.windows(2).all(|pair| pair[0] != pair[1]));
        assert_eq!(is_closed, points.first() == points.last());
        Contour {
            z: z.to_bits(),
            is_closed,
            points,
        }
    });
    contours.collect()
}

/// Returns the contours in the order of their heights and points. No two are equal.
pub(super) async fn contours(reader: &TileReader, options: ContourOptions) -> BTreeSet<Contour> {
    let exported = exported(reader, options, Format::GeoJson).await.unwrap();
    let list = parsed(Format::GeoJson, &exported.output);
    let set: BTreeSet<_> = list.iter().cloned().collect();
    assert_eq!((set.len(), exported.contours), (list.len(), list.len() as u64));
    assert_eq!(list.iter().map(|c| c.points.len() as u64).sum::<u64>(), exported.points);
    set
}

/// Returns the triangles that count.
async fn triangles(reader: &TileReader, holes: bool, max_edge: f64) -> Vec<[Corner; 3]> {
    let mut found = Vec::new();
    let mut tiles = reader.tiles();
    while let Some(tile) = tiles.next().await {
        let tile = tile.unwrap();
        for triangle in tile.owned_triangles().filter(|&t| holes || !tile.is_hole(t)) {
            let corners = tile.corners(triangle).map(|c| (tile.point(c), tile.z(c).unwrap()));
            let length = |i: usize, j: usize| (corners[i].0.x - corners[j].0.x).hypot(corners[i].0.y - corners[j].0.y);
            if [length(0, 1), length(1, 2), length(2, 0)]
                .into_iter()
                .all(|length| length <= max_edge)
            {
                found.push(corners);
            }
        }
    }
    found
}

/// Returns the point of an edge at a height.
fn crossing(mut ends: [Corner; 2], z: f64) -> Position {
    ends.sort_by(|a, b| a.0.lex_cmp(b.0));
    let [(a, low), (b, high)] = ends;
    let t = (z - low) / (high - low);
    position(if t == 0.0 {
        a
    } else if t == 1.0 && z == high {
        b
    } else {
        Point::new(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)).normalized()
    })
}

/// Joins the contours of a level from all triangles: each leads from the edge down to the edge up.
fn joined(triangles: &[[Corner; 3]], z: f64) -> BTreeSet<Contour> {
    let mut next: BTreeMap<[Position; 2], [Position; 2]> = BTreeMap::new();
    let mut at = BTreeMap::new();
    for corners in triangles {
        let mut ends = [None; 2];
        for i in 0..3 {
            let edge = [corners[i], corners[(i + 1) % 3]];
            let above = edge.map(|(_, height)| height >= z);
            let mut name = edge.map(|(p, _)| position(p));
            name.sort_unstable();
            match above {
                [true, false] => ends[0] = Some(name),
                [false, true] => ends[1] = Some(name),
                _ => continue,
            }
            at.insert(name, crossing(edge, z));
        }
        if let [Some(from), Some(to)] = ends {
            assert!(next.insert(from, to).is_none(), "an edge is crossed twice");
        }
    }
    let entered: BTreeSet<_> = next.values().copied().collect();
    let mut starts: Vec<_> = next.keys().copied().filter(|edge| !entered.contains(edge)).collect();
    let mut found = BTreeSet::new();
    while let Some(start) = starts.pop().or_else(|| next.keys().next().copied()) {
        let mut edges = vec![start];
        while let Some(to) = next.remove(&edges[edges.len() - 1]) {
            edges.push(to);
        }
        let is_closed = edges.len() > 1 && edges.first() == edges.last();
        let mut points: Vec<_> = edges.iter().map(|edge| at[edge]).collect();
        points.dedup();
        if is_closed && points.len() > 1 {
            points.pop();
            let order = |&[x, y]: &Position| [x, y].map(f64::from_bits);
            let by_value = |a: &Position, b: &Position| order(a).partial_cmp(&order(b)).unwrap();
            let least = *points.iter().min_by(|a, b| by_value(a, b)).unwrap();
            let starts = (0..points.len()).filter(|&i| points[i] == least);
            let rotations = starts.map(|by| [&points[by..], &points[..by]].concat());
            let ordered = rotations.map(|points| (points.iter().map(order).collect::<Vec<_>>(), points));
            points = ordered.min_by(|a, b| a.0.partial_cmp(&b.0).unwrap()).unwrap().1;
            points.push(points[0]);
        }
        if points.len() > 1 {
            let z = z.to_bits();
            found.insert(Contour { z, is_closed, points });
        }
    }
    found
}

/// Returns the contours of all levels between the least and the greatest height.
pub(super) fn expected(triangles: &[[Corner; 3]], step: f64, base: f64) -> BTreeSet<Contour> {
    let heights = || triangles.iter().flatten().map(|corner| corner.1);
    let (low, high) = (
        heights().fold(f64::INFINITY, f64::min),
        heights().fold(f64::NEG_INFINITY, f64::max),
    );
    let levels = (((low - base) / step).floor() as i64)..=(((high - base) / step).ceil() as i64);
    levels.flat_map(|k| joined(triangles, base + k as f64 * step)).collect()
}

pub(super) fn options(step: f64, base: f64) -> ContourOptions {
    ContourOptions::new(Levels::new(step, base).unwrap())
}

#[test]
fn contours_are_those_of_a_join_over_all_triangles() {
    runtime().block_on(async {
        let (points, random) = terrain(3);
        // Heights on levels, and flat ground.
        let whole: Vec<f64> = random.iter().map(|z| (z / 3.0).round()).collect();
        for (z, step, base) in [(&random, 0.75, 0.1), (&whole, 1.0, 0.0), (&whole, 0.5, 0.25)] {
            let mut of_tiles = Vec::new();
            for tile_vertices in [8, 60, 5000] {
                let scratch = build(&points, z, &obstacle(), tile_vertices, 2).await;
                let reader = scratch.open().await;
                let found = contours(&reader, options(step, base)).await;
                let expected = expected(&triangles(&reader, false, f64::INFINITY).await, step, base);
                assert!(
                    expected.len() > 50 && found == expected,
                    "{} of {}",
                    found.len(),
                    expected.len()
                );
                for is_closed in [false, true] {
                    assert!(
                        found.iter().any(|contour| contour.is_closed == is_closed),
                        "none is {is_closed}"
                    );
                }
                of_tiles.push(found);
            }
            assert!(of_tiles.iter().all(|found| *found == of_tiles[0]));
        }
    });
}

#[test]
fn contours_do_not_depend_on_threads_and_memory() {
    runtime().block_on(async {
        let (points, z) = terrain(6);
        for tile_vertices in [8, 60, 5000] {
            let mut first: Option<Vec<u8>> = None;
            for (threads, memory) in [1, 2, 4].into_iter().flat_map(|n| [(n, 24 << 20), (n, 1 << 30)]) {
                let scratch = build(&points, &z, &obstacle(), tile_vertices, threads).await;
                let limited = OpenOptions::default().memory(memory);
                let reader = TileReader::open(&scratch.path, limited).await.unwrap();
                let found = exported(&reader, options(0.5, 0.25), Format::GeoJson).await.unwrap();
                let first = first.get_or_insert_with(|| found.output.clone());
                assert!(*first == found.output, "{threads} threads, {memory} bytes");
            }
        }
    });
}

#[test]
fn triangles_that_do_not_count_end_contours() {
    runtime().block_on(async {
        let (points, z) = terrain(8);
        let scratch = build(&points, &z, &obstacle(), 30, 2).await;
        let reader = scratch.open().await;
        let mut found = Vec::new();
        for (holes, max_edge) in [(false, None), (true, None), (false, Some(0.05)), (true, Some(0.0))] {
            let surface = Surface::default().holes(holes).max_edge(max_edge);
            let counting = triangles(&reader, holes, max_edge.unwrap_or(f64::INFINITY)).await;
            let contours = contours(&reader, options(1.0, 0.5).surface(surface)).await;
            assert_eq!(contours, expected(&counting, 1.0, 0.5));
            found.push(contours);
        }
        assert!(found[0] != found[1] && found[0] != found[2] && found[3].is_empty());
    });
}

#[test]
fn contours_of_a_level_do_not_cross() {
    runtime().block_on(async {
        let (points, z) = terrain(12);
        let scratch = build(&points, &z, &obstacle(), 100, 2).await;
        let found = contours(&scratch.open().await, options(2.0, 0.0)).await;
        let mut of_level: BTreeMap<u64, Vec<[Point; 2]>> = BTreeMap::new();
        for contour in &found {
            let segments = contour.points.windows(2).map(|pair| [point(pair[0]), point(pair[1])]);
            of_level.entry(contour.z).or_default().extend(segments);
        }
        let mut compared = 0;
        for segments in of_level.values() {
            for (i, &[a, b]) in segments.iter().enumerate() {
                let around = Rect::around([a, b]);
                let near = |[c, d]: &&[Point; 2]| Rect::around([*c, *d]).intersects(around);
                for &[c, d] in segments[..i].iter().filter(near) {
                    assert!(!segments_cross(a, b, c, d), "{a:?} {b:?} {c:?} {d:?}");
                    compared += 1;
                }
            }
        }
        assert!(compared > 5_000, "{compared}");
    });
}

#[test]
fn a_file_has_the_same_bytes_in_every_memory_and_the_same_contours_in_both_formats() {
    runtime().block_on(async {
        let (points, z) = terrain(5);
        let scratch = build(&points, &z, &obstacle(), 40, 2).await;
        let reader = scratch.open().await;
        let star = Arc::new(Clip::new(star()));
        let options = options(0.5, 0.0);
        let cut = options.clone().clip(Some(star));
        for (format, options) in [Format::GeoJson, Format::FlatGeobuf]
            .into_iter()
            .flat_map(|format| [(format, &options), (format, &cut)])
        {
            let whole = exported(&reader, options.clone(), format).await.unwrap();
            assert_eq!(whole.bytes, whole.output.len() as u64);
            let found: BTreeSet<_> = parsed(format, &whole.output).into_iter().collect();
            assert_eq!(found, contours(&reader, options.clone()).await, "{format}");
            let (mut works, mut refused) = (0, 0);
            for memory in (1..24).map(|mebibytes| mebibytes << 20) {
                let small = OpenOptions::default().memory(memory);
                let Ok(small) = TileReader::open(&scratch.path, small).await else {
                    continue;
                };
                match exported(&small, options.clone(), format).await {
                    Ok(again) => {
                        assert!(again.output == whole.output, "{format} in {memory} bytes");
                        works += 1;
                    }
                    Err(ExportError::Read(ReadError::Memory { needed, .. })) => {
                        assert!(needed > memory && works == 0);
                        refused += 1;
                    }
                    Err(error) => panic!("{error}"),
                }
            }
            assert!(works > 2 && refused > 0, "{works} {refused}");
        }
    });
}

/// Returns twice the area of a ring, positive if it is counter-clockwise.
pub(super) fn doubled_area(ring: &[Point]) -> f64 {
    ring.windows(2)
        .map(|pair| pair[0].x * pair[1].y - pair[1].x * pair[0].y)
        .sum()
}

#[test]
fn a_cone_has_regular_polygons_with_the_higher_ground_on_the_left() {
    runtime().block_on(async {
        let corners = 64u32;
        let angle = std::f64::consts::TAU / f64::from(corners);
        // Rings at radius 1 to 10, and the top.
        let mut points = vec![Point::default()];
        let mut z = vec![10.0];
        for radius in 1..=10 {
            for corner in 0..corners {
                let at = f64::from(corner) * angle;
                points.push(Point::new(f64::from(radius) * at.cos(), f64::from(radius) * at.sin()));
                z.push(10.0 - f64::from(radius));
            }
        }
        let scratch = build(&points, &z, &SegmentBatch::default(), 50, 2).await;
        let found = contours(&scratch.open().await, options(1.0, 0.0)).await;
        let closed: Vec<_> = found.iter().filter(|contour| contour.is_closed).collect();
        // The top is a point, and the lowest level is on the hull.
        assert_eq!((found.len(), closed.len()), (9, 9));
        for contour in closed {
            let radius = 10.0 - f64::from_bits(contour.z);
            let ring: Vec<Point> = contour.points.iter().map(|&p| point(p)).collect();
            let expected = f64::from(corners) * radius * radius * angle.sin();
            assert!((doubled_area(&ring) / expected - 1.0).abs() < 1e-12, "{radius}");
            assert_eq!(ring.len(), 65);
        }
    });
}

/// A wall of height 1 that winds through a square of 181.
pub(super) async fn winding_wall() -> Scratch {
    let side = 182;
    let is_wall = |row: usize, column: usize| {
        let inner = 1..side - 1;
        let turn = if (row / 2).is_multiple_of(2) { 1 } else { side - 2 };
        inner.contains(&row) && inner.contains(&column) && (row % 2 == 1 || column == turn && row < side - 2)
    };
    let cells = || (0..side * side).map(|i| (i / side, i % side));
    let points: Vec<_> = cells()
        .map(|(row, column)| Point::new(column as f64, row as f64))
        .collect();
    let z: Vec<_> = cells()
        .map(|(row, column)| f64::from(u8::from(is_wall(row, column))))
        .collect();
    build(&points, &z, &SegmentBatch::default(), 500, 2).await
}

/// A contour that is longer than what is read at once.
#[test]
fn a_contour_through_all_tiles_is_one_line() {
    runtime().block_on(async {
        let scratch = winding_wall().await;
        let reader = scratch.open().await;
        let found = contours(&reader, options(2.0, 0.5)).await;
        assert_eq!(found.len(), 1);
        let Contour { is_closed, points, .. } = found.first().unwrap();
        assert!(*is_closed && points.len() > 40_000, "{}", points.len());
        assert_eq!(found, joined(&triangles(&reader, false, f64::INFINITY).await, 0.5));
        let in_fgb = exported(&reader, options(2.0, 0.5), Format::FlatGeobuf).await.unwrap();
        assert!(parsed(Format::FlatGeobuf, &in_fgb.output).iter().eq(&found));
    });
}

#[test]
fn surfaces_without_contours_have_none() {
    runtime().block_on(async {
        let (points, _) = terrain(1);
        for (points, z) in [
            (points.clone(), vec![1.0; points.len()]),
            (vec![Point::new(0.0, 0.0), Point::new(1.0, 1.0)], vec![0.0, 9.0]),
        ] {
            let scratch = build(&points, &z, &SegmentBatch::default(), 50, 1).await;
            let reader = scratch.open().await;
            assert!(contours(&reader, options(1.0, 0.0)).await.is_empty());
            let fgb = exported(&reader, options(1.0, 0.0), Format::FlatGeobuf).await.unwrap();
            assert!(parsed(Format::FlatGeobuf, &fgb.output).is_empty());
        }
    });
}

async fn error_of(scratch: &Scratch, step: f64, format: Format) -> ExportError {
    exported(&scratch.open().await, options(step, 0.0), format)
        .await
        .unwrap_err()
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    runtime().block_on(async {
        let points = points_of(Kind::Uniform, 500, 1);
        let flat = build(&points, &[], &SegmentBatch::default(), 50, 1).await;
        let error = error_of(&flat, 1.0, Format::GeoJson).await;
        assert!(error.to_string().contains("has no z"), "{error}");

        let mut random = Random(4);
        let z: Vec<f64> = points.iter().map(|_| 1000.0 * random.unit()).collect();
        let steep = build(&points, &z, &SegmentBatch::default(), 50, 1).await;
        for (step, is_fine) in [(1e-3, false), (1e-13, true)] {
            match error_of(&steep, step, Format::GeoJson).await {
                ExportError::Terrain(TerrainError::Levels(LevelsError::TooMany { .. })) => assert!(!is_fine),
                ExportError::Terrain(TerrainError::Levels(LevelsError::TooFine { .. })) => assert!(is_fine),
                error => panic!("{error}"),
            }
        }
        let error = error_of(&steep, 100.0, Format::GeoParquet).await;
        assert!(error.to_string().contains("not as parquet"), "{error}");
        let how = ContourOutput::new(Format::GeoJson).scratch(steep.folder.path().join("missing"));
        let reader = steep.open().await;
        let error = export_contours(&reader, options(100.0, 0.0), &how, Vec::new(), |_, _| {}).await;
        assert!(matches!(error, Err(ExportError::Scratch { .. })));
    });
}
