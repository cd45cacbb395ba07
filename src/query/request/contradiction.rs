//! Contradictions within a tile or between tiles.

use crate::geometry::{Point, TriangleId, VertexIndex};
use crate::mesh::{EndlessWalk, StarError};
use crate::store::VertexId;

/// A contradiction within a tile or between tiles that shows only when a query walks through it.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub(crate) enum Contradiction {
    #[error("vertex {0} does not exist, but other tiles refer to it")]
    NoVertex(VertexIndex),
    #[error("vertex {0} has no triangle, but is a corner of a triangle of another tile")]
    NoTriangle(VertexIndex),
    #[error("vertex {0} lacks a triangle that other tiles have")]
    LacksTriangle(VertexIndex),
    #[error("the star of vertex {0} is not complete")]
    IncompleteStar(VertexIndex),
    #[error("the star of vertex {0} does not close")]
    EndlessStar(VertexIndex),
    #[error("vertex {0} is not on the hull")]
    NotOnHull(VertexIndex),
    #[error("the hull turns the wrong way at vertex {0}")]
    ConcaveHull(VertexIndex),
    #[error("vertices {0} and {1} are not connected by a hull edge")]
    NoHullEdge(VertexId, VertexId),
    #[error("triangle {0} is not adjacent to the triangle that names it as its neighbour")]
    NotBeside(TriangleId),
    #[error("other tiles have another position for an end of half-edge {0}")]
    EndElsewhere(u32),
    #[error("a walk does not end")]
    EndlessWalk,
    #[error("a path bends at vertex {0}, where no edge blocks")]
    IdleBend(VertexIndex),
    #[error("no triangle or edge contains ({x}, {y})", x = .0.x, y = .0.y)]
    NothingAt(Point),
}

impl From<StarError> for Contradiction {
    fn from(error: StarError) -> Self {
        match error {
            StarError::Incomplete { vertex } => Self::IncompleteStar(vertex),
            StarError::Endless { vertex } => Self::EndlessStar(vertex),
        }
    }
}

impl From<EndlessWalk> for Contradiction {
    fn from(EndlessWalk: EndlessWalk) -> Self {
        Self::EndlessWalk
    }
}
