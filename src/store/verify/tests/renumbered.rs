//! Numbers of tiles have no meaning: files with other numbers, some of them unused, are right too.

use super::model::{Model, ModelTile, Named, pair, run, smallest_first};
use super::town::towns;
use crate::store::format::ids::{TileId, VertexId};
use crate::store::format::kd_tree::{KdNode, KdTree};
use crate::store::format::line_part::LinePart;

/// Numbers the tiles from right to left, by even numbers only.
fn renumbered(model: &Model) -> Model {
    let last = model.tiles.len() as u32 - 1;
    let tile = |id: TileId| TileId(2 * (last - id.0));
    let vertex = |v: VertexId| VertexId {
        tile: tile(v.tile),
        ..v
    };
    let named = |t: &Named| smallest_first(t.map(vertex));
    let edge = |e: &[VertexId; 2]| pair(vertex(e[0]), vertex(e[1]));
    let sources = |(e, sources): (&[VertexId; 2], &Vec<LinePart>)| {
        let is_turned = edge(e) != e.map(vertex);
        let seen = sources.iter().map(|s| if is_turned { s.reversed() } else { *s });
        (edge(e), seen.collect())
    };
    let of_tile = |old: &ModelTile| ModelTile {
        points: old.points.clone(),
        z: old.z.clone(),
        input_points: old.input_points.clone(),
        core: old.core.iter().map(named).collect(),
        border: old.border.iter().map(named).collect(),
        beliefs: old.beliefs.iter().map(|(&v, &p)| (vertex(v), p)).collect(),
        z_beliefs: old.z_beliefs.iter().map(|(&v, &z)| (vertex(v), z)).collect(),
        constraints: old.constraints.iter().map(edge).collect(),
        walls: old.walls.iter().map(edge).collect(),
        sources: old.sources.iter().map(sources).collect(),
        labels: old.labels.iter().map(|(t, &label)| (named(t), label)).collect(),
        sites: old.sites.clone(),
    };
    let mut tiles = vec![ModelTile::default(); 2 * model.tiles.len() - 1];
    for (old, id) in model.tiles.iter().zip(0..) {
        tiles[tile(TileId(id)).0 as usize] = of_tile(old);
    }
    let nodes = model.directory.tree.nodes().iter().map(|node| match *node {
        KdNode::Leaf(id) => KdNode::Leaf(tile(id)),
        cut => cut,
    });
    let mut directory = model.directory.clone();
    directory.tree = KdTree::new(nodes.collect()).unwrap();
    Model {
        directory,
        tiles,
        surplus: model.surplus,
        table_changes: Vec::new(),
    }
}

#[test]
fn files_with_other_numbers_of_tiles_are_valid_and_have_the_same_digest() {
    for town in towns() {
        let model = renumbered(&town.model);
        model.verify().unwrap();
        let [new, old] =
            [&model, &town.model].map(|model| run(async { model.open().await.recompute_digest().await.unwrap() }));
        assert_eq!(new, old);
        let reader = run(model.open());
        let directory = run(reader.directory()).unwrap();
        let ids: Vec<u32> = directory.tile_ids().map(|id| id.0).collect();
        assert!(ids.is_sorted_by(|a, b| a > b) && ids.len() == town.model.tiles.len());
        // Scans go in the order of the leaves.
        let scanned: Vec<u32> = run(async {
            use futures::stream::TryStreamExt;
            reader.tiles().map_ok(|tile| tile.id().0).try_collect().await.unwrap()
        });
        assert_eq!(scanned, ids);
    }
}
