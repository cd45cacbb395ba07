//! The half-edge between two vertices, found in the star of one of them. The tile of a vertex has
//! its whole star.

use super::contradiction::Contradiction;
use crate::geometry::{HalfEdge, VertexIndex};
use crate::mesh::Topology;
use crate::store::{Tile, VertexId};

/// Returns the half-edge from `b` to `a`, found in the star of `a`, a vertex of this tile.
///
/// Returns `Ok(None)` if there is no such half-edge, because the edge is on the hull.
pub(crate) fn half_edge_towards(tile: &Tile, a: VertexIndex, b: VertexId) -> Result<Option<HalfEdge>, Contradiction> {
    let leaving = tile.leaving(a).ok_or(Contradiction::NoTriangle(a))?;
    Ok(tile.arriving_from(leaving, |corner| tile.vertex(corner).id == b)?)
}
