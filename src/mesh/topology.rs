//! Triangles side by side, whatever they are stored in: the trait, and what is walked over it.

use crate::geometry::{HalfEdge, Point};

/// What lies on the other side of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Twin {
    /// The half-edge of the other triangle, which runs the other way.
    HalfEdge(HalfEdge),
    /// Nothing: the edge is on the hull.
    Hull,
    /// A triangle that is not in this part of the triangulation.
    Elsewhere,
}

/// A triangulation, or a part of one, whose triangles and vertices have numbers from 0 on.
pub trait Topology {
    /// The number of triangles.
    fn triangle_count(&self) -> u32;

    /// The vertex that a half-edge starts at.
    fn origin(&self, half_edge: HalfEdge) -> u32;

    /// What lies on the other side of its edge.
    fn twin(&self, half_edge: HalfEdge) -> Twin;

    /// Where a vertex lies.
    fn point(&self, vertex: u32) -> Point;
}
