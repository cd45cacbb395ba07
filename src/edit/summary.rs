//! What an edit did.

/// What an edit did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct EditSummary {
    /// Segments that came in.
    pub segments: u64,
    /// Vertices that their ends became, where there were none.
    pub vertices: u64,
    /// Edges along them, those that were constraints before included.
    pub edges: u64,
    /// Constraint edges of the file.
    pub constraint_edges: u64,
    /// Tiles that had to be written again.
    pub tiles: u64,
    /// Tiles that were read for the lines, as often as that was.
    pub tile_reads: u64,
    /// Triangles that were looked at to follow the lines.
    pub triangles_looked_at: u64,
    /// Regions, those that are holes, and the triangles in these.
    pub regions: u64,
    /// Regions that are holes.
    pub hole_regions: u64,
    /// Triangles in holes.
    pub hole_triangles: u64,
    /// Bytes by which the file has grown.
    pub bytes_appended: u64,
    /// Bytes of the file.
    pub file_bytes: u64,
    /// Seconds that it took.
    pub seconds: f64,
}
