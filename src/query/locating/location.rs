//! Where points lie.

use crate::geometry::TriangleId;
use crate::store::{Tile, TileId, Vertex};

/// A triangle, by a tile that holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct TriangleRef {
    /// The tile.
    pub tile: TileId,
    /// Its number there.
    pub triangle: TriangleId,
    /// Its corners, counter-clockwise.
    pub vertices: [Vertex; 3],
}

impl TriangleRef {
    /// A triangle of a tile.
    pub(crate) fn of(tile: &Tile, triangle: TriangleId) -> Self {
        Self {
            tile: tile.id(),
            triangle,
            vertices: tile.vertices(triangle),
        }
    }
}

/// Where a point lies in a triangulation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Location {
    /// On a vertex.
    OnVertex(Vertex),
    /// Within the edge between two vertices.
    OnEdge {
        /// The ends of the edge: corners `i` and `i + 1` of the triangle.
        ends: [Vertex; 2],
        /// A triangle that the edge is a side of.
        triangle: TriangleRef,
    },
    /// Within a triangle.
    InTriangle(TriangleRef),
    /// Outside the hull. A file without triangles has nothing inside but its vertices.
    Outside,
}
