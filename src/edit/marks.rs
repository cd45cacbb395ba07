//! The bits that say which edges are constraints, in all tiles that have the triangles.

use crate::edit::contradiction::Contradiction;
use crate::edit::error::EditError;
use crate::edit::tiles::Tiles;
use crate::store::VertexId;

/// Changes the bits of the first half-edges of these triangles, in all tiles that have the
/// triangles. `change` returns the new bits, given those that are set; both are those of a first
/// half-edge.
pub(crate) fn mark(tiles: &mut Tiles, triangles: &[[VertexId; 3]], change: impl Fn(u8) -> u8) -> Result<(), EditError> {
    for corners in triangles {
        let mut of_tiles = corners.map(|id| id.tile);
        of_tiles.sort_unstable();
        for id in of_tiles.chunk_by(|a, b| a == b).map(|same| same[0]) {
            if !tiles.change(id)?.mark(*corners, &change) {
                return Err(tiles.damaged(id, Contradiction::MissingTriangle));
            }
        }
    }
    Ok(())
}
