//! Points that come to be, and points that get other attributes.

use crate::edit::error::EditError;
use crate::edit::points::net::{Attributes, Change};
use crate::edit::tile::NewVertex;
use crate::edit::tiles::Tiles;
use crate::edit::vertices;
use crate::geometry::VertexIndex;
use crate::mesh::point_table::PointTable;
use crate::store::VertexId;

/// Makes points lie at positions, which are ordered by tile. Returns the number of vertices that
/// had no point before.
pub(crate) fn insert(tiles: &mut Tiles, changes: &[Change], is_stopped: &dyn Fn() -> bool) -> Result<u64, EditError> {
    let mut taken_over = 0;
    let mut groups = changes.chunk_by(|a, b| a.tile == b.tile);
    while let Some(group) = groups.next() {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        tiles.read_ahead(groups.clone().map(|group| group[0].tile));
        let id = group[0].tile;
        let tile = tiles.get(id)?;
        let table = PointTable::new(tile.points());
        let (mut new, mut there) = (Vec::new(), Vec::new());
        for &Change { point, after, .. } in group {
            match table.at(point).map(VertexIndex) {
                Some(index) => there.push((index, after, tile.is_input_point(index))),
                None => new.push(NewVertex {
                    point,
                    z: after.z,
                    record: after.record,
                    is_input_point: true,
                }),
            }
        }
        drop(tile);
        for (index, after, is_input_point) in there {
            taken_over += u64::from(!is_input_point);
            give(tiles, VertexId { tile: id, index }, after)?;
        }
        if !new.is_empty() {
            vertices::add(tiles, id, new)?;
        }
    }
    Ok(taken_over)
}

/// Makes a point with these attributes lie at a vertex.
fn give(tiles: &mut Tiles, id: VertexId, Attributes { z, record }: Attributes) -> Result<(), EditError> {
    let has_z = tiles.metadata().has_z;
    let mut tile = tiles.change(id.tile)?;
    tile.set_input_point(id.index, true);
    tile.set_record(id.index, record);
    if !has_z || tile.vertex(id.index).z.to_bits() == z.to_bits() {
        return Ok(());
    }
    tile.set_z(id, z);
    let others = tile.tiles_at(id.index);
    drop(tile);
    for other in others {
        tiles.change(other)?.set_z(id, z);
    }
    Ok(())
}
