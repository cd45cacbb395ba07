//! The z of a vertex, in its tile and in all tiles that have it as a corner.

use crate::edit::error::EditError;
use crate::edit::tiles::Tiles;
use crate::store::VertexId;

/// Gives a vertex a z, if the file has z.
pub(crate) fn give_z(tiles: &mut Tiles, id: VertexId, z: f64) -> Result<(), EditError> {
    let has_z = tiles.metadata().has_z;
    if !has_z || tiles.get(id.tile)?.vertex(id.index).z.to_bits() == z.to_bits() {
        return Ok(());
    }
    let mut tile = tiles.change(id.tile)?;
    tile.set_z(id, z);
    let others = tile.tiles_at(id.index);
    drop(tile);
    for other in others {
        tiles.change(other)?.set_z(id, z);
    }
    Ok(())
}
