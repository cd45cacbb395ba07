//! The place of a point in a triangulation, in few bytes.

use super::location::{Location, TriangleRef};
use crate::geometry::{HalfEdge, TriangleId};
use crate::store::{Tile, TileId, VertexId};

/// The place of a point in a triangulation: a [`Location`] in 16 bytes, without the vertices.
///
/// The [example of `TileReader::locate_many`](crate::store::TileReader::locate_many) uses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Place {
    /// Outside the hull. In a file without triangles, only the vertices are not outside.
    Outside,
    /// Inside a triangle.
    InTriangle {
        /// A tile that has the triangle.
        tile: TileId,
        /// The id of the triangle in the tile.
        triangle: TriangleId,
    },
    /// Inside an edge of a triangle.
    OnEdge {
        /// A tile that has the triangle.
        tile: TileId,
        /// The id of a triangle at the edge.
        triangle: TriangleId,
        /// The corner of the triangle at which the edge starts, counter-clockwise: 0, 1 or 2.
        corner: u8,
    },
    /// On a vertex.
    OnVertex {
        /// The vertex.
        vertex: VertexId,
        /// A triangle of the vertex's tile with the vertex as a corner; `None` in a file without
        /// triangles.
        triangle: Option<TriangleId>,
    },
}

impl Place {
    /// Returns the place on the edge of a half-edge of a tile.
    pub(super) fn on_edge(tile: &Tile, half_edge: HalfEdge) -> Self {
        Self::OnEdge {
            tile: tile.id(),
            triangle: half_edge.triangle(),
            corner: half_edge.corner() as u8,
        }
    }

    /// Returns the tile that has the triangle or the vertex; `None` outside.
    #[must_use]
    pub fn tile(&self) -> Option<TileId> {
        match *self {
            Self::Outside => None,
            Self::InTriangle { tile, .. } | Self::OnEdge { tile, .. } => Some(tile),
            Self::OnVertex { vertex, .. } => Some(vertex.tile),
        }
    }

    /// Returns a triangle of the [tile](Self::tile) that contains the point; `None` outside, and in a file
    /// without triangles.
    #[must_use]
    pub fn triangle(&self) -> Option<TriangleId> {
        match *self {
            Self::Outside => None,
            Self::InTriangle { triangle, .. } | Self::OnEdge { triangle, .. } => Some(triangle),
            Self::OnVertex { triangle, .. } => triangle,
        }
    }

    /// Returns the location, with the vertices. `tile` must be the [tile](Self::tile) of the place, from
    /// the same file; outside it may be any.
    ///
    /// [`locate`](crate::store::TileReader::locate) returns the same for the same point, but it may name
    /// another triangle at the same edge, or the same triangle by another tile.
    ///
    /// # Panics
    /// If it is another tile.
    #[must_use]
    pub fn location(&self, tile: &Tile) -> Location {
        assert!(
            self.tile().is_none_or(|id| id == tile.id()),
            "{self:?} is not in tile {}",
            tile.id()
        );
        match *self {
            Self::Outside => Location::Outside,
            Self::InTriangle { triangle, .. } => Location::InTriangle(TriangleRef::of(tile, triangle)),
            Self::OnEdge { triangle, corner, .. } => Location::OnEdge {
                ends: tile.ends(HalfEdge::new(triangle, corner.into())),
                triangle: TriangleRef::of(tile, triangle),
            },
            Self::OnVertex { vertex, .. } => Location::OnVertex(tile.vertex(vertex.index)),
        }
    }
}
