//! The options of an export.

/// The options of an export.
///
/// ```
/// use delaunay_tiles::export::ExportOptions;
///
/// let options = ExportOptions::default().holes(true);
/// # let _ = options;
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct ExportOptions {
    pub(super) holes: bool,
}

impl ExportOptions {
    /// Sets whether triangles in holes are exported too; false by default. Vertices are always
    /// exported.
    #[must_use]
    pub fn holes(mut self, holes: bool) -> Self {
        self.holes = holes;
        self
    }
}
