//! Puts a patch into the tiles that have triangles of it.

use crate::edit::error::EditError;
use crate::edit::patch::Patch;
use crate::edit::tiles::Tiles;

/// Puts the new triangles in the place of the old ones, in all tiles that have some of them.
pub(crate) fn exchange(patch: &mut Patch, tiles: &mut Tiles) -> Result<(), EditError> {
    let mut at = patch.share_out();
    let mut unlinked = Vec::new();
    for share in &patch.shares {
        let id = share.tile;
        let replaced = tiles.change(id)?.replace(patch, share, &mut at);
        let open = replaced.map_err(|reason| tiles.damaged(id, reason))?;
        unlinked.extend(open.into_iter().map(|open| (id, open)));
        at.clear(share);
    }
    patch.at = at;
    // Edges between two vertices of other tiles: these know what lies across.
    for (id, open) in unlinked {
        let [from, to, _] = open;
        let other = tiles.get(from.tile)?;
        let Some(side) = other.side_between(to, from) else {
            continue;
        };
        let apex = other.from(side.prev()).id;
        drop(other);
        if apex.tile == id {
            let linked = tiles.change(id)?.link(open, apex);
            linked.map_err(|reason| tiles.damaged(id, reason))?;
        }
    }
    Ok(())
}
