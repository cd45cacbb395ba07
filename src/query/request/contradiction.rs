//! How a tile contradicts itself or others.

use crate::geometry::{Point, TriangleId};
use crate::mesh::{EndlessWalk, StarError};
use crate::store::VertexId;

/// How a tile contradicts itself or others, in a way that only shows when it is walked through.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub(crate) enum Contradiction {
    #[error("there is no vertex {0}, but other tiles have it")]
    NoVertex(u32),
    #[error("vertex {0} has no triangle, but is a corner of one elsewhere")]
    NoTriangle(u32),
    #[error("vertex {0} lacks a triangle that other tiles have")]
    LacksTriangle(u32),
    #[error("the star of vertex {0} is not complete")]
    IncompleteStar(u32),
    #[error("the star of vertex {0} does not close")]
    EndlessStar(u32),
    #[error("vertex {0} is not on the hull")]
    NotOnHull(u32),
    #[error("the hull turns the wrong way at vertex {0}")]
    ConcaveHull(u32),
    #[error("vertices {0} and {1} have no edge on the hull")]
    NoHullEdge(VertexId, VertexId),
    #[error("triangle {0} does not lie beside the one that it is said to lie beside")]
    NotBeside(TriangleId),
    #[error("an end of side {0} lies elsewhere for other tiles")]
    EndElsewhere(u32),
    #[error("a walk goes in circles")]
    EndlessWalk,
    #[error("a path bends at vertex {0}, where nothing is in the way")]
    IdleBend(u32),
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
