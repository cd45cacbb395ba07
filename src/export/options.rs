//! The options of an export.

use std::sync::Arc;

use super::what::What;
use crate::terrain::{Clip, Surface};

/// The options of an export.
///
/// ```
/// use delaunay_tiles::export::{ExportOptions, What};
///
/// let options = ExportOptions::default().holes(true).max_edge(Some(50.0));
/// let edges = ExportOptions::default().what(Some(What::Edges));
/// # let _ = (options, edges);
/// ```
#[derive(Clone, Debug, Default)]
pub struct ExportOptions {
    pub(super) surface: Surface,
    pub(super) edges: bool,
    pub(super) what: Option<What>,
    pub(super) clip: Option<Arc<Clip>>,
}

impl ExportOptions {
    /// Sets whether triangles in holes are exported too; false by default. Vertices are always
    /// exported.
    #[must_use]
    pub fn holes(mut self, holes: bool) -> Self {
        self.surface = self.surface.holes(holes);
        self
    }

    /// Sets whether PLY and glTF get the constraint edges too; false by default, because strict
    /// readers of PLY refuse them. Other formats ignore it.
    #[must_use]
    pub fn edges(mut self, edges: bool) -> Self {
        self.edges = edges;
        self
    }

    /// Sets what formats of features export. By default, these are triangles, or the vertices of a
    /// file without triangles. Formats of meshes refuse anything but `None`.
    #[must_use]
    pub fn what(mut self, what: Option<What>) -> Self {
        self.what = what;
        self
    }

    /// Leaves out triangles with an edge longer than this, in units of the coordinates. Vertices and
    /// constraint edges are not affected. `None`, the default, leaves out none.
    #[must_use]
    pub fn max_edge(mut self, length: Option<f64>) -> Self {
        self.surface = self.surface.max_edge(length);
        self
    }

    /// Sets whether, of the triangles with an edge that is too long, only those are left out that are
    /// peeled off from the hull inwards, as [`Surface::from_hull`] says; false by default. All tiles are
    /// read first.
    #[must_use]
    pub fn from_hull(mut self, from_hull: bool) -> Self {
        self.surface = self.surface.from_hull(from_hull);
        self
    }

    /// Exports only triangles and edges that meet the interior of polygons, whole, and, of formats of
    /// features, only vertices that are inside or on the boundary. Formats of meshes keep all
    /// vertices, so that their numbers are the same in all exports.
    #[must_use]
    pub fn clip(mut self, clip: Option<Arc<Clip>>) -> Self {
        self.clip = clip;
        self
    }
}
