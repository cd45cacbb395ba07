//! The sectors of vertices, by the vertices beside them.

use super::corner::Within;
use crate::query::free_space::{Ground, Wedge};
use crate::query::request::{Contradiction, side_towards};
use crate::store::VertexId;

/// The wedge of a vertex of the tile that is named by a vertex on its left.
pub(crate) fn wedge(ground: Ground<'_>, vertex: u32, within: Within) -> Result<Wedge, Contradiction> {
    let missing = || Contradiction::LacksTriangle(vertex);
    match within {
        Within::Outside => Ok(Wedge::Outside),
        Within::Sector(_) => Err(missing()),
        Within::RightOf(left) => match side_towards(ground.tile, vertex, left)? {
            Some(back) => Ok(Wedge::Triangle(back.next())),
            None => Err(missing()),
        },
    }
}

/// The name of the sector of a wedge, and its wedges from the right to the left.
pub(crate) fn sector(ground: Ground<'_>, vertex: u32, wedge: Wedge) -> Result<(VertexId, Vec<Wedge>), Contradiction> {
    let most = ground.tile.triangle_count();
    let mut first = wedge;
    let mut is_whole = false;
    for _ in 0..=most {
        match ground.right_of(vertex, first)? {
            Some(right) if right == wedge => {
                is_whole = true;
                break;
            }
            Some(right) => first = right,
            None => break,
        }
    }
    let name = if is_whole {
        vertex
    } else {
        ground.neighbours(vertex, first)?[0]
    };
    let mut wedges = vec![first];
    for _ in 0..=most {
        match ground.left_of(vertex, wedges[wedges.len() - 1])? {
            Some(left) if left != first => wedges.push(left),
            _ => return Ok((ground.tile.vertex(name).id, wedges)),
        }
    }
    Err(Contradiction::EndlessStar(vertex))
}
