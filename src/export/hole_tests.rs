//! Tests that triangles in holes are left out unless they are requested, and that vertices never
//! are.

use std::collections::HashSet;

use futures::stream::TryStreamExt;

use super::*;
use crate::geometry::{Point, TriangleId};
use crate::input::PointBatch;
use crate::pipeline::{BuildOptions, Builder};
use crate::store::relabelled::{opened, relabelled};
use crate::store::{Component, OpenOptions, Tile, TileReader};

const WIDTH: u32 = 70;

/// Returns whether all corners of a triangle are in one of two squares. One square is within a
/// tile, the other spans many.
fn is_hole(tile: &Tile, triangle: TriangleId) -> bool {
    let inside = |from: f64, to: f64| {
        let corners = tile.triangle_points(triangle);
        corners
            .iter()
            .all(|p| (from..=to).contains(&p.x) && (from..=to).contains(&p.y))
    };
    inside(2.0, 4.0) || inside(20.0, 61.0)
}

/// Builds a grid of 70 × 70 with holes of 8 and 3362 triangles. The directory says that there are
/// `hole_triangles`, which may be wrong.
async fn with_holes(tile_vertices: usize, hole_triangles: u64) -> TileReader {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("grid.tiles");
    let options = BuildOptions::default().tile_vertices(tile_vertices).threads(1);
    let points = (0..WIDTH * WIDTH).map(|i| Point::new(f64::from(i % WIDTH), f64::from(i / WIDTH)));
    let mut builder = Builder::new(&path, options).unwrap();
    let batch = PointBatch {
        points: points.collect(),
        z: Vec::new(),
        records: (0..u64::from(WIDTH * WIDTH)).collect(),
    };
    builder.push(&batch).await.unwrap();
    builder.finish().await.unwrap();
    let reader = TileReader::open(&path, OpenOptions::default()).await.unwrap();
    let label = |tile: &Tile, triangle| Component {
        is_hole: is_hole(tile, triangle),
        ..Component::default()
    };
    let file = relabelled(&reader, label, |_, _, _| (), |m| m.hole_triangles = hole_triangles);
    opened(file.await).await
}

const HOLES: u64 = 8 + 2 * 41 * 41;

async fn exported(reader: &TileReader, format: Format, holes: bool) -> Result<Exported<Vec<u8>>, ExportError> {
    let outputs = format.suffixes().iter().map(|_| Vec::new()).collect();
    export(
        reader,
        format,
        ExportOptions::default().holes(holes),
        outputs,
        |_, _| (),
    )
    .await
}

/// Returns the triangles of a file that are not in holes, by the numbers of their vertices.
async fn free_triangles(reader: &TileReader) -> HashSet<[u64; 3]> {
    let tiles: Vec<_> = reader.tiles().try_collect().await.unwrap();
    let directory = reader.directory().await.unwrap();
    let first = |tile: u32| -> u64 {
        let before = &directory.tiles[..tile as usize];
        before.iter().map(|entry| u64::from(entry.vertices)).sum()
    };
    let mut free = HashSet::new();
    for tile in tiles {
        for triangle in tile.owned_triangles().filter(|&t| !is_hole(&tile, t)) {
            free.insert(
                tile.vertices(triangle)
                    .map(|v| first(v.id.tile.0) + u64::from(v.id.index.0)),
            );
        }
    }
    free
}

#[tokio::test]
async fn triangles_in_holes_are_left_out_unless_requested() {
    for tile_vertices in [100, 65536] {
        let reader = with_holes(tile_vertices, HOLES).await;
        let free = free_triangles(&reader).await;
        let all = reader.metadata().triangles;
        assert_eq!(free.len() as u64, all - HOLES);
        for format in Format::ALL {
            for (holes, triangles) in [(false, all - HOLES), (true, all)] {
                let exported = exported(&reader, format, holes).await.unwrap();
                assert_eq!(
                    (exported.vertices, exported.triangles),
                    (u64::from(WIDTH * WIDTH), triangles)
                );
            }
        }
        let ele = exported(&reader, Format::Node, false).await.unwrap().outputs.remove(1);
        let text = String::from_utf8(ele).unwrap();
        let mut rows = text.lines().filter(|line| !line.starts_with('#')).map(|line| {
            let numbers = line.split(' ').map(|word| word.parse::<u64>().unwrap());
            numbers.collect::<Vec<_>>()
        });
        assert_eq!(rows.next().unwrap(), [all - HOLES, 3, 0]);
        let mut found = HashSet::new();
        for (row, number) in rows.zip(0..) {
            assert_eq!(row[0], number, "they are numbered consecutively");
            assert!(found.insert([row[1], row[2], row[3]]));
        }
        assert_eq!(found, free);

        let obj = exported(&reader, Format::Obj, false).await.unwrap().outputs.remove(0);
        let text = String::from_utf8(obj).unwrap();
        let rows = |letter: &str| text.lines().filter(|line| line.starts_with(letter)).count();
        assert_eq!((rows("v "), rows("f ")), ((WIDTH * WIDTH) as usize, free.len()));
        let geojson = exported(&reader, Format::GeoJson, false)
            .await
            .unwrap()
            .outputs
            .remove(0);
        let text = String::from_utf8(geojson).unwrap();
        assert_eq!(text.matches("\"Polygon\"").count(), free.len());
        assert!(!text.contains("},,") && !text.contains(",\n]") && !text.contains("[\n,"));
        let ply = exported(&reader, Format::Ply, false).await.unwrap().outputs.remove(0);
        let header = format!("element face {}\n", free.len());
        assert!(String::from_utf8_lossy(&ply).contains(&header));
        let end = ply.windows(11).position(|word| word == b"end_header\n").unwrap() + 11;
        assert_eq!(ply.len() - end, 28 * (WIDTH * WIDTH) as usize + 13 * free.len());
    }
}

/// Headers contain the number of triangles, so a directory with a wrong number of hole triangles is
/// an error.
#[tokio::test]
async fn a_wrong_count_of_hole_triangles_is_damage() {
    for hole_triangles in [1, HOLES - 1, HOLES + 1] {
        let reader = with_holes(100, hole_triangles).await;
        for format in Format::ALL {
            let error = exported(&reader, format, false).await.unwrap_err();
            assert!(error.to_string().contains("are in no hole"), "{format}: {error}");
            exported(&reader, format, true).await.unwrap();
        }
    }
}
