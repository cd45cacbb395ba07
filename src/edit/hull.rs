//! Walks along the hull, from tile to tile.

use std::collections::VecDeque;

use crate::edit::contradiction::Contradiction;
use crate::edit::error::EditError;
use crate::edit::tiles::{Pin, Tiles};
use crate::edit::vertex::EditVertex;
use crate::geometry::{HalfEdge, Orientation, Point, orient2d};
use crate::mesh::{Topology, Twin};
use crate::store::VertexId;

/// A half-edge on the hull: the corners of its triangle, from its origin on, and the bits of the
/// triangle's half-edges, from it on.
pub(crate) struct HullEdge {
    pub(crate) corners: [EditVertex; 3],
    pub(crate) bits: u8,
}

impl HullEdge {
    fn of(tile: &Pin, half_edge: HalfEdge) -> Self {
        let (corners, bits) = tile.triangle(half_edge);
        Self { corners, bits }
    }

    fn ends(&self) -> [VertexId; 2] {
        [self.corners[0].id, self.corners[1].id]
    }

    fn is_visible_from(&self, point: Point) -> bool {
        orient2d(self.corners[0].point, self.corners[1].point, point) == Orientation::Clockwise
    }
}

/// Returns the half-edges on the hull that a point sees from the outside, counter-clockwise along
/// the hull. `half_edge` is one of them.
pub(crate) fn visible_from(
    tiles: &Tiles,
    point: Point,
    (tile, half_edge): (Pin, HalfEdge),
) -> Result<VecDeque<HullEdge>, EditError> {
    let mut visible = VecDeque::from([HullEdge::of(&tile, half_edge)]);
    drop(tile);
    // The hull has at most one edge for each vertex.
    let most = tiles.most_triangles();
    for is_forward in [true, false] {
        loop {
            let edge = if is_forward { visible.back() } else { visible.front() };
            let Some(ends) = edge.map(HullEdge::ends) else { break };
            let next = beside(tiles, ends, is_forward)?;
            if !next.is_visible_from(point) {
                break;
            }
            if visible.len() as u64 > most {
                return Err(tiles.damaged(ends[0].tile, Contradiction::UnfitCavity));
            }
            match is_forward {
                true => visible.push_back(next),
                false => visible.push_front(next),
            }
        }
    }
    Ok(visible)
}

/// Returns the half-edge on the hull after the one between two vertices, or the one before it.
fn beside(tiles: &Tiles, [from, to]: [VertexId; 2], is_forward: bool) -> Result<HullEdge, EditError> {
    let at = if is_forward { to } else { from };
    let tile = tiles.get(at.tile)?;
    let damaged = || tiles.damaged(at.tile, Contradiction::UnfitCavity);
    let turn = |half_edge: HalfEdge| if is_forward { half_edge.next() } else { half_edge.prev() };
    let mut half_edge = turn(tile.half_edge_between(from, to).ok_or_else(damaged)?);
    for _ in 0..tile.triangle_count() {
        half_edge = match tile.twin(half_edge) {
            Twin::Hull => return Ok(HullEdge::of(&tile, half_edge)),
            Twin::HalfEdge(twin) => turn(twin),
            Twin::Elsewhere => break,
        };
    }
    Err(damaged())
}
