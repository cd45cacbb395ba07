//! Points that go, and with them the vertices that nothing else holds.

use std::collections::BTreeMap;

use crate::edit::contradiction::Contradiction;
use crate::edit::error::EditError;
use crate::edit::points::removal::VertexRemover;
use crate::edit::tiles::Tiles;
use crate::geometry::{Point, VertexIndex};
use crate::mesh::point_table::PointTable;
use crate::store::{TileId, VertexId};

/// Removes points, each by its tile. `has_lines` says whether any edge may be a constraint.
/// Returns the number of vertices that stay, since something else holds them.
pub(crate) fn delete(
    tiles: &mut Tiles,
    points: &mut [(TileId, Point)],
    has_lines: bool,
    is_stopped: &dyn Fn() -> bool,
) -> Result<u64, EditError> {
    points.sort_unstable_by(|a, b| a.0.cmp(&b.0).then_with(|| a.1.lex_cmp(b.1)));
    let mut remover = VertexRemover::new(has_lines);
    let mut removed: BTreeMap<TileId, Vec<VertexIndex>> = BTreeMap::new();
    let mut held = 0;
    let mut groups = points.chunk_by(|a, b| a.0 == b.0);
    while let Some(group) = groups.next() {
        tiles.read_ahead(groups.clone().map(|group| group[0].0));
        let id = group[0].0;
        let tile = tiles.get(id)?;
        let table = PointTable::new(tile.points());
        let found = group.iter().map(|&(_, point)| table.at(point).map(VertexIndex));
        let found: Option<Vec<VertexIndex>> = found.collect();
        drop(tile);
        for index in found.ok_or_else(|| tiles.damaged(id, Contradiction::NoVertices))? {
            if is_stopped() {
                return Err(EditError::Cancelled);
            }
            if remover.remove(tiles, VertexId { tile: id, index })? {
                removed.entry(id).or_default().push(index);
            } else {
                tiles.change(id)?.set_input_point(index, false);
                held += 1;
            }
        }
    }
    // Only now, since vertices get other numbers.
    for (id, vertices) in removed {
        close_up(tiles, id, &vertices)?;
    }
    Ok(held)
}

/// Forgets vertices of a tile that have no triangle any more.
fn close_up(tiles: &mut Tiles, id: TileId, vertices: &[VertexIndex]) -> Result<(), EditError> {
    let moved = tiles.change(id)?.remove_vertices(vertices);
    for vertex in moved {
        for other in vertex.tiles {
            tiles.change(other)?.rename(vertex.from, vertex.to);
        }
    }
    if tiles.get(id)?.points().is_empty() {
        tiles.set_emptied(id);
    }
    Ok(())
}
