//! The trait of the in-core engines.

use super::triangulation::Triangulation;
use crate::geometry::Point;

/// An in-core Delaunay triangulator. It keeps its memory from call to call, so each thread owns one.
pub trait Engine: Send {
    /// Replaces `mesh` by the canonical Delaunay triangulation of `points`: ties of the empty circle are broken by the
    /// rule of [`in_circle`](crate::geometry::in_circle).
    ///
    /// The points must be distinct and [valid](Point::is_valid), and fewer than 2²⁹; any order, any number, all
    /// collinear too.
    fn triangulate(&mut self, points: &[Point], mesh: &mut Triangulation);
}
