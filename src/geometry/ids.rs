//! Numbers of triangles and vertices that are stored in arrays.

use std::fmt;

/// A triangle of a triangulation or of a tile: its index in the arrays there.
///
/// # Example
///
/// ```
/// use delaunay_tiles::geometry::{HalfEdge, TriangleId};
///
/// let corners = [[0, 1, 2], [2, 1, 3]];
/// let triangle = HalfEdge(4).triangle();
/// assert_eq!(triangle, TriangleId(1));
/// assert_eq!(corners[triangle.index()], [2, 1, 3]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[repr(transparent)]
pub struct TriangleId(pub u32);

impl TriangleId {
    /// Returns the triangle's index in an array with an entry for each triangle.
    #[inline]
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

impl fmt::Display for TriangleId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// A vertex of a triangulation or of a tile: its index in the arrays there. In a tile, it may be a
/// corner that another tile owns.
///
/// # Example
///
/// ```
/// use delaunay_tiles::geometry::{HalfEdge, Point, VertexIndex};
/// use delaunay_tiles::mesh::{EngineKind, Topology, Triangulation};
///
/// let points = [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]].map(|[x, y]| Point::new(x, y));
/// let mut mesh = Triangulation::default();
/// EngineKind::Native.create().triangulate(&points, &mut mesh);
/// let vertex: VertexIndex = mesh.origin(HalfEdge(0));
/// assert!(points[vertex.index()].is_valid());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[repr(transparent)]
pub struct VertexIndex(pub u32);

impl VertexIndex {
    /// Returns the vertex's index in an array with an entry for each vertex.
    #[inline]
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

impl fmt::Display for VertexIndex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
