//! Obstacle edges: the subsegments of walls and of the boundaries of holes, as tiles have them.

use crate::geometry::VertexIndex;
use crate::query::free_space::{FreeSpace, Wedge};
use crate::query::request::Contradiction;
use crate::store::{Vertex, VertexId};

/// A constraint edge that blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ObstacleEdge {
    pub(super) ends: [Vertex; 2],
    /// Whether the left side is free, and whether the right side is.
    pub(super) free: [bool; 2],
}

impl ObstacleEdge {
    /// Returns the ids of the ends, sorted.
    pub(super) fn key(&self) -> [VertexId; 2] {
        let [a, b] = self.ends.map(|end| end.id);
        if a < b { [a, b] } else { [b, a] }
    }
}

/// Calls `take` with each obstacle edge at a vertex of the tile.
pub(super) fn edges_at(
    space: FreeSpace<'_>,
    vertex: VertexIndex,
    mut take: impl FnMut(ObstacleEdge),
) -> Result<(), Contradiction> {
    let is_free = |wedge: Wedge| match wedge {
        Wedge::Triangle(half_edge) => space.is_free(half_edge.triangle()),
        Wedge::Outside => space.outside_is_free,
    };
    let wedges = space.wedges(vertex)?;
    for (index, &right) in wedges.iter().enumerate() {
        let left = wedges[(index + 1) % wedges.len()];
        let edge = match right {
            Wedge::Triangle(half_edge) => half_edge.prev(),
            Wedge::Outside => space.first(vertex)?,
        };
        if space.tile.is_wall(edge) {
            let to = space.neighbours(vertex, right)?[1];
            take(ObstacleEdge {
                ends: [vertex, to].map(|end| space.tile.vertex(end)),
                free: [is_free(left), is_free(right)],
            });
        }
    }
    Ok(())
}
