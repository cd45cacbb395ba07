//! Tests that constraint edges are written to PLY, also for files without triangles.

use std::collections::HashSet;

use futures::stream::TryStreamExt;

use super::*;
use crate::geometry::Point;
use crate::pipeline::{BuildOptions, Builder};
use crate::store::{OpenOptions, TileReader};

/// Builds a file of segments alone, in small tiles.
async fn built(segments: &[[Point; 2]]) -> TileReader {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lines.tiles");
    let options = BuildOptions::default().tile_vertices(8).threads(1);
    let mut builder = Builder::new(&path, options).unwrap();
    builder.push_segments(segments).unwrap();
    builder.finish().await.unwrap();
    TileReader::open(&path, OpenOptions::default()).await.unwrap()
}

async fn check(segments: &[[Point; 2]], edges: usize) {
    let reader = built(segments).await;
    let (mut points, mut expected) = (Vec::new(), HashSet::new());
    let bits = |p: Point| [p.x.to_bits(), p.y.to_bits()];
    for tile in reader.tiles().try_collect::<Vec<_>>().await.unwrap() {
        points.extend(tile.points().map(bits));
        let ends = tile
            .owned_constraints()
            .map(|edge| tile.ends(edge).map(|end| bits(end.point)));
        expected.extend(ends);
    }
    assert_eq!(expected.len(), edges);
    let options = ExportOptions::default().holes(true).edges(true);
    let exported = export(&reader, Format::Ply, options, vec![Vec::new()], |_, _| ())
        .await
        .unwrap();
    let bytes = &exported.outputs[0];
    let header = format!("element edge {edges}\nproperty uint vertex1\nproperty uint vertex2\nend_header\n");
    assert!(bytes.windows(header.len()).any(|window| window == header.as_bytes()));
    let (numbers, _) = bytes[bytes.len() - 8 * edges..].as_chunks::<4>();
    let found = numbers
        .chunks(2)
        .map(|ends| [ends[0], ends[1]].map(|end| points[u32::from_le_bytes(end) as usize]));
    assert_eq!(found.collect::<HashSet<_>>(), expected);
}

#[tokio::test]
async fn constraint_edges_are_written_with_and_without_triangles() {
    let on = |i: i32| Point::new(f64::from(i), f64::from(5 - i));
    let line: Vec<_> = (0..2500).map(|i| [on(2 * i), on(2 * i + 2)]).collect();
    check(&line, 2500).await;
    check(
        &[line, vec![[Point::new(0.0, 0.0), Point::new(3.0, 1.0)]]].concat(),
        2501,
    )
    .await;
}
