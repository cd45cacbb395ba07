//! The result of an edit.

use std::ops::AddAssign;

/// The number of points that an edit changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PointCounts {
    /// Number of points that were inserted.
    pub inserted: u64,
    /// Number of points that were inserted, or moved, to the position of another one, which stays as
    /// it is.
    pub duplicates: u64,
    /// Number of points that were deleted.
    pub deleted: u64,
    /// Number of points that were moved.
    pub moved: u64,
    /// Number of points that were given a z.
    pub z_set: u64,
    /// Number of changes that were left out, since there was no point.
    pub skipped: u64,
}

impl AddAssign for PointCounts {
    fn add_assign(&mut self, other: Self) {
        self.inserted += other.inserted;
        self.duplicates += other.duplicates;
        self.deleted += other.deleted;
        self.moved += other.moved;
        self.z_set += other.z_set;
        self.skipped += other.skipped;
    }
}

/// The number of sites that an edit changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SiteCounts {
    /// Number of sites that were inserted.
    pub inserted: u64,
    /// Number of sites that were deleted.
    pub deleted: u64,
    /// Number of positions that were left out, since no site was there.
    pub skipped: u64,
}

/// The number of lines that an edit removed, and what came of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct LineCounts {
    /// Number of segments that were removed by geometry.
    pub removed_segments: u64,
    /// Number of lines that were removed by number.
    pub removed_lines: u64,
    /// Number of edges that are no constraints any more.
    pub freed_edges: u64,
    /// Number of vertices that were removed without a point: only ends of removed lines, or deleted
    /// sites, held them.
    pub removed_vertices: u64,
    /// Number of segments, and of numbers, that were left out, since no line has them.
    pub skipped: u64,
}

/// The result of an edit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct EditSummary {
    /// The points that were changed.
    pub points: PointCounts,
    /// The lines that were removed.
    pub lines: LineCounts,
    /// The sites that were changed.
    pub sites: SiteCounts,
    /// Number of segments that were inserted.
    pub segments: u64,
    /// Number of vertices that were added at their ends, and at sites.
    pub added_vertices: u64,
    /// Number of edges along the segments, including those that were constraints before.
    pub inserted_edges: u64,
    /// Number of constraint edges of the file.
    pub constraint_edges: u64,
    /// Number of vertices of the file.
    pub vertices: u64,
    /// Number of triangles of the file.
    pub triangles: u64,
    /// Number of tiles that were written again.
    pub tiles_written: u64,
    /// Number of tiles that were read for the lines. A tile counts each time that it is read.
    pub tile_reads: u64,
    /// Number of triangles that were visited to follow the lines.
    pub triangles_visited: u64,
    /// Number of regions.
    pub regions: u64,
    /// Number of regions that are holes.
    pub hole_regions: u64,
    /// Number of triangles in holes.
    pub hole_triangles: u64,
    /// Bytes by which the file has grown.
    pub bytes_appended: u64,
    /// Length of the file in bytes.
    pub file_bytes: u64,
    /// Number of transactions that are in the log, and not yet in the file, with this one. If it is not
    /// 0, the file is as it was before: all but the changes of points and the number of vertices is that
    /// of the file without these transactions.
    pub pending_transactions: u64,
    /// Duration in seconds.
    pub seconds: f64,
}
