//! All levels, each from the one before.

use std::path::PathBuf;

use crate::overviews::choose::choose;
use crate::overviews::error::OverviewError;
use crate::overviews::work::Work;
use crate::store::{MAX_OVERVIEWS, TileReader};

/// Builds the levels of a file, down to one tile. Returns their files, from the finest to the coarsest.
///
/// A level has at most half of the vertices of the one before. Where that cannot be, because most vertices
/// are corners of the hull, there are no more levels. A file without triangles has none.
pub(super) async fn build_levels(base: &TileReader, work: &Work) -> Result<Vec<PathBuf>, OverviewError> {
    let mut levels = Vec::new();
    let mut fine = base.clone();
    while fine.metadata().vertices > work.tile_vertices()
        && fine.metadata().triangles > 0
        && levels.len() < MAX_OVERVIEWS
    {
        let path = choose(&fine, work, levels.len() as u32 + 1).await?;
        let coarse = work.open(&path, 1).await?;
        if coarse.metadata().vertices > fine.metadata().vertices / 2 {
            break;
        }
        levels.push(path);
        fine = coarse;
    }
    Ok(levels)
}
