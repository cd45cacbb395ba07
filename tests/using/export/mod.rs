//! Every format, read back: the same vertices bit for bit, and the same triangles.

mod choices;
pub mod features;
mod parsers;

use std::error::Error;
use std::io::{self, Write};

use self::parsers::{Parsed, mesh_of_glb, parse};
use crate::support::{Scratch, batches, build_batches, built, points_of, runtime};
use delaunay_tiles::BuildOptions;
use delaunay_tiles::export::{ExportError, ExportOptions, Exported, Format, export};
use delaunay_tiles::geometry::{Point, Rect};
use delaunay_tiles::input::PointBatch;
use delaunay_tiles::store::{Digest, TileReader};
use distributions::Kind;
use futures::StreamExt;

fn tiles_of(tile_vertices: usize) -> BuildOptions {
    BuildOptions::default().tile_vertices(tile_vertices)
}

/// Returns the vertices of the file, without triangles.
async fn content(reader: &TileReader) -> Parsed {
    let mut content = Parsed::default();
    let mut tiles = reader.tiles();
    while let Some(tile) = tiles.next().await {
        let tile = tile.unwrap();
        content.points.extend(tile.points());
        content
            .z
            .extend(tile.vertex_indices().filter_map(|vertex| tile.z(vertex)));
        content
            .records
            .extend(tile.vertex_indices().map(|vertex| tile.record(vertex)));
    }
    content
}

async fn exported(reader: &TileReader, format: Format) -> Exported<Vec<u8>> {
    let outputs = format.suffixes().iter().map(|_| Vec::new()).collect();
    let (mut last, mut calls) = ((0, 0), 0);
    let exported = export(reader, format, ExportOptions::default(), outputs, |done, total| {
        calls += 1;
        assert_eq!(done, calls);
        last = (done, total);
    });
    let exported = exported.await.unwrap();
    assert_eq!(last.0, last.1, "progress");
    assert_eq!(
        exported.bytes,
        exported.outputs.iter().map(|o| o.len() as u64).sum::<u64>()
    );
    exported
}

fn bits(numbers: impl IntoIterator<Item = f64>) -> Vec<u64> {
    numbers.into_iter().map(f64::to_bits).collect()
}

/// Returns whether coordinates exceed numbers of 32 bits.
fn is_extreme(reader: &TileReader) -> bool {
    reader.metadata().bounds.max_x > f64::from(f32::MAX)
}

/// Compares a glTF file, whose coordinates are rounded, with the vertices and the digest.
fn check_glb(what: &str, bytes: &[u8], expected: &Parsed, digest: Digest) {
    let (points, triangles, edges) = mesh_of_glb(bytes);
    assert!(edges.is_empty());
    assert_eq!(points.len(), expected.points.len(), "{what}");
    let extent = Rect::around(expected.points.iter().copied());
    let most = 1e-7 * (extent.max_x - extent.min_x).max(extent.max_y - extent.min_y);
    for (point, expected) in points.iter().zip(&expected.points) {
        assert!(
            (point[0] - expected.x).abs() <= most && (point[1] - expected.y).abs() <= most,
            "{what}"
        );
    }
    for (point, z) in points.iter().zip(&expected.z) {
        assert!((point[2] - z).abs() <= most, "{what}");
    }
    let mut found = Digest::default();
    expected.points.iter().for_each(|&p| found.add_vertex(p));
    for triangle in triangles {
        found.add_triangle(triangle.map(|v| expected.points[v]));
    }
    for (&p, &z) in expected.points.iter().zip(&expected.z) {
        found.add_z(p, z);
    }
    assert_eq!(found, digest, "{what}");
}

/// Exports in every format, and compares with the file.
async fn check(name: &str, reader: &TileReader) {
    let expected = content(reader).await;
    let digest = reader.recompute_digest().await.unwrap();
    let metadata = reader.metadata();
    for format in Format::ALL
        .into_iter()
        .filter(|&format| format != Format::Glb || !is_extreme(reader))
    {
        let exported = exported(reader, format).await;
        assert_eq!(
            (exported.vertices, exported.triangles),
            (metadata.vertices, metadata.triangles)
        );
        let what = format!("{name}, {format}");
        if format == Format::Glb {
            check_glb(&what, &exported.outputs[0], &expected, digest);
            continue;
        }
        let parsed = parse(format, &exported.outputs);
        let coordinates = |points: &[Point]| bits(points.iter().flat_map(|p| [p.x, p.y]));
        assert_eq!(coordinates(&parsed.points), coordinates(&expected.points), "{what}");
        let pads_z = matches!(format, Format::Ply | Format::Obj) && !metadata.has_z;
        let z = if pads_z {
            vec![0.0; expected.points.len()]
        } else {
            expected.z.clone()
        };
        assert_eq!(bits(parsed.z), bits(z), "{what}");
        let has_records = format == Format::Ply || format.has_features() && metadata.triangles == 0;
        assert_eq!(
            &parsed.records[..],
            if has_records { &expected.records[..] } else { &[] },
            "{what}"
        );
        let mut found = Digest::default();
        parsed.points.iter().for_each(|&p| found.add_vertex(p));
        for triangle in parsed.triangles {
            found.add_triangle(triangle.map(|v| parsed.points[v]));
        }
        for (&p, &z) in parsed.points.iter().zip(&expected.z) {
            found.add_z(p, z);
        }
        assert_eq!(found, digest, "{what}");
    }
}

#[test]
fn exports_without_z_read_back_equal_the_file() {
    let line: Vec<_> = (0..100).map(|i| Point::new(f64::from(i), f64::from(3 * i))).collect();
    let extremes = [(0.0, 0.0), (1e60, 0.0), (0.0, 1e-42), (-1e60, -1e60), (0.1, 1.0 / 3.0)];
    let extremes: Vec<_> = extremes.iter().map(|&(x, y)| Point::new(x, y)).collect();
    runtime().block_on(async {
        for (name, points, tile_vertices) in [
            ("grid", points_of(Kind::Grid, 900, 1), 8),
            ("uniform", points_of(Kind::Uniform, 2000, 2), 64),
            ("uniform, one tile", points_of(Kind::Uniform, 500, 3), 1000),
            ("clusters", points_of(Kind::Clusters, 2000, 4), 32),
            ("circle", points_of(Kind::Circle, 500, 5), 8),
            ("line", line.clone(), 8),
            ("extremes", extremes, 4),
            ("two points", line[..2].to_vec(), 8),
            ("one point", line[..1].to_vec(), 8),
            ("nothing", vec![], 8),
        ] {
            let (_scratch, reader) = built(&points, tiles_of(tile_vertices)).await;
            check(name, &reader).await;
        }
    });
}

#[test]
fn exports_with_z_read_back_equal_the_file() {
    runtime().block_on(async {
        let line: Vec<_> = (0..50).map(|i| Point::new(f64::from(i), 0.0)).collect();
        for (name, points) in [("uniform", points_of(Kind::Uniform, 2000, 2)), ("line", line)] {
            let z: Vec<_> = points.iter().map(|p| p.x.mul_add(1e-9, -p.y)).collect();
            let scratch = Scratch::new();
            let batches = batches(&points, &z);
            build_batches(&scratch.path, &batches, tiles_of(16)).await.unwrap();
            let reader = scratch.open().await;
            assert!(reader.metadata().has_z);
            check(name, &reader).await;
        }
    });
}

#[test]
fn record_numbers_beyond_32_bits_are_exported_exactly() {
    runtime().block_on(async {
        for largest in [u64::from(u32::MAX), u64::from(u32::MAX) + 1, 1 << 53] {
            let points = points_of(Kind::Uniform, 300, 6);
            let batch = PointBatch {
                records: (largest - 299..=largest).collect(),
                z: vec![],
                points,
            };
            let scratch = Scratch::new();
            build_batches(&scratch.path, &[batch], tiles_of(16)).await.unwrap();
            check("large records", &scratch.open().await).await;
        }
    });
}

/// An output with room for this number of bytes.
struct Full(usize);

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = bytes.len().min(self.0);
        self.0 -= taken;
        if taken == 0 && !bytes.is_empty() {
            Err(io::ErrorKind::StorageFull.into())
        } else {
            Ok(taken)
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn an_output_that_fails_returns_an_error_that_names_it() {
    runtime().block_on(async {
        let (_scratch, reader) = built(&points_of(Kind::Uniform, 20_000, 7), tiles_of(500)).await;
        for format in Format::ALL {
            let lengths: Vec<_> = exported(&reader, format).await.outputs.iter().map(Vec::len).collect();
            for (failing, suffix) in (0..lengths.len()).zip(format.suffixes()) {
                for room in [0, 10, lengths[failing] / 2, lengths[failing] - 1] {
                    let outputs = (0..lengths.len()).map(|i| Full(if i == failing { room } else { lengths[i] }));
                    let error = export(&reader, format, ExportOptions::default(), outputs.collect(), |_, _| ())
                        .await
                        .err()
                        .unwrap();
                    assert!(matches!(error, ExportError::Write { .. }), "{format}: {error}");
                    assert!(error.to_string().contains(suffix));
                    let cause = error.source().and_then(|e| e.downcast_ref::<io::Error>()).unwrap();
                    assert_eq!(cause.kind(), io::ErrorKind::StorageFull);
                }
            }
            let outputs = lengths.into_iter().map(Full).collect();
            export(&reader, format, ExportOptions::default(), outputs, |_, _| ())
                .await
                .unwrap();
        }
    });
}

#[test]
fn two_exports_give_the_same_bytes() {
    runtime().block_on(async {
        let (_scratch, reader) = built(&points_of(Kind::Uniform, 3000, 8), tiles_of(16)).await;
        for format in Format::ALL {
            assert_eq!(
                exported(&reader, format).await.outputs,
                exported(&reader, format).await.outputs
            );
        }
    });
}
