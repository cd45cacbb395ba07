//! The vertices at positions.

use crate::edit::error::EditError;
use crate::edit::tiles::Tiles;
use crate::edit::vertex::EditVertex;
use crate::geometry::{Point, VertexIndex};
use crate::mesh::point_table::PointTable;
use crate::store::TileId;

/// Returns the vertex at each position, if there is one.
pub(crate) fn find_vertices(
    tiles: &Tiles,
    points: Vec<Point>,
    is_stopped: &dyn Fn() -> bool,
) -> Result<Vec<Option<EditVertex>>, EditError> {
    let mut found = vec![None; points.len()];
    let tree = &tiles.directory().tree;
    let by_tile = points.into_iter().zip(0u32..);
    let by_tile = by_tile.filter_map(|(point, number)| Some((tree.tile_at(point)?, number, point)));
    let mut by_tile: Vec<(TileId, u32, Point)> = by_tile.collect();
    by_tile.sort_unstable_by_key(|&(tile, number, _)| (tile, number));
    let mut groups = by_tile.chunk_by(|a, b| a.0 == b.0);
    while let Some(group) = groups.next() {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        tiles.read_ahead(groups.clone().map(|group| group[0].0));
        let tile = tiles.get(group[0].0)?;
        let table = PointTable::for_searches(tile.points(), group.len());
        for &(_, number, point) in group {
            found[number as usize] = table.at(point).map(|index| tile.vertex(VertexIndex(index)));
        }
    }
    Ok(found)
}
