//! How a line leaves a vertex.

use crate::edit::error::EditError;
use crate::edit::tile::EditTile;
use crate::edit::tile::hubs::MOST_AROUND;
use crate::edit::tiles::Tiles;
use crate::edit::vertex::EditVertex;
use crate::geometry::{HalfEdge, Orientation, Point, orient2d};

/// The direction in which a line leaves a vertex.
pub(crate) enum Leaving {
    /// Along the edge of this half-edge, to the next vertex.
    Along(HalfEdge, EditVertex),
    /// Into the triangle of this half-edge, which starts at the vertex.
    Into(HalfEdge),
}

/// Returns how a line leaves a vertex, in a tile that has the vertex. Counts the triangles that are
/// examined.
pub(crate) fn leave(tile: &EditTile, from: EditVertex, to: Point, examined: &mut u64) -> Option<Leaving> {
    let is_ahead = |p: Point| p.lex_cmp(from.point) == to.lex_cmp(from.point);
    tile.around(from.id.index).find_map(|half_edge| {
        *examined += 1;
        let [right, left] = [half_edge.next(), half_edge.prev()].map(|half_edge| tile.origin_vertex(half_edge));
        match [right, left].map(|vertex| orient2d(from.point, vertex.point, to)) {
            [Orientation::Collinear, _] if is_ahead(right.point) => Some(Leaving::Along(half_edge, right)),
            [_, Orientation::Collinear] if is_ahead(left.point) => Some(Leaving::Along(half_edge.prev(), left)),
            [Orientation::CounterClockwise, Orientation::Clockwise] => Some(Leaving::Into(half_edge)),
            _ => None,
        }
    })
}

/// Returns whether to follow a line from its end: its start has many triangles, since thousands of
/// lines may share it, and its end has fewer.
pub(crate) fn is_shorter_from_end(tiles: &Tiles, [start, end]: [EditVertex; 2]) -> Result<bool, EditError> {
    let around = |vertex: EditVertex| tiles.get(vertex.id.tile).map(|tile| tile.degree(vertex.id.index));
    let at_start = around(start)?;
    Ok(at_start > MOST_AROUND && around(end)? < at_start)
}
