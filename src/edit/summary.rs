//! The result of an edit.

/// The result of an edit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct EditSummary {
    /// Number of segments of the input.
    pub segments: u64,
    /// Number of vertices that were added at their ends.
    pub added_vertices: u64,
    /// Number of edges along the segments, including those that were constraints before.
    pub inserted_edges: u64,
    /// Number of constraint edges of the file.
    pub constraint_edges: u64,
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
    /// Duration in seconds.
    pub seconds: f64,
}
