//! The sectors of vertices, by the vertices beside them.

use super::corner::{End, Within};
use crate::geometry::VertexIndex;
use crate::query::free_space::{Ground, Wedge};
use crate::query::request::Contradiction;

/// The wedge of a vertex of the tile that is named by a vertex on its left.
pub(crate) fn wedge(ground: Ground<'_>, vertex: VertexIndex, within: Within) -> Result<Wedge, Contradiction> {
    let wedge = match within {
        Within::Outside => Some(Wedge::Outside),
        Within::Sector(_) => None,
        Within::RightOf(left) => ground.right_of_edge(vertex, left)?,
    };
    wedge.ok_or(Contradiction::LacksTriangle(vertex))
}

/// The name of the sector of a wedge, and its wedges from the right to the left.
pub(crate) fn sector(
    ground: Ground<'_>,
    vertex: VertexIndex,
    wedge: Wedge,
) -> Result<(End, Vec<Wedge>), Contradiction> {
    let (wedges, is_whole) = ground.sector(vertex, wedge)?;
    let name = if is_whole {
        vertex
    } else {
        ground.neighbours(vertex, wedges[0])?[0]
    };
    Ok((ground.tile.vertex(name).id.into(), wedges))
}
