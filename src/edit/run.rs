//! An edit from start to end: vertices, segments, regions, the directory.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use tokio::runtime::Handle;
use tokio::sync::oneshot;

use crate::edit::disk::Purpose;
use crate::edit::ends::find_ends;
use crate::edit::error::EditError;
use crate::edit::held::GoingPoints;
use crate::edit::labelling::{join, label, touch_crossed};
use crate::edit::next_directory::{EditTotals, enter};
use crate::edit::point_parts;
use crate::edit::points::{self, Gone};
use crate::edit::regions::RegionLabels;
use crate::edit::sites;
use crate::edit::sizes::merge_tiles;
use crate::edit::strip::{LocatedSegment, SegmentInserter};
use crate::edit::summary::{EditSummary, LineCounts, PointCounts, SiteCounts};
use crate::edit::target::Target;
use crate::edit::tiles::Tiles;
use crate::edit::unconstrain::{self, Removed};
use crate::edit::vertex::EditVertex;
use crate::edit::work::Work;
use crate::geometry::{MortonSquare, Point, Rect};
use crate::io::start_thread;
use crate::memory::EditShares;
use crate::store::TileId;

/// Makes segments constraints of a file, on a thread of its own.
pub(crate) async fn edit(
    target: Target,
    work: Arc<Work>,
    memory: u64,
    is_cancelled: impl Fn() -> bool + Send + 'static,
) -> Result<EditSummary, EditError> {
    let stop = StopOnDrop(Arc::new(AtomicBool::new(false)));
    let stopped = Arc::clone(&stop.0);
    let (reply, done) = oneshot::channel();
    let runtime = Handle::current();
    let path = target.path.clone();
    let task = move || {
        let is_stopped = || stopped.load(Ordering::Relaxed) || is_cancelled();
        let edited = edit_here(target, &work, memory, &is_stopped, runtime);
        // Before the reply: whoever gets it may lock anew what this holds a lock of.
        drop(is_cancelled);
        // If the receiver is gone, the result is not needed.
        let _ = reply.send(edited);
    };
    start_thread("tile-edit", task).map_err(|error| EditError::io(&path, "start a thread to edit", error))?;
    let gone = |_| EditError::Internal("the editing thread is gone".to_owned());
    done.await.map_err(gone)?
}

/// Stops the thread when nothing waits for its result any more.
struct StopOnDrop(Arc<AtomicBool>);

impl Drop for StopOnDrop {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

fn edit_here(
    target: Target,
    work: &Work,
    memory: u64,
    is_stopped: &dyn Fn() -> bool,
    runtime: Handle,
) -> Result<EditSummary, EditError> {
    let began = Instant::now();
    let segments = work.segments.len() as u64;
    let input = [
        work.points.memory() + work.sites.memory(),
        segments + work.gone.segments.len() as u64,
    ];
    let shares = |largest| EditShares::new(memory, input, work.threads, largest);
    let mut tiles = Tiles::open(target, &shares, purpose(work), !work.segments.is_empty(), runtime)?;
    let (changed, totals) = match write_tiles(&mut tiles, work, memory, is_stopped) {
        Ok(written) => written,
        Err(error) => {
            // Nothing refers to what was written, so it does no harm if it stays.
            let _ = tiles.abandon();
            return Err(error);
        }
    };
    let (tiles_written, tile_reads, length_before) = (tiles.count_changed(), tiles.reads(), tiles.length());
    // An edit that changes nothing must not make overviews stale.
    let is_empty = tiles_written == 0 && work.segments.is_empty();
    let file_bytes = match work.is_dry_run || is_empty {
        true => tiles.abandon()?,
        false => tiles.publish(|directory| enter(directory, work, totals))?,
    };
    let digest = totals.digest;
    Ok(EditSummary {
        points: changed.points,
        lines: changed.lines,
        sites: changed.sites,
        segments,
        added_vertices: changed.added_ends,
        inserted_edges: changed.edges,
        constraint_edges: digest.constraint_edges.count,
        vertices: digest.vertices.count,
        triangles: digest.triangles.count,
        tiles_written: tiles_written as u64,
        tile_reads,
        triangles_visited: changed.examined,
        regions: totals.regions,
        hole_regions: totals.hole_regions,
        hole_triangles: digest.holes.count,
        bytes_appended: file_bytes - length_before,
        file_bytes,
        pending_transactions: 0,
        seconds: began.elapsed().as_secs_f64(),
    })
}

/// Makes all changes, and writes the tiles with their regions. Nothing refers to them yet.
fn write_tiles(
    tiles: &mut Tiles,
    work: &Work,
    memory: u64,
    is_stopped: &dyn Fn() -> bool,
) -> Result<(Changed, EditTotals), EditError> {
    let changed = make_changes(tiles, work, is_stopped)?;
    touch_crossed(tiles, work, is_stopped)?;
    tiles.flush()?;
    let labels = match tiles.has_regions() {
        true => join(tiles, work.is_draft, memory, is_stopped)?,
        false => RegionLabels::default(),
    };
    if let Some(inverted) = work.inverted {
        return Err(EditError::Inverted(inverted));
    }
    if let Some(overlapping) = work.overlapping {
        return Err(EditError::Overlapping(overlapping));
    }
    if tiles.has_regions() {
        label(tiles, labels.tables, is_stopped)?;
    }
    let digest = tiles.digest(labels.holes)?;
    if digest.triangles.count == 0 && changed.has_lines {
        return Err(EditError::NothingLeft);
    }
    let totals = EditTotals {
        ends: changed.ends,
        removes_lines: changed.lines.removed_segments + changed.lines.removed_lines > 0,
        sites: (tiles.metadata().sites + changed.sites.inserted).saturating_sub(changed.sites.deleted),
        regions: labels.regions,
        spanning_regions: labels.spanning,
        hole_regions: labels.hole_regions,
        digest,
    };
    Ok((changed, totals))
}

fn purpose(work: &Work) -> Purpose {
    match (work.is_dry_run, work.is_draft) {
        (true, _) => Purpose::DryRun,
        (false, true) => Purpose::Draft,
        (false, false) => Purpose::Commit,
    }
}

/// What was changed in the tiles.
struct Changed {
    points: PointCounts,
    lines: LineCounts,
    sites: SiteCounts,
    /// Number of vertices that were added at ends of segments and at sites.
    added_ends: u64,
    /// Number of vertices of the file without a point of the input.
    ends: u64,
    /// Number of edges along the segments.
    edges: u64,
    /// Number of triangles that were examined to follow the segments.
    examined: u64,
    /// Whether any edge of the file may be a constraint.
    has_lines: bool,
}

/// Makes all changes in the tiles: points that come, sites, lines that go, lines that come, and then
/// the vertices that nothing holds. Before and after, the tiles get their sizes.
fn make_changes(tiles: &mut Tiles, work: &Work, is_stopped: &dyn Fn() -> bool) -> Result<Changed, EditError> {
    let (mut inserted, former) = point_parts::insert(tiles, work, is_stopped)?;
    let going = GoingPoints::new(&mut inserted.delete);
    let left_without_point = former.count;
    let Removed {
        counts: mut lines,
        ends: mut freed,
    } = unconstrain::remove(tiles, &work.gone, is_stopped)?;
    let frees_vertices = !freed.is_empty() || !going.is_empty() || former.count > 0;
    let (ends, mut added_ends) = find_ends(tiles, work, frees_vertices.then_some(&going), is_stopped)?;
    let SegmentInserter { edges, examined, .. } = insert(tiles, work, &ends, is_stopped)?;
    drop(ends);
    // Sites split only edges that stay.
    let has_lines = !work.segments.is_empty() || tiles.metadata().constraint_edges + inserted.split > lines.freed_edges;
    let segments = work.segments.len() as u64;
    let first_record = tiles
        .metadata()
        .next_record
        .saturating_add(work.points.records + 2 * segments);
    let sites = sites::change(tiles, &work.sites, work.missing_z, &going, first_record, is_stopped)?;
    added_ends += sites.added_vertices;
    freed.extend(sites.freed);
    let (former, mut left) = former.delete(tiles, has_lines, is_stopped)?;
    let points = inserted
        .delete
        .into_iter()
        .map(|(tile, point)| (tile, point, Gone::Point));
    let ends = freed.into_iter().map(|(tile, point)| (tile, point, Gone::End));
    let deleted = points::delete(tiles, points.chain(ends).collect(), has_lines, is_stopped)?;
    lines.removed_vertices = deleted.ends;
    left.extend(deleted.left);
    forget_unused(tiles)?;
    merge_tiles(tiles, left, has_lines)?;
    Ok(Changed {
        points: inserted.counts,
        lines,
        sites: sites.counts,
        added_ends,
        // Saturating, since a hostile file may count wrongly.
        ends: (tiles.metadata().ends + added_ends + left_without_point + deleted.held)
            .saturating_sub(inserted.taken_over + former + deleted.ends),
        edges,
        examined,
        has_lines,
    })
}

/// Forgets tiles that were added for vertices which did not come.
fn forget_unused(tiles: &mut Tiles) -> Result<(), EditError> {
    let added: Vec<TileId> = tiles.added().collect();
    for id in added {
        if tiles.get(id)?.points().is_empty() {
            tiles.set_emptied(id);
        }
    }
    Ok(())
}

/// Makes all segments constraints, between the vertices at their ends.
fn insert(
    tiles: &mut Tiles,
    work: &Work,
    ends: &[EditVertex],
    is_stopped: &dyn Fn() -> bool,
) -> Result<SegmentInserter, EditError> {
    let mut inserter = SegmentInserter::default();
    for segment in in_curve_order(work, ends) {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        inserter.insert(tiles, segment)?;
    }
    Ok(inserter)
}

/// Returns the segments that become constraints in the order of a space-filling curve, so that
/// segments that cross the same tiles come together. `ends` has the vertices at all ends.
fn in_curve_order(work: &Work, ends: &[EditVertex]) -> impl Iterator<Item = LocatedSegment> {
    let middle = |number: u32| {
        let [a, b] = work.piece(number).ends.map(|end| work.point(end));
        Point::new((a.x + b.x) / 2.0, (a.y + b.y) / 2.0)
    };
    let numbers = 0..work.piece_count();
    let square = MortonSquare::around(Rect::around(numbers.clone().map(middle)));
    let mut order: Vec<(u64, u32)> = numbers.map(|number| (square.key(middle(number)), number)).collect();
    order.sort_unstable();
    order.into_iter().map(move |(_, number)| {
        let piece = work.piece(number);
        LocatedSegment {
            ends: piece.ends.map(|end| ends[end as usize]),
            source: piece.source,
        }
    })
}

#[cfg(test)]
mod tests {
    use std::thread;
    use std::time::Duration;

    use super::*;

    /// Sets a flag when it is dropped, which takes a while.
    struct Slow(Arc<AtomicBool>);

    impl Drop for Slow {
        fn drop(&mut self) {
            thread::sleep(Duration::from_millis(50));
            self.0.store(true, Ordering::Relaxed);
        }
    }

    #[tokio::test]
    async fn what_a_callback_holds_is_dropped_before_the_result_comes() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let is_dropped = Arc::new(AtomicBool::new(false));
        let slow = Slow(Arc::clone(&is_dropped));
        let is_cancelled = move || {
            let _ = &slow;
            false
        };
        let target = Target::lock(file.path()).unwrap();
        let edited = edit(target, Arc::default(), 1 << 20, is_cancelled).await;
        assert!(edited.is_err(), "an empty file was edited");
        assert!(is_dropped.load(Ordering::Relaxed));
    }
}
