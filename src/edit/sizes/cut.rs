//! Tiles that an edit would make too large are cut before it.

use std::collections::BTreeMap;

use crate::edit::error::EditError;
use crate::edit::sizes::coming::Coming;
use crate::edit::tile::EditTile;
use crate::edit::tile::made::{MadeTile, Renamed};
use crate::edit::tiles::Tiles;
use crate::edit::work::Work;
use crate::geometry::{Point, VertexIndex};
use crate::mesh::point_table::PointTable;
use crate::store::divide::{Item, divide};
use crate::store::{KdTree, MAX_TILE_VERTICES, TileId, VertexId};

/// The parts of a tile that is to be cut.
struct Parts {
    /// The cells, by the tiles that get them.
    tree: KdTree,
    /// The tile that gets each vertex.
    of_vertices: Vec<TileId>,
}

/// Cuts the tiles that would have more than 1.5 times the vertices of tiles of the build once all
/// vertices of an edit have come, so that no part has more than such tiles.
pub(crate) fn cut_tiles(tiles: &mut Tiles, work: &Work, is_stopped: &dyn Fn() -> bool) -> Result<(), EditError> {
    let Coming { positions, leaving } = Coming::of(tiles, work)?;
    let size = (tiles.metadata().tile_vertices as usize).clamp(1, MAX_TILE_VERTICES);
    let is_too_large = |id: &TileId, vertices: usize| {
        let left = vertices - leaving.get(id).copied().unwrap_or(0).min(vertices);
        left > size + size / 2 || vertices > MAX_TILE_VERTICES
    };
    let mut cut: BTreeMap<TileId, Parts> = BTreeMap::new();
    let mut next = tiles.directory().tiles.len() as u32;
    for group in positions.chunk_by(|a, b| a.0 == b.0) {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        let id = group[0].0;
        // Earlier parts of the changes may have brought some.
        let there = match tiles.is_changed(id) {
            true => tiles.get(id)?.points().len(),
            false => tiles.directory().entry(id).map_or(0, |entry| entry.vertices as usize),
        };
        // Some may be vertices already.
        if !is_too_large(&id, there + group.len()) {
            continue;
        }
        let tile = tiles.get(id)?;
        let table = PointTable::new(tile.points());
        let new = group.iter().map(|&(_, point)| point);
        let new: Vec<Point> = new.filter(|&point| table.at(point).is_none()).collect();
        if is_too_large(&id, there + new.len()) {
            cut.insert(id, parts(&tile, &new, size, &mut next));
        }
    }
    if cut.is_empty() {
        return Ok(());
    }
    let subtrees = cut.iter().map(|(&id, parts)| (id, parts.tree.clone()));
    tiles.add(&subtrees.collect())?;
    for (id, parts) in cut {
        cut_tile(tiles, id, &parts)?;
    }
    Ok(())
}

/// Divides the vertices of a tile, and those that come, into parts of at most `size`. New tiles get
/// the numbers from `next` on.
fn parts(tile: &EditTile, new: &[Point], size: usize, next: &mut u32) -> Parts {
    let points = tile.points().iter().chain(new).zip(0u32..);
    let mut items: Vec<Item> = points.map(|(&point, position)| Item { point, position }).collect();
    let division = divide(&mut items, size, 1);
    let there = tile.points().len();
    let mut of_vertices = vec![tile.id; there];
    let mut ids = Vec::with_capacity(division.leaves.len());
    for leaf in division.leaves {
        let vertices = items[leaf].iter().map(|item| item.position as usize);
        let vertices: Vec<usize> = vertices.filter(|&vertex| vertex < there).collect();
        // The first part with a vertex keeps the number, so that this tile never lacks vertices.
        let id = if vertices.is_empty() || ids.contains(&tile.id) {
            *next += 1;
            TileId(*next - 1)
        } else {
            tile.id
        };
        ids.push(id);
        vertices.into_iter().for_each(|vertex| of_vertices[vertex] = id);
    }
    Parts {
        tree: division.tree.with_values(&ids),
        of_vertices,
    }
}

/// Gives the vertices of a tile to the tiles of its parts.
fn cut_tile(tiles: &mut Tiles, id: TileId, parts: &Parts) -> Result<(), EditError> {
    let mut of_tiles: BTreeMap<TileId, Vec<VertexIndex>> = parts.tree.leaves().map(|leaf| (leaf, Vec::new())).collect();
    for (&tile, vertex) in parts.of_vertices.iter().zip((0..).map(VertexIndex)) {
        of_tiles.entry(tile).or_default().push(vertex);
    }
    let mut renamed = Renamed::default();
    for (&tile, vertices) in &of_tiles {
        let pairs = vertices.iter().zip((0..).map(VertexIndex));
        let pairs = pairs.map(|(&from, index)| (VertexId { tile: id, index: from }, VertexId { tile, index }));
        renamed.extend(pairs.filter(|(from, to)| from != to));
    }
    let whole = tiles.get(id)?;
    let made = of_tiles.into_iter().map(|(tile, vertices)| {
        let mut made = MadeTile::new(tile, &renamed);
        made.add_vertices(&whole, vertices.into_iter());
        made.add_triangles(&whole);
        made.finish()
    });
    let made: Vec<EditTile> = made.collect();
    let neighbours = whole.neighbours();
    drop(whole);
    for tile in made {
        let id = tile.id;
        *tiles.change(id)? = tile;
    }
    for neighbour in neighbours {
        tiles.change(neighbour)?.rename_all(&renamed);
    }
    Ok(())
}
