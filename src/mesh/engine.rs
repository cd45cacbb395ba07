//! The trait of the in-core engines.

use super::triangulation::Triangulation;
use crate::geometry::Point;

/// An in-core Delaunay triangulator. It keeps its memory between calls, so each thread owns one.
pub trait Engine: Send {
    /// Replaces `mesh` by the canonical Delaunay triangulation of `points`. Ties of the
    /// empty-circle test are broken by the rule of [`in_circle`](crate::geometry::in_circle).
    ///
    /// The points must be distinct, [valid](Point::is_valid) and fewer than 2²⁹. Any order and
    /// any number, including zero, is allowed, and so is collinear input.
    fn triangulate(&mut self, points: &[Point], mesh: &mut Triangulation);
}
