//! Contradictions within the tiles of a file, or between them.

use crate::geometry::VertexIndex;
use crate::mesh::EndlessWalk;

/// The reason why an edit cannot work with a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Contradiction {
    #[error("it has no vertices")]
    NoVertices,
    #[error("vertex {0} has no triangle")]
    LoneVertex(VertexIndex),
    #[error("a vertex is of a tile that there is not")]
    NoTile,
    #[error("a triangle is missing that another tile has")]
    MissingTriangle,
    #[error("triangles around a line do not fit together")]
    UnfitStrip,
    #[error("triangles around a new vertex do not fit together")]
    UnfitCavity,
    #[error(transparent)]
    Walk(#[from] EndlessWalk),
    #[error("no triangle around a vertex is on the way of a line")]
    NoWay,
    #[error("a line between two vertices leaves the triangulation")]
    LineLeaves,
    #[error("a line goes in circles")]
    EndlessLine,
    #[error("an edge is missing that was just put there")]
    MissingEdge,
    #[error("a constraint knows no line that it comes from")]
    NoSource,
}
