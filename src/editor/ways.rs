//! The two ways to make changes: to edit the tiles that they touch, and to build all tiles anew.

use std::sync::Arc;

use foldhash::HashSet;

use crate::edit::{EditError, EditSummary, Target, Work, edit};
use crate::editor::rebuild::{NotBuilt, rebuild, rebuild_on_one_line, rebuild_with_helpers, unchanged};
use crate::store::{Metadata, TileId};

/// The time that an edit takes for each vertex of a tile that it touches, and for each change of a
/// point, where a build takes 1 for each vertex of the file. Measured with 1 and 10 million uniform
/// points in tiles of 32,768, of which 1.5 to 10 % were inserted and deleted.
const OF_TOUCHED: f64 = 2.5;
const OF_CHANGE: f64 = 40.0;
/// The time that it takes to begin and end a build.
const OF_BUILD: f64 = 200_000.0;

/// Makes all changes. `before` is the metadata of the file. If `prefers_build` is set, few changes are
/// as good a reason to build as many.
pub(crate) async fn make(
    target: &mut Target,
    before: &Metadata,
    work: Work,
    prefers_build: bool,
    memory: u64,
) -> Result<EditSummary, EditError> {
    let has_triangles = before.triangles > 0;
    let work = Arc::new(work);
    let is_rebuilt = match has_triangles {
        true => concerns_points(&work) && (prefers_build || is_build_faster(target, before, &work).await?),
        false => concerns_points(&work) && has_points_only(before, &work),
    };
    if is_rebuilt {
        match rebuild(target, Arc::clone(&work), memory).await {
            Ok(summary) => return Ok(summary),
            Err(NotBuilt::NotBegun(error)) => tracing::debug!(%error, "the file is not built anew"),
            // An edit finds out whether anything is left besides the points.
            Err(NotBuilt::Failed(EditError::NothingLeft)) => {}
            Err(NotBuilt::Failed(error)) => return Err(error),
        }
    }
    match (has_triangles, work.is_empty()) {
        (false, true) => return unchanged(target, memory).await,
        (false, false) => return rebuild_with_helpers(target, work, memory).await,
        _ => {}
    }
    match edit(target.handed_over(), Arc::clone(&work), memory, || false).await {
        Err(EditError::NothingLeft) => rebuild_on_one_line(target, work, memory).await,
        edited => edited,
    }
}

/// Returns whether points change, and all changes are in memory.
fn concerns_points(work: &Work) -> bool {
    work.points.spilled.is_none() && !work.points.all.is_empty()
}

/// Returns whether points are all that changes and all that there is.
fn has_points_only(before: &Metadata, work: &Work) -> bool {
    let (ends, lines, sites) = (before.ends, before.constraint_edges, before.sites);
    let points_alone = work.gone.is_empty() && work.segments.is_empty() && work.sites.all.is_empty();
    [ends, lines, sites] == [0; 3] && points_alone
}

/// Returns whether it is faster to build all tiles than to edit those that points touch.
async fn is_build_faster(target: &Target, before: &Metadata, work: &Work) -> Result<bool, EditError> {
    let of_build = before.vertices as f64 + OF_BUILD;
    let calls = work.points.all.len() as f64;
    // Few changes cannot touch so many tiles. Then the directory need not be read.
    let largest = 1.5 * f64::from(before.tile_vertices);
    if calls * (2.0 * OF_TOUCHED * largest + OF_CHANGE) <= of_build {
        return Ok(false);
    }
    let reader = target.read().await?;
    let directory = reader.directory().await?;
    let positions = work.points.all.iter().flat_map(|call| call.positions()).flatten();
    let tiles: HashSet<TileId> = positions.filter_map(|point| directory.tree.tile_at(point)).collect();
    let touched = tiles.iter().filter_map(|&id| directory.entry(id));
    let touched: u64 = touched.map(|tile| u64::from(tile.vertices)).sum();
    Ok(OF_TOUCHED * touched as f64 + OF_CHANGE * calls > of_build)
}
