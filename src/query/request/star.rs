//! The half-edge between two vertices, by the star of one of them, which its tile holds whole.

use super::contradiction::Contradiction;
use crate::geometry::{HalfEdge, VertexIndex};
use crate::mesh::Topology;
use crate::store::{Tile, VertexId};

/// The side b → a of the triangle on that side of the edge, found in the star of `a`, a vertex of this tile.
///
/// `Ok(None)`: there is none, the edge is on the hull.
pub(crate) fn side_towards(tile: &Tile, a: VertexIndex, b: VertexId) -> Result<Option<HalfEdge>, Contradiction> {
    let leaving = tile.leaving(a).ok_or(Contradiction::NoTriangle(a))?;
    Ok(tile.arriving_from(leaving, |corner| tile.vertex(corner).id == b)?)
}
