//! Search for the regions of an edited file, and writing of the component tables that state them.

use crate::edit::contradiction::Contradiction;
use crate::edit::error::EditError;
use crate::edit::regions::{RegionJoin, RegionLabels};
use crate::edit::tiles::Tiles;
use crate::edit::touch::touch_along;
use crate::edit::work::Work;
use crate::memory::EditShares;
use crate::store::TileId;

/// Marks all tiles whose cells are crossed by a line as changed: their components may not be those
/// in their tables any more.
///
/// A tile whose cell no constraint crosses is connected within its cell, which is convex, even if
/// its triangles are not connected within the tile. So its table stays valid as long as no line
/// crosses the cell.
pub(crate) fn touch_crossed(tiles: &mut Tiles, work: &Work, is_stopped: &dyn Fn() -> bool) -> Result<(), EditError> {
    if work.is_draft {
        // There are no tables yet.
        return Ok(());
    }
    for number in 0..work.piece_count() {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        touch_along(tiles, work.piece(number).ends.map(|end| work.point(end)))?;
    }
    Ok(())
}

/// Joins the components of all tiles. All changes must be written. If the file is a draft, whose regions
/// are not known, it reads all tiles, else those that were changed and their neighbours.
pub(crate) fn join(
    tiles: &mut Tiles,
    is_draft: bool,
    memory: u64,
    is_stopped: &dyn Fn() -> bool,
) -> Result<RegionLabels, EditError> {
    let check = |joining: &RegionJoin| match is_stopped() {
        true => Err(EditError::Cancelled),
        false => EditShares::check_regions(memory, joining.byte_size()).map_err(EditError::from),
    };
    let directory = tiles.directory();
    let mut is_fresh = vec![is_draft; directory.tiles.len()];
    let ids: Vec<TileId> = tiles.ids().collect();
    for &id in &ids {
        is_fresh[id.0 as usize] |= tiles.is_changed(id);
    }
    let mut joining = RegionJoin::new(directory, is_fresh);
    let (fresh, known): (Vec<TileId>, Vec<TileId>) = ids.into_iter().partition(|&id| joining.is_fresh(id));
    for id in known {
        let (table, components) = tiles.table(id)?;
        joining.know(id, components, table)?;
        check(&joining)?;
    }
    let joined = joining.join_known();
    joined.map_err(|tile| tiles.damaged(tile, Contradiction::Components))?;
    let mut surveys = tiles.surveys(fresh);
    while let Some(survey) = surveys.next()? {
        joining.take(survey)?;
        check(&joining)?;
    }
    for id in joining.neighbours() {
        joining.meet(&tiles.read(id)?);
        check(&joining)?;
    }
    let labels = joining.finish(tiles.metadata());
    labels.map_err(|tile| tiles.damaged(tile, Contradiction::MissingTriangle))
}

/// Writes the component tables that are not as they were.
pub(crate) fn label(tiles: &Tiles, mut tables: Vec<Vec<u8>>, is_stopped: &dyn Fn() -> bool) -> Result<(), EditError> {
    for id in tiles.ids() {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        tiles.put_table(id, std::mem::take(&mut tables[id.0 as usize]))?;
    }
    Ok(())
}
