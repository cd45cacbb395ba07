//! Walks round a vertex within its tile, which holds its whole star.

use super::contradiction::Contradiction;
use crate::geometry::HalfEdge;
use crate::store::{Across, Tile, VertexId};

/// The side b → a of the triangle on that side of the edge, found in the star of `a`, a vertex of this tile.
///
/// `Ok(None)`: there is none, the edge is on the hull. An error says how the tile contradicts itself.
pub(crate) fn side_towards(tile: &Tile, a: u32, b: VertexId) -> Result<Option<HalfEdge>, Contradiction> {
    let Some(first) = tile.side_leaving(a).map(HalfEdge) else {
        return Err(Contradiction::NoTriangle(a));
    };
    // Counter-clockwise until the hull or all round; then clockwise from the start.
    let mut leaving = first;
    for _ in 0..tile.triangle_count() {
        let arriving = leaving.prev();
        if tile.vertex(tile.origin(arriving.0)).id == b {
            return Ok(Some(arriving));
        }
        match tile.across(arriving.0) {
            Across::Side(side) if HalfEdge(side) == first => return Ok(None),
            Across::Side(side) => leaving = HalfEdge(side),
            Across::Hull => return clockwise(tile, first, b),
            Across::Elsewhere => return Err(Contradiction::IncompleteStar(a)),
        }
    }
    Err(Contradiction::EndlessStar(a))
}

fn clockwise(tile: &Tile, first: HalfEdge, b: VertexId) -> Result<Option<HalfEdge>, Contradiction> {
    let mut leaving = first;
    for _ in 0..tile.triangle_count() {
        let Across::Side(arriving) = tile.across(leaving.0) else {
            return Ok(None);
        };
        let arriving = HalfEdge(arriving);
        if tile.vertex(tile.origin(arriving.0)).id == b {
            return Ok(Some(arriving));
        }
        leaving = arriving.next();
    }
    Err(Contradiction::EndlessStar(tile.origin(first.0)))
}
