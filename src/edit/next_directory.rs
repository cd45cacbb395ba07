//! The directory of the next state of a file.

use crate::edit::work::Work;
use crate::store::{Digest, Directory, Metadata, hull_edges, polygon_lines_in_order};

/// The changes of a file's directory, besides its tiles.
#[derive(Clone, Copy)]
pub(crate) struct EditTotals {
    /// Number of vertices without a point of the input.
    pub(crate) ends: u64,
    pub(crate) sites: u64,
    pub(crate) removes_lines: bool,
    pub(crate) regions: u64,
    pub(crate) spanning_regions: u64,
    pub(crate) hole_regions: u64,
    pub(crate) digest: Digest,
}

/// Enters an edit in the directory, whose tiles are up to date.
pub(crate) fn enter(directory: &mut Directory, work: &Work, totals: EditTotals) {
    let tiles = &directory.tiles;
    let before = directory.metadata.clone();
    let vertices = tiles.iter().map(|tile| u64::from(tile.vertices)).sum();
    let triangles = tiles.iter().map(|tile| u64::from(tile.owned_triangles)).sum();
    let new_lines = work.lines.iter().map(|source| source.first + source.lines).max();
    directory.lists.sources.extend_from_slice(&work.points.sources);
    directory.lists.lines.extend_from_slice(&work.lines);
    let lists = &mut directory.lists;
    let mut polygon_lines = std::mem::take(&mut lists.polygon_lines);
    polygon_lines.extend_from_slice(&work.polygon_lines);
    lists.polygon_lines = polygon_lines_in_order(polygon_lines, &lists.lines);
    directory.metadata = Metadata {
        vertices,
        triangles,
        hull_edges: hull_edges(vertices, triangles),
        ends: totals.ends,
        sites: totals.sites,
        constraint_edges: totals.digest.constraint_edges.count,
        regions: totals.regions,
        spanning_regions: totals.spanning_regions,
        hole_regions: totals.hole_regions,
        hole_triangles: totals.digest.holes.count,
        next_record: before.next_record.saturating_add(work.new_records),
        next_site: before.next_site.saturating_add(work.sites.all.len() as u64),
        next_line: before.next_line.max(new_lines.unwrap_or(0)),
        last_transaction: before
            .last_transaction
            .saturating_add(work.earlier_transactions)
            .saturating_add(u64::from(work.changes_what_was_built() && !work.is_counted)),
        line_removals: before.line_removals.saturating_add(totals.removes_lines.into()),
        digest: totals.digest,
        ..before
    };
}
