//! How a tile contradicts itself or others.

use crate::geometry::{Point, TriangleId, VertexIndex};
use crate::mesh::{EndlessWalk, StarError};
use crate::store::VertexId;

/// How a tile contradicts itself or others, in a way that only shows when it is walked through.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub(crate) enum Contradiction {
    #[error("there is no vertex {0}, but other tiles have it")]
    NoVertex(VertexIndex),
    #[error("vertex {0} has no triangle, but is a corner of one elsewhere")]
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
    #[error("vertices {0} and {1} have no edge on the hull")]
    NoHullEdge(VertexId, VertexId),
    #[error("triangle {0} does not lie beside the one that it is said to lie beside")]
    NotBeside(TriangleId),
    #[error("an end of side {0} lies elsewhere for other tiles")]
    EndElsewhere(u32),
    #[error("a walk goes in circles")]
    EndlessWalk,
    #[error("a path bends at vertex {0}, where nothing is in the way")]
    IdleBend(VertexIndex),
    #[error("nothing is where ({x}, {y}) lies", x = .0.x, y = .0.y)]
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
