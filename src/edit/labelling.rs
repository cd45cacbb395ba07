//! Search for the regions of an edited file, and writing of the tiles that store their triangles'
//! regions.

use crate::edit::error::EditError;
use crate::edit::regions::{RegionJoin, RegionLabels, TileParts};
use crate::edit::tile::EditTile;
use crate::edit::tiles::{TileWithParts, Tiles};
use crate::memory::EditShares;
use crate::store::TileId;

/// Joins adjacent parts in all tiles. Also returns the number of constraint edges.
pub(crate) fn join(
    tiles: &mut Tiles,
    memory: u64,
    is_stopped: &dyn Fn() -> bool,
) -> Result<(RegionLabels, u64), EditError> {
    let metadata = tiles.metadata().clone();
    let mut joining = RegionJoin::new(&metadata);
    let mut all_tiles = tiles.with_parts();
    while let Some(TileWithParts { tile, parts, before }) = all_tiles.next()? {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        joining.take(&tile, &parts, before.as_ref())?;
        EditShares::check_regions(memory, joining.byte_size())?;
    }
    let constraint_edges = joining.constraint_edges;
    Ok((joining.finish(&metadata)?, constraint_edges))
}

/// Writes all tiles that were changed, and those in which a region changed. Returns the number of
/// triangles in holes.
pub(crate) fn label(tiles: &mut Tiles, labels: RegionLabels, is_stopped: &dyn Fn() -> bool) -> Result<u64, EditError> {
    tiles.label(labels)?;
    let mut in_holes = 0;
    for id in (0..tiles.directory().tiles.len() as u32).map(TileId) {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        if let Some(known) = tiles.in_holes(id) {
            in_holes += u64::from(known);
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
        in_holes += holes.count() as u64;
    }
    Ok(in_holes)
}
