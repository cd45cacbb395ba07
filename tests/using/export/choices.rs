//! What is exported by choice: vertices, edges, triangles without long edges, and those in polygons. All
//! formats must agree.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::features::{Feature, features};
use super::parsers::{mesh_of_glb, parse};
use crate::support::peeling::peeled;
use crate::support::{Scratch, built, points_of, runtime};
use delaunay_tiles::export::{ExportOptions, Exported, Format, What, export};
use delaunay_tiles::geometry::{Orientation, Point, orient2d};
use delaunay_tiles::input::{PointBatch, SegmentBatch};
use delaunay_tiles::store::{LineKind, TileReader};
use delaunay_tiles::terrain::Clip;
use delaunay_tiles::{BuildOptions, Builder};
use distributions::Kind;
use futures::StreamExt;

async fn exported(reader: &TileReader, format: Format, options: &ExportOptions) -> Exported<Vec<u8>> {
    let outputs = format.suffixes().iter().map(|_| Vec::new()).collect();
    let mut last = (0, 0);
    let exported = export(reader, format, options.clone(), outputs, |done, total| {
        last = (done, total)
    });
    let exported = exported.await.unwrap();
    assert_eq!(last.0, last.1, "progress of {format}");
    exported
}

const CORNERS: [(f64, f64); 3] = [(0.2, 0.2), (0.6, 0.3), (0.3, 0.7)];

fn corners() -> [Point; 3] {
    CORNERS.map(|(x, y)| Point::new(x, y))
}

fn ring() -> Vec<[Point; 2]> {
    let corners = corners();
    (0..3).map(|i| [corners[i], corners[(i + 1) % 3]]).collect()
}

/// Builds random points with z, a triangular obstacle and two walls, of which one runs along its edge.
async fn with_lines(scratch: &Scratch) -> TileReader {
    let points = points_of(Kind::Uniform, 3000, 5);
    let mut builder = Builder::new(&scratch.path, BuildOptions::default().tile_vertices(64)).unwrap();
    let walls = vec![ring()[0], [Point::new(0.7, 0.1), Point::new(0.9, 0.9)]];
    for (kind, first_line, ends, lines) in [
        (LineKind::Obstacle, 7, ring(), vec![0; 3]),
        (LineKind::Wall, 2, walls, vec![0, 2]),
    ] {
        let batch = SegmentBatch {
            z: vec![[1.0; 2]; ends.len()],
            ends,
            lines,
            ..SegmentBatch::default()
        };
        builder.push_lines(kind, first_line, &batch).unwrap();
    }
    let batch = PointBatch {
        z: points.iter().map(|p| p.x - p.y).collect(),
        records: (0..points.len() as u64).collect(),
        points,
    };
    builder.push(&batch).await.unwrap();
    builder.finish().await.unwrap();
    scratch.open().await
}

fn feature_formats() -> impl Iterator<Item = Format> {
    Format::ALL.into_iter().filter(|format| format.has_features())
}

/// Returns the features of each format, without what GeoJSON has not.
async fn features_of(reader: &TileReader, options: &ExportOptions) -> Vec<Feature> {
    let mut all: Option<Vec<Feature>> = None;
    for format in feature_formats() {
        let exported = exported(reader, format, options).await;
        let (mut found, _) = features(format, &exported.outputs[0]);
        for feature in &mut found {
            feature.values.remove("region");
        }
        let first = all.get_or_insert_with(|| found.clone());
        assert!(*first == found, "{format} differs");
    }
    all.unwrap()
}

type Position = [u64; 2];

fn position(x: f64, y: f64) -> Position {
    [x.to_bits(), y.to_bits()]
}

/// Returns a triangle from its first corner on.
fn from_least(mut corners: [Position; 3]) -> [Position; 3] {
    let least = (0..3).min_by_key(|&i| corners[i]).unwrap();
    corners.rotate_left(least);
    corners
}

/// Returns the triangles of the file for which `is_wanted`.
async fn triangles_of(reader: &TileReader, is_wanted: impl Fn([Point; 3]) -> bool) -> BTreeSet<[Position; 3]> {
    let mut found = BTreeSet::new();
    let mut tiles = reader.tiles();
    while let Some(tile) = tiles.next().await {
        let tile = tile.unwrap();
        let owned = tile.owned_triangles().filter(|&triangle| !tile.is_hole(triangle));
        let wanted = owned
            .map(|triangle| tile.triangle_points(triangle))
            .filter(|&corners| is_wanted(corners));
        found.extend(wanted.map(|corners| from_least(corners.map(|p| position(p.x, p.y)))));
    }
    found
}

/// Exports to all formats, and compares the triangles.
async fn check_triangles(reader: &TileReader, options: ExportOptions, expected: &BTreeSet<[Position; 3]>) {
    let vertices = reader.metadata().vertices;
    for format in Format::ALL {
        let exported = exported(reader, format, &options).await;
        assert_eq!(
            (exported.vertices, exported.triangles),
            (vertices, expected.len() as u64),
            "{format}"
        );
        if format.has_features() {
            let (features, _) = features(format, &exported.outputs[0]);
            let triangles = features
                .iter()
                .map(|feature| from_least([0, 1, 2].map(|i| position(feature.corners[i][0], feature.corners[i][1]))));
            assert_eq!(triangles.collect::<BTreeSet<_>>(), *expected, "{format}");
            assert_eq!(features.len(), expected.len(), "{format}");
            continue;
        }
        let parsed = match format {
            // Its coordinates are rounded, but vertices have the same numbers in all formats.
            Format::Glb => parse(
                Format::Obj,
                &self::exported(reader, Format::Obj, &options).await.outputs,
            ),
            _ => parse(format, &exported.outputs),
        };
        let triangles = match format {
            Format::Glb => mesh_of_glb(&exported.outputs[0]).1,
            _ => parsed.triangles,
        };
        assert_eq!(triangles.len(), expected.len(), "{format}");
        let points: Vec<_> = parsed.points.iter().map(|p| position(p.x, p.y)).collect();
        let found: BTreeSet<_> = triangles
            .into_iter()
            .map(|t| from_least(t.map(|v| points[v])))
            .collect();
        assert_eq!(found, *expected, "{format}");
    }
}

#[test]
fn triangles_with_long_edges_are_left_out() {
    runtime().block_on(async {
        let scratch = Scratch::new();
        let reader = with_lines(&scratch).await;
        let mut before = 0;
        for most in [0.0, 0.02, 0.05, 10.0] {
            let is_wanted = |[a, b, c]: [Point; 3]| {
                let length = |p: Point, q: Point| (p.x - q.x).hypot(p.y - q.y);
                length(a, b).max(length(b, c)).max(length(c, a)) <= most
            };
            let expected = triangles_of(&reader, is_wanted).await;
            assert!(most == 0.0 || expected.len() > before, "{most}");
            before = expected.len();
            check_triangles(&reader, ExportOptions::default().max_edge(Some(most)), &expected).await;
        }
    });
}

#[test]
fn long_triangles_are_peeled_off_from_the_hull_in_all_formats() {
    runtime().block_on(async {
        let scratch = Scratch::new();
        let reader = with_lines(&scratch).await;
        let mut all = Vec::new();
        let mut tiles = reader.tiles();
        while let Some(tile) = tiles.next().await {
            let tile = tile.unwrap();
            all.extend(tile.owned_triangles().map(|triangle| tile.triangle_points(triangle)));
        }
        let name = |corners: [Point; 3]| from_least(corners.map(|p| position(p.x, p.y)));
        let mut before = 0;
        for most in [0.0, 0.03, 0.05, 0.08] {
            let peeled = all.iter().zip(peeled(&all, most)).filter(|(_, is_peeled)| *is_peeled);
            let peeled: BTreeSet<_> = peeled.map(|(&corners, _)| name(corners)).collect();
            let expected = triangles_of(&reader, |corners| !peeled.contains(&name(corners))).await;
            assert!(most == 0.0 || expected.len() > before, "{most}");
            before = expected.len();
            let options = ExportOptions::default().max_edge(Some(most)).from_hull(true);
            check_triangles(&reader, options, &expected).await;
        }
    });
}

/// Returns the area of the part of a triangle that is in the triangle of [`corners`].
fn common_area(triangle: [Point; 3]) -> f64 {
    let mut part = triangle.to_vec();
    for [a, b] in ring() {
        let side = |p: Point| (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
        let mut left = Vec::new();
        for (i, &p) in part.iter().enumerate() {
            let q = part[(i + 1) % part.len()];
            let t = side(p) / (side(p) - side(q));
            if side(p) >= 0.0 {
                left.push(p);
            }
            if side(p) * side(q) < 0.0 {
                left.push(Point::new((q.x - p.x).mul_add(t, p.x), (q.y - p.y).mul_add(t, p.y)));
            }
        }
        part = left;
    }
    let area = |p: &Point, q: &Point| p.x * q.y - q.x * p.y;
    let next = part.iter().skip(1).chain(part.first());
    part.iter().zip(next).map(|(p, q)| area(p, q)).sum::<f64>() / 2.0
}

#[test]
fn clipping_keeps_what_meets_the_polygon() {
    runtime().block_on(async {
        // The polygon cuts the triangles of the first file, and consists of edges of the second.
        let (scratch, uniform) = built(
            &points_of(Kind::Uniform, 2000, 9),
            BuildOptions::default().tile_vertices(50),
        )
        .await;
        let lines = Scratch::new();
        let with_lines = with_lines(&lines).await;
        let clip = Some(Arc::new(Clip::new(ring())));
        for reader in [&uniform, &with_lines] {
            let options = ExportOptions::default().clip(clip.clone());
            let expected = triangles_of(reader, |corners| common_area(corners) > 1e-15).await;
            assert_eq!(expected.is_empty(), reader.metadata().hole_triangles > 0);
            check_triangles(reader, options.clone(), &expected).await;
            if reader.metadata().hole_triangles > 0 {
                let expected: BTreeSet<_> = triangles_of(reader, |_| true).await;
                assert!(expected.len() as u64 + reader.metadata().hole_triangles == reader.metadata().triangles);
                for format in Format::ALL {
                    let exported = exported(reader, format, &options.clone().holes(true)).await;
                    assert_eq!(exported.triangles, reader.metadata().hole_triangles, "{format}");
                }
            }
            let all = features_of(reader, &ExportOptions::default().what(Some(What::Vertices))).await;
            assert_eq!(all.len() as u64, reader.metadata().vertices);
            let inside = |feature: &Feature| {
                let p = Point::new(feature.corners[0][0], feature.corners[0][1]);
                ring().iter().all(|&[a, b]| orient2d(a, b, p) != Orientation::Clockwise)
            };
            let expected: Vec<_> = all.into_iter().filter(inside).collect();
            assert!(expected.len() > 50);
            assert_eq!(
                features_of(reader, &options.clone().what(Some(What::Vertices))).await,
                expected
            );
        }
        // The edges of the obstacle, and none of the other wall.
        let options = ExportOptions::default().what(Some(What::Edges));
        let all = features_of(&with_lines, &options).await;
        let clipped = features_of(&with_lines, &options.clip(clip)).await;
        let of_obstacle = all.into_iter().filter(|edge| edge.values["kind"] != "wall");
        assert_eq!(clipped, of_obstacle.collect::<Vec<_>>());
        drop(scratch);
    });
}

#[test]
fn edges_have_the_numbers_of_their_ends_their_kinds_and_their_lines() {
    runtime().block_on(async {
        let scratch = Scratch::new();
        let reader = with_lines(&scratch).await;
        let vertices = features_of(&reader, &ExportOptions::default().what(Some(What::Vertices))).await;
        let edges = features_of(&reader, &ExportOptions::default().what(Some(What::Edges))).await;
        assert_eq!(edges.len() as u64, reader.metadata().constraint_edges);
        let mut kinds = BTreeMap::new();
        let mut ends = BTreeSet::new();
        for edge in &edges {
            for (key, corner) in ["from", "to"].into_iter().zip(&edge.corners) {
                assert_eq!(
                    vertices[edge.number(key) as usize].corners,
                    std::slice::from_ref(corner)
                );
            }
            let on_line = |line: [Point; 2]| {
                let off = |corner: &[f64]| {
                    let (dx, dy) = (line[1].x - line[0].x, line[1].y - line[0].y);
                    (dx * (corner[1] - line[0].y) - dy * (corner[0] - line[0].x)).abs()
                };
                edge.corners.iter().all(|corner| off(corner) < 1e-12)
            };
            let expected = match ring().iter().position(|&line| on_line(line)) {
                Some(0) => ("wall,obstacle", 2),
                Some(_) => ("obstacle", 7),
                None => ("wall", 4),
            };
            assert_eq!((edge.values["kind"].as_str().unwrap(), edge.number("line")), expected);
            *kinds.entry(expected).or_insert(0) += 1;
            ends.insert([edge.number("from") as usize, edge.number("to") as usize]);
        }
        assert_eq!(kinds.len(), 3);
        // Meshes have the same edges, if they are requested.
        let options = ExportOptions::default().edges(true);
        let glb = exported(&reader, Format::Glb, &options).await;
        let (_, triangles, found) = mesh_of_glb(&glb.outputs[0]);
        assert_eq!(
            (glb.edges, found.len(), triangles.len() as u64),
            (edges.len() as u64, edges.len(), glb.triangles)
        );
        assert_eq!(found.into_iter().collect::<BTreeSet<_>>(), ends);
        let without = exported(&reader, Format::Ply, &ExportOptions::default()).await;
        let with = exported(&reader, Format::Ply, &options).await;
        let count = |bytes: &[u8]| String::from_utf8_lossy(bytes).matches("element edge").count();
        assert_eq!(
            (count(&without.outputs[0]), without.edges, count(&with.outputs[0])),
            (0, 0, 1)
        );
        assert_eq!(with.edges, edges.len() as u64);
    });
}

#[test]
fn triangles_have_the_number_of_their_region() {
    runtime().block_on(async {
        let scratch = Scratch::new();
        let reader = with_lines(&scratch).await;
        for format in feature_formats().filter(|&format| format != Format::GeoJson) {
            let exported = exported(&reader, format, &ExportOptions::default().holes(true)).await;
            let (features, _) = features(format, &exported.outputs[0]);
            assert_eq!(features.len() as u64, reader.metadata().triangles);
            let (inside, outside): (Vec<_>, Vec<_>) = features.iter().partition(|feature| {
                common_area([0, 1, 2].map(|i| Point::new(feature.corners[i][0], feature.corners[i][1]))) > 1e-15
            });
            let regions = |of: &[&Feature]| {
                of.iter()
                    .map(|feature| feature.number("region"))
                    .collect::<BTreeSet<_>>()
            };
            let (inside, outside) = (regions(&inside), regions(&outside));
            assert_eq!((inside.len(), inside.is_disjoint(&outside)), (1, true), "{format}");
        }
    });
}

#[test]
fn meshes_are_exported_whole() {
    runtime().block_on(async {
        let (_scratch, reader) = built(&points_of(Kind::Grid, 100, 1), BuildOptions::default()).await;
        for format in Format::ALL.into_iter().filter(|format| !format.has_features()) {
            let outputs = format.suffixes().iter().map(|_| Vec::new()).collect();
            let options = ExportOptions::default().what(Some(What::Vertices));
            let error = export(&reader, format, options, outputs, |_, _| ()).await.unwrap_err();
            let expected = format!("format {format} consists of a whole mesh, not of vertices");
            assert!(error.to_string().contains(&expected), "{error}");
        }
    });
}

#[test]
fn coordinates_beyond_32_bits_are_no_gltf() {
    runtime().block_on(async {
        let points = [(0.0, 0.0), (1e60, 0.0), (0.0, 1.0)].map(|(x, y)| Point::new(x, y));
        let (_scratch, reader) = built(&points, BuildOptions::default()).await;
        let error = export(
            &reader,
            Format::Glb,
            ExportOptions::default(),
            vec![Vec::new()],
            |_, _| (),
        )
        .await;
        let error = error.unwrap_err().to_string();
        assert!(error.contains("32 bits") && error.contains("export PLY"), "{error}");
    });
}
