//! The summary of a change, as JSON and as text.

use std::path::Path;

use delaunay_tiles::{EditSummary, peak_memory};
use serde::Serialize;

use crate::common::{self, counted};

/// The output of `--json`. Its keys are stable.
#[derive(Serialize)]
pub struct EditReport {
    inserted_points: u64,
    duplicate_points: u64,
    deleted_points: u64,
    moved_points: u64,
    points_with_new_z: u64,
    skipped_points: u64,
    removed_segments: u64,
    removed_lines: u64,
    freed_edges: u64,
    removed_vertices: u64,
    skipped_lines: u64,
    inserted_sites: u64,
    deleted_sites: u64,
    skipped_sites: u64,
    segments: u64,
    added_vertices: u64,
    inserted_edges: u64,
    vertices: u64,
    triangles: u64,
    constraint_edges: u64,
    tiles_written: u64,
    tile_reads: u64,
    regions: u64,
    hole_regions: u64,
    hole_triangles: u64,
    bytes_appended: u64,
    file_bytes: u64,
    dry_run: bool,
    seconds: f64,
    peak_memory_bytes: Option<u64>,
    notes: Vec<String>,
}

impl EditReport {
    pub fn of(summary: &EditSummary, dry_run: bool, notes: Vec<String>) -> Self {
        Self {
            inserted_points: summary.points.inserted,
            duplicate_points: summary.points.duplicates,
            deleted_points: summary.points.deleted,
            moved_points: summary.points.moved,
            points_with_new_z: summary.points.z_set,
            skipped_points: summary.points.skipped,
            removed_segments: summary.lines.removed_segments,
            removed_lines: summary.lines.removed_lines,
            freed_edges: summary.lines.freed_edges,
            removed_vertices: summary.lines.removed_vertices,
            skipped_lines: summary.lines.skipped,
            inserted_sites: summary.sites.inserted,
            deleted_sites: summary.sites.deleted,
            skipped_sites: summary.sites.skipped,
            segments: summary.segments,
            added_vertices: summary.added_vertices,
            inserted_edges: summary.inserted_edges,
            vertices: summary.vertices,
            triangles: summary.triangles,
            constraint_edges: summary.constraint_edges,
            tiles_written: summary.tiles_written,
            tile_reads: summary.tile_reads,
            regions: summary.regions,
            hole_regions: summary.hole_regions,
            hole_triangles: summary.hole_triangles,
            bytes_appended: summary.bytes_appended,
            file_bytes: summary.file_bytes,
            dry_run,
            seconds: summary.seconds,
            peak_memory_bytes: peak_memory(),
            notes,
        }
    }
}

/// Returns the summary for people.
pub fn text(file: &Path, summary: &EditSummary, dry_run: bool) -> String {
    let file = common::shown(file);
    let written = match dry_run {
        true => format!(
            "{} would be, and about {} appended",
            counted(summary.tiles_written, "tile", "tiles"),
            common::bytes(summary.bytes_appended)
        ),
        false => format!(
            "{}, {} appended; the file has {}",
            counted(summary.tiles_written, "tile", "tiles"),
            common::bytes(summary.bytes_appended),
            common::bytes(summary.file_bytes)
        ),
    };
    let would = if dry_run { " (dry run: it stays as it was)" } else { "" };
    format!(
        "{file}: {}{would}\n\
         file       {}, {}, {}\n\
         regions    {}; {} with {}\n\
         written    {written}\n\
         time       {:.2} s\n",
        what_changed(summary),
        counted(summary.vertices, "vertex", "vertices"),
        counted(summary.triangles, "triangle", "triangles"),
        counted(summary.constraint_edges, "constraint edge", "constraint edges"),
        counted(summary.regions, "region", "regions"),
        counted(summary.hole_regions, "hole", "holes"),
        counted(summary.hole_triangles, "triangle", "triangles"),
        summary.seconds,
    )
}

/// Returns what was changed, in one line.
fn what_changed(summary: &EditSummary) -> String {
    let (points, sites) = (&summary.points, &summary.sites);
    let mut parts: Vec<String> = [
        ("inserted", points.inserted, ["point", "points"]),
        ("deleted", points.deleted, ["point", "points"]),
        ("moved", points.moved, ["point", "points"]),
        ("gave a new z to", points.z_set, ["point", "points"]),
        ("inserted", sites.inserted, ["site", "sites"]),
        ("deleted", sites.deleted, ["site", "sites"]),
    ]
    .into_iter()
    .filter(|(_, count, _)| *count > 0)
    .map(|(what, count, [one, more])| format!("{what} {}", counted(count, one, more)))
    .collect();
    if summary.segments > 0 {
        parts.push(format!(
            "inserted {} as {}, with {}",
            counted(summary.segments, "segment", "segments"),
            counted(summary.inserted_edges, "edge", "edges"),
            counted(summary.added_vertices, "added vertex", "added vertices"),
        ));
    }
    let lines = &summary.lines;
    if lines.removed_segments + lines.removed_lines > 0 {
        let removed = [
            (lines.removed_segments, ["segment", "segments"]),
            (lines.removed_lines, ["line", "lines"]),
        ];
        let removed = removed.into_iter().filter(|(count, _)| *count > 0);
        let removed: Vec<String> = removed.map(|(count, [one, more])| counted(count, one, more)).collect();
        parts.push(format!(
            "removed {} ({} freed, {} removed)",
            removed.join(" and "),
            counted(lines.freed_edges, "edge", "edges"),
            counted(lines.removed_vertices, "vertex", "vertices"),
        ));
    }
    for (count, [one, more], what) in [
        (points.duplicates, ["point", "points"], "at the position of another one"),
        (
            points.skipped,
            ["point", "points"],
            "left out, since they are not there",
        ),
        (
            lines.skipped,
            ["segment or line", "segments or lines"],
            "left out, since they are not there",
        ),
        (sites.skipped, ["site", "sites"], "left out, since they are not there"),
    ] {
        if count > 0 {
            parts.push(format!("{} {what}", counted(count, one, more)));
        }
    }
    match parts.is_empty() {
        true => "nothing to change".to_owned(),
        false => parts.join(", "),
    }
}
