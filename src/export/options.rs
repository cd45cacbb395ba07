//! What is exported.

/// What is exported.
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
    /// Exports triangles in holes too, which are left out otherwise. Vertices are exported in any case.
    #[must_use]
    pub fn holes(mut self, holes: bool) -> Self {
        self.holes = holes;
        self
    }
}
