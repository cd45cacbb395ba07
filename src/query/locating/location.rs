//! The location of a point in a triangulation.

use crate::geometry::TriangleId;
use crate::store::{Tile, TileId, Vertex};

/// A triangle, identified by a tile that contains it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct TriangleRef {
    /// The tile.
    pub tile: TileId,
    /// The id of the triangle in the tile.
    pub triangle: TriangleId,
    /// The corners, counter-clockwise.
    pub vertices: [Vertex; 3],
}

impl TriangleRef {
    /// Returns the reference to a triangle of a tile.
    pub(crate) fn of(tile: &Tile, triangle: TriangleId) -> Self {
        Self {
            tile: tile.id(),
            triangle,
            vertices: tile.vertices(triangle),
        }
    }
}

/// The location of a point in a triangulation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Location {
    /// On a vertex.
    OnVertex(Vertex),
    /// Inside the edge between two vertices.
    OnEdge {
        /// The ends of the edge: corners `i` and `i + 1` of the triangle.
        ends: [Vertex; 2],
        /// A triangle at the edge.
        triangle: TriangleRef,
    },
    /// Inside a triangle.
    InTriangle(TriangleRef),
    /// Outside the hull. In a file without triangles, only the vertices are not outside.
    Outside,
}
