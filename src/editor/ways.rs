//! The two ways to make changes: to edit the tiles that they touch, and to build all tiles anew.

use std::sync::Arc;

use crate::edit::{EditError, EditSummary, Target, Work, edit};
use crate::editor::rebuild::{NotBuilt, rebuild, rebuild_on_one_line, rebuild_with_helpers, unchanged};
use crate::store::Metadata;

/// Building is faster than editing if this share of all points is changed, one in `MANY`, and then
/// only worth the while if at least `LEAST` are.
const MANY: u64 = 25;
const LEAST: u64 = 1 << 15;

/// Makes all changes. `before` is the metadata of the file. If `prefers_build` is set, few changes are
/// as good a reason to build as many.
pub(crate) async fn make(
    target: Target,
    before: &Metadata,
    mut work: Work,
    prefers_build: bool,
    memory: u64,
) -> Result<EditSummary, EditError> {
    let changes = work.points.all.len() as u64;
    let has_triangles = before.triangles > 0;
    let is_many = prefers_build || changes >= LEAST.max(before.vertices / MANY);
    let concerns_points_only = concerns_points_only(before, &work);
    if changes > 0 && concerns_points_only && (is_many || !has_triangles) {
        match rebuild(&target, work, memory).await {
            Ok(summary) => return Ok(summary),
            Err(NotBuilt::NotBegun(error, unchanged)) => {
                tracing::debug!(%error, "the file is not built anew");
                work = *unchanged;
            }
            Err(NotBuilt::Failed(error)) => return Err(error),
        }
    }
    let work = Arc::new(work);
    match (has_triangles, work.is_empty()) {
        (false, true) => return unchanged(&target, memory).await,
        (false, false) => return rebuild_with_helpers(&target, work, memory).await,
        _ => {}
    }
    match edit(target.clone(), Arc::clone(&work), memory, || false).await {
        Err(EditError::NothingLeft) => rebuild_on_one_line(&target, work, memory).await,
        edited => edited,
    }
}

/// Returns whether points are all that changes and all that there is.
fn concerns_points_only(before: &Metadata, work: &Work) -> bool {
    let (ends, lines, sites) = (before.ends, before.constraint_edges, before.sites);
    [ends, lines, sites] == [0; 3] && work.gone.is_empty() && work.segments.is_empty() && work.sites.all.is_empty()
}
