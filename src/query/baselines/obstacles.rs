//! Obstacle edges: the pieces of walls and of the boundaries of holes, as tiles have them.

use crate::geometry::VertexIndex;
use crate::query::free_space::{Ground, Wedge};
use crate::query::request::Contradiction;
use crate::store::{Vertex, VertexId};

/// A constraint edge that blocks the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ObstacleEdge {
    pub(super) ends: [Vertex; 2],
    /// Whether one may be on its left, and on its right.
    pub(super) free: [bool; 2],
}

impl ObstacleEdge {
    /// The numbers of its ends, in order.
    pub(super) fn key(&self) -> [VertexId; 2] {
        let [a, b] = self.ends.map(|end| end.id);
        if a < b { [a, b] } else { [b, a] }
    }
}

/// Takes all obstacle edges at a vertex of the tile.
pub(super) fn edges_at(
    ground: Ground<'_>,
    vertex: VertexIndex,
    mut take: impl FnMut(ObstacleEdge),
) -> Result<(), Contradiction> {
    let is_free = |wedge: Wedge| match wedge {
        Wedge::Triangle(side) => ground.is_free(side.triangle()),
        Wedge::Outside => ground.outside_is_free,
    };
    let wedges = ground.wedges(vertex)?;
    for (place, &right) in wedges.iter().enumerate() {
        let left = wedges[(place + 1) % wedges.len()];
        let edge = match right {
            Wedge::Triangle(side) => side.prev(),
            Wedge::Outside => ground.first(vertex)?,
        };
        if ground.tile.is_wall(edge) {
            let to = ground.neighbours(vertex, right)?[1];
            take(ObstacleEdge {
                ends: [vertex, to].map(|end| ground.tile.vertex(end)),
                free: [is_free(left), is_free(right)],
            });
        }
    }
    Ok(())
}
