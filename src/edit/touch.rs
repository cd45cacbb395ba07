//! Tiles whose components a line may change.

use crate::edit::error::EditError;
use crate::edit::tiles::Tiles;
use crate::geometry::{Point, Rect};
use crate::store::TileId;

/// Marks all tiles whose cells are crossed by a segment as changed.
pub(crate) fn touch_along(tiles: &mut Tiles, ends: [Point; 2]) -> Result<(), EditError> {
    let directory = tiles.directory();
    // The ends may lie outside the hull of the file.
    let bounds = Rect::around(ends).union(directory.metadata.bounds);
    let mut crossed: Vec<TileId> = Vec::new();
    directory.tree.tiles_along(bounds, ends, |tile| crossed.push(tile));
    crossed.retain(|&tile| !tiles.is_changed(tile) && !tiles.is_emptied(tile));
    for tile in crossed {
        drop(tiles.change(tile)?);
    }
    Ok(())
}
