//! Where a point lies.

use crate::query::locating::TriangleRef;
use crate::store::{Vertex, VertexId};

/// Where a point lies.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Spot {
    /// Within a triangle.
    Triangle(TriangleRef),
    /// Within an edge.
    Edge { ends: [Vertex; 2] },
    /// On a vertex.
    Vertex(Vertex),
    /// Outside, where it sees this edge of the hull, which has the hull on its left.
    Outside([VertexId; 2]),
}
