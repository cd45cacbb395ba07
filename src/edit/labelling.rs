//! Search for the regions of an edited file, and writing of the tiles that store their triangles'
//! regions.

use crate::edit::error::EditError;
use crate::edit::regions::{RegionJoin, RegionLabels, TileParts};
use crate::edit::tile::EditTile;
use crate::edit::tiles::{TileWithParts, Tiles};
use crate::memory::EditShares;
use crate::store::{DigestSum, TileId, triangle_hash};

/// Joins adjacent parts in all tiles. Also returns the number of constraint edges.
pub(crate) fn join(
    tiles: &mut Tiles,
    memory: u64,
    is_stopped: &dyn Fn() -> bool,
) -> Result<(RegionLabels, u64), EditError> {
    let mut joining = RegionJoin::new(tiles.directory());
    let mut all_tiles = tiles.with_parts();
    while let Some(TileWithParts { tile, parts, before }) = all_tiles.next()? {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        joining.take(&tile, &parts, before.as_ref())?;
        EditShares::check_regions(memory, joining.byte_size())?;
    }
    let constraint_edges = joining.constraint_edges;
    Ok((joining.finish(tiles.metadata())?, constraint_edges))
}

/// Writes all tiles that were changed, and those in which a region changed. Returns the number of
/// triangles in holes, and the sum of their hashes.
pub(crate) fn label(
    tiles: &mut Tiles,
    labels: RegionLabels,
    is_stopped: &dyn Fn() -> bool,
) -> Result<DigestSum, EditError> {
    tiles.label(labels)?;
    let mut in_holes = DigestSum::default();
    let ids: Vec<TileId> = tiles.directory().tile_ids().collect();
    for id in ids {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        if let Some(known) = tiles.in_holes(id) {
            in_holes += known;
            continue;
        }
        let mut tile = tiles.read(id)?;
        if !tiles.is_changed(id) {
            let edit = EditTile::of(&tile);
            let parts = TileParts::of(&edit);
            // In an unchanged tile, triangles have the same numbers as in the file.
            let is_same = tiles.labels().is_none_or(|labels| {
                let label = |triangle| labels.of(id, &parts, triangle);
                tile.triangle_ids()
                    .all(|triangle| tile.component(triangle) == label(triangle))
            });
            if !is_same {
                tiles.write(edit)?;
                tile = tiles.read(id)?;
            }
        }
        let holes = tile.owned_triangles().filter(|&triangle| tile.is_hole(triangle));
        holes.for_each(|triangle| in_holes.add_hash(triangle_hash(tile.triangle_points(triangle))));
    }
    Ok(in_holes)
}
