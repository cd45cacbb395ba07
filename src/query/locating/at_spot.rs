//! The triangles at a spot, one of which counts: in the tile where a walk ended, or else in another one.

use super::locate::triangles_at;
use super::walk::Spot;
use crate::geometry::{TriangleId, VertexIndex};
use crate::mesh::Twin;
use crate::query::request::{Contradiction, half_edge_towards};
use crate::store::{Tile, TileId, VertexId};

/// What was found of a triangle that counts.
pub(super) enum Found {
    In(TriangleId),
    None,
    /// None in this tile. The other one may have one.
    Ask(TileId, Rest),
}

/// What the first tile lacks.
pub(super) enum Rest {
    /// An edge between a vertex that the tile owns and another one.
    Edge(VertexIndex, VertexId),
    /// A vertex that the tile owns.
    Vertex(VertexIndex),
}

/// Returns the first triangle at a spot of a tile that counts.
pub(super) fn find(tile: &Tile, spot: Spot, counts: impl Fn(TriangleId) -> bool) -> Found {
    let (found, rest) = match spot {
        Spot::Outside(_) => (None, None),
        Spot::Triangle(triangle) => (counts(triangle).then_some(triangle), None),
        Spot::Edge(half_edge) => {
            let twin = tile.twin(half_edge);
            let other = twin.half_edge().map(|twin| twin.triangle());
            let found = [half_edge.triangle()].into_iter().chain(other).find(|&t| counts(t));
            let rest = (twin == Twin::Elsewhere).then(|| {
                let [a, b] = tile.ends(half_edge).map(|end| end.id);
                (a.tile, Rest::Edge(a.index, b))
            });
            (found, rest)
        }
        Spot::Vertex(corner) => {
            let vertex = tile.vertex(corner).id;
            let found = triangles_at(tile, vertex).find(|&triangle| counts(triangle));
            let is_elsewhere = vertex.tile != tile.id();
            (found, is_elsewhere.then_some((vertex.tile, Rest::Vertex(vertex.index))))
        }
    };
    match (found, rest) {
        (Some(triangle), _) => Found::In(triangle),
        (None, Some((tile, rest))) => Found::Ask(tile, rest),
        (None, None) => Found::None,
    }
}

/// Returns the first triangle of a tile that counts, of those that another tile lacks.
///
/// # Errors
/// If the tile has no such vertex or edge.
pub(super) fn find_rest(
    tile: &Tile,
    rest: &Rest,
    counts: impl Fn(TriangleId) -> bool,
) -> Result<Option<TriangleId>, Contradiction> {
    let (Rest::Vertex(index) | Rest::Edge(index, _)) = *rest;
    if !tile.has_vertex(index) {
        return Err(Contradiction::NoVertex(index));
    }
    Ok(match *rest {
        // The other side of the edge, if it has one.
        Rest::Edge(a, b) => {
            let other = half_edge_towards(tile, a, b)?.map(|half_edge| half_edge.triangle());
            other.filter(|&triangle| counts(triangle))
        }
        Rest::Vertex(index) => {
            let vertex = VertexId { tile: tile.id(), index };
            triangles_at(tile, vertex).find(|&triangle| counts(triangle))
        }
    })
}
