//! The promise: however many vertices an edit adds or removes, tiles keep about the size that the
//! build gave them.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::store::{KdNode, LineKind};
use distributions::Kind;

use crate::edits::edited;
use crate::edits::scene::{Line, Scene, batch_of_line, checked, key, source};
use crate::support::{Scratch, points_of, runtime};

fn scene_of(points: &[Point]) -> Scene {
    let mut scene = Scene {
        has_z: true,
        ..Scene::default()
    };
    scene.points.extend(points.iter().map(|&p| (key(p), (p, p.x + p.y))));
    scene
}

/// Returns the number of vertices of each tile.
async fn sizes(scratch: &Scratch) -> Vec<usize> {
    let directory = scratch.open().await.directory().await.unwrap();
    let entries = directory.tile_ids().map(|id| directory.entry(id).unwrap());
    entries.map(|entry| entry.vertices as usize).collect()
}

/// Builds a few points, and adds many: all at once, in some of the cells only, with lines to the new
/// points. Then most of them go again.
async fn check_growth(kind: Kind, tile_vertices: usize, memory: u64) {
    let few = points_of(Kind::Uniform, 60, 5);
    let mut scene = scene_of(&few);
    let scratch = scene.build(tile_vertices).await.unwrap();
    let cells = sizes(&scratch).await.len();
    let far = |p: Point| Point::new(0.75 + p.x / 4.0, p.y * 2.0);
    let many: Vec<Point> = points_of(kind, 3000, 8).into_iter().map(far).collect();
    let new = scene_of(&many);
    let corners = [many[7], many[2005]];
    let line = Line {
        kind: LineKind::BreakLine,
        corners: corners.to_vec(),
        number: 0,
    };
    edited(&scratch, memory, |transaction| {
        transaction.insert(&scene.batch(new.points.values().copied())).unwrap();
        transaction.constrain(line.kind, 0, &batch_of_line(&corners)).unwrap();
        transaction.add_sources(vec![source(line.kind, 0)]);
    })
    .await
    .unwrap();
    scene.points.extend(new.points.clone());
    scene.lines.push(line);
    assert_eq!(checked(&scratch).await, checked(&scene.build(500).await.unwrap()).await);
    let large = sizes(&scratch).await;
    assert!(large.iter().all(|&size| size <= tile_vertices * 3 / 2), "{large:?}");
    assert!(large.len() > cells + 3000 / tile_vertices / 2, "{large:?}");

    let gone = many.iter().filter(|p| !corners.contains(p));
    let gone: Vec<Point> = gone.copied().take(2900).collect();
    edited(&scratch, memory, |transaction| transaction.delete(&gone).unwrap())
        .await
        .unwrap();
    scene.points.retain(|_, (point, _)| !gone.contains(point));
    assert_eq!(checked(&scratch).await, checked(&scene.build(500).await.unwrap()).await);
    let small = sizes(&scratch).await;
    assert!(3 * small.len() < large.len(), "{small:?}");
    let directory = scratch.open().await.directory().await.unwrap();
    for nodes in directory.tree.nodes().array_windows() {
        let [
            KdNode::X { .. } | KdNode::Y { .. },
            KdNode::Leaf(left),
            KdNode::Leaf(right),
        ] = nodes
        else {
            continue;
        };
        let vertices = [left, right].map(|&id| directory.entry(id).unwrap().vertices as usize);
        assert!(vertices.iter().sum::<usize>() > tile_vertices / 2, "{vertices:?}");
    }
}

#[test]
fn tiles_are_cut_and_merged_when_a_file_grows_and_shrinks() {
    runtime().block_on(async {
        for kind in [Kind::Uniform, Kind::Grid, Kind::LineSingularity] {
            for (tile_vertices, memory) in [(4, 600 << 10), (50, 600 << 10), (300, 64 << 20)] {
                println!("{kind:?} in tiles of {tile_vertices}");
                check_growth(kind, tile_vertices, memory).await;
            }
        }
    });
}

#[test]
fn a_file_that_was_never_larger_than_its_tiles_is_not_cut() {
    runtime().block_on(async {
        let points = points_of(Kind::Uniform, 1000, 3);
        let mut scene = scene_of(&points);
        let scratch = scene.build(100).await.unwrap();
        let before = sizes(&scratch).await;
        // All points move: what comes takes the place of what goes.
        let moves = points.iter().map(|&p| [p, Point::new(p.x + 1e-9, p.y)]);
        let moves: Vec<[Point; 2]> = moves.collect();
        edited(&scratch, 64 << 20, |transaction| {
            transaction.move_points(&moves).unwrap()
        })
        .await
        .unwrap();
        assert_eq!(sizes(&scratch).await.len(), before.len());
        let z_of = |p: Point| p.x + p.y;
        scene.points = moves.iter().map(|&[from, to]| (key(to), (to, z_of(from)))).collect();
        assert_eq!(checked(&scratch).await, checked(&scene.build(500).await.unwrap()).await);
    });
}
