//! Identifiers of tiles and vertices.

use std::fmt;

use crate::geometry::VertexIndex;

/// The maximum number of vertices of a tile.
pub(crate) const MAX_TILE_VERTICES: usize = 1 << 18;

/// The number of a tile: its index in the leaf order of the k-d tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct TileId(pub u32);

impl fmt::Display for TileId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// The id of a vertex of the file: its tile, and its index there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct VertexId {
    /// The tile that owns the vertex.
    pub tile: TileId,
    /// Its index among the vertices of that tile.
    pub index: VertexIndex,
}

impl fmt::Display for VertexId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.tile, self.index)
    }
}
