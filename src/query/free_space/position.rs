//! The position of a point in the triangulation.

use crate::query::locating::TriangleRef;
use crate::store::{Vertex, VertexId};

/// The position of a point in the triangulation.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Position {
    /// Inside a triangle.
    Triangle(TriangleRef),
    /// Inside an edge.
    Edge { ends: [Vertex; 2] },
    /// On a vertex.
    Vertex(Vertex),
    /// Outside the hull. The point sees this hull edge, which has the hull on its left.
    Outside([VertexId; 2]),
}
