//! Exchange of the triangles of a patch in the tiles that have some of them.

use crate::edit::error::EditError;
use crate::edit::patch::Patch;
use crate::edit::tiles::Tiles;

/// Replaces the old triangles by the new ones, in all tiles that have some of them.
pub(crate) fn exchange(patch: &mut Patch, tiles: &mut Tiles) -> Result<(), EditError> {
    let mut positions = patch.share_out();
    let mut unlinked = Vec::new();
    for share in patch.shares.iter().filter(|share| !share.is_empty()) {
        let id = share.tile;
        let replaced = tiles.change(id)?.replace(patch, share, &mut positions);
        let triangles = replaced.map_err(|reason| tiles.damaged(id, reason))?;
        unlinked.extend(triangles.into_iter().map(|triangle| (id, triangle)));
        positions.clear(share);
    }
    patch.positions = positions;
    // Edges between two vertices of other tiles: these tiles know the twin.
    for (id, triangle) in unlinked {
        let [from, to, _] = triangle;
        let other = tiles.get(from.tile)?;
        let Some(half_edge) = other.half_edge_between(to, from) else {
            continue;
        };
        let apex = other.origin_vertex(half_edge.prev()).id;
        drop(other);
        if apex.tile == id {
            let linked = tiles.change(id)?.link(triangle, apex);
            linked.map_err(|reason| tiles.damaged(id, reason))?;
        }
    }
    Ok(())
}
