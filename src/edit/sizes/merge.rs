//! Small tiles that are siblings in the k-d tree are merged after vertices went.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use crate::edit::error::EditError;
use crate::edit::tile::EditTile;
use crate::edit::tile::made::{MadeTile, Renamed};
use crate::edit::tiles::Tiles;
use crate::geometry::VertexIndex;
use crate::store::{TileId, VertexId};

/// Merges siblings that together have at most half of the vertices of tiles of the build. `counts`
/// has the numbers of vertices of the tiles that lost some. `has_lines` says whether any edge of the
/// file may be a constraint.
pub(crate) fn merge_tiles(
    tiles: &mut Tiles,
    mut counts: BTreeMap<TileId, usize>,
    has_lines: bool,
) -> Result<(), EditError> {
    if counts.is_empty() {
        return Ok(());
    }
    let most = tiles.metadata().tile_vertices as usize / 2;
    loop {
        let mut is_done = true;
        let tree = tiles.directory().tree.without(|id: TileId| tiles.is_emptied(id));
        for pair in tree.sibling_leaves() {
            // Tiles that lost none have at least the vertices that they had.
            let known = pair.map(|id| counts.get(&id).copied().unwrap_or_else(|| at_least(tiles, id)));
            if known.iter().sum::<usize>() > most {
                continue;
            }
            for id in pair {
                if let Entry::Vacant(entry) = counts.entry(id) {
                    entry.insert(tiles.get(id)?.points().len());
                }
            }
            let vertices = pair.iter().map(|id| counts[id]).sum();
            if vertices <= most {
                merge(tiles, pair, has_lines)?;
                counts.insert(pair[0], vertices);
                // The tile that is left may have a sibling in turn.
                is_done = false;
            }
        }
        if is_done {
            return Ok(());
        }
    }
}

/// Returns the number of vertices that a tile had.
fn at_least(tiles: &Tiles, id: TileId) -> usize {
    tiles.directory().entry(id).map_or(0, |entry| entry.vertices as usize)
}

/// Gives the vertices of the second tile to the first.
fn merge(tiles: &mut Tiles, [to, from]: [TileId; 2], has_lines: bool) -> Result<(), EditError> {
    let [first, second] = [tiles.get(to)?, tiles.get(from)?];
    let is_on_one_line = |tile: &EditTile| !tile.points().is_empty() && tile.leaving(VertexIndex(0)).is_none();
    if has_lines && (is_on_one_line(&first) || is_on_one_line(&second)) {
        // A tile has its constraints at the edges of its triangles.
        return Err(EditError::NothingLeft);
    }
    let own = first.points().len() as u32;
    let vertex = |tile, index| VertexId {
        tile,
        index: VertexIndex(index),
    };
    let moved = 0..second.points().len() as u32;
    let renamed: Renamed = moved
        .map(|index| (vertex(from, index), vertex(to, own + index)))
        .collect();
    let mut made = MadeTile::new(to, &renamed);
    for tile in [&first, &second] {
        made.add_vertices(tile, (0..tile.points().len() as u32).map(VertexIndex));
    }
    made.add_triangles(&first);
    made.add_triangles(&second);
    let made = made.finish();
    let neighbours = second.neighbours();
    drop((first, second));
    *tiles.change(to)? = made;
    *tiles.change(from)? = EditTile::empty(from);
    tiles.set_emptied(from);
    for neighbour in neighbours.into_iter().filter(|&neighbour| neighbour != to) {
        tiles.change(neighbour)?.rename_all(&renamed);
    }
    Ok(())
}
