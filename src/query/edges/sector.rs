//! The sectors of vertices, identified by neighbouring vertices.

use super::corner::{GraphVertex, Within};
use crate::geometry::VertexIndex;
use crate::query::free_space::{FreeSpace, Wedge};
use crate::query::request::Contradiction;

/// Returns the wedge of a vertex of the tile, which `within` names by a vertex on its left.
pub(crate) fn wedge(space: FreeSpace<'_>, vertex: VertexIndex, within: Within) -> Result<Wedge, Contradiction> {
    let wedge = match within {
        Within::Outside => Some(Wedge::Outside),
        Within::Sector(_) => None,
        Within::RightOf(left) => space.right_of_edge(vertex, left)?,
    };
    wedge.ok_or(Contradiction::LacksTriangle(vertex))
}

/// Returns the name of the sector of a wedge, and its wedges from right to left.
pub(crate) fn sector(
    space: FreeSpace<'_>,
    vertex: VertexIndex,
    wedge: Wedge,
) -> Result<(GraphVertex, Vec<Wedge>), Contradiction> {
    let (wedges, is_whole) = space.sector(vertex, wedge)?;
    let name = if is_whole {
        vertex
    } else {
        space.neighbours(vertex, wedges[0])?[0]
    };
    Ok((space.tile.vertex(name).id.into(), wedges))
}
