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
    #[error("a vertex belongs to a tile that does not exist")]
    NoTile,
    #[error("a triangle of another tile is missing in it")]
    MissingTriangle,
    #[error("triangles around a line do not fit together")]
    UnfitStrip,
    #[error("triangles around a new vertex do not fit together")]
    UnfitCavity,
    #[error(transparent)]
    Walk(#[from] EndlessWalk),
    #[error("no triangle around a vertex contains the direction of a line")]
    NoWay,
    #[error("a line between two vertices leaves the triangulation")]
    LineLeaves,
    #[error("the walk along a line does not end")]
    EndlessLine,
    #[error("an edge that was just inserted is missing")]
    MissingEdge,
    #[error("its component table contradicts itself, or those of other tiles")]
    Components,
    #[error("a constraint has no source line")]
    NoSource,
}
