//! Points that go, and with them the vertices that nothing else holds.

use std::collections::BTreeMap;

use crate::edit::contradiction::Contradiction;
use crate::edit::error::EditError;
use crate::edit::points::removal::VertexRemover;
use crate::edit::tiles::Tiles;
use crate::geometry::{Point, VertexIndex};
use crate::mesh::point_table::PointTable;
use crate::store::{TileId, VertexId};

/// What came of points, ends of lines and sites that go.
#[derive(Debug, Default)]
pub(crate) struct Deleted {
    /// Number of vertices that lost their point and stay, since something else holds them.
    pub(crate) held: u64,
    /// Number of removed vertices at which no point was.
    pub(crate) ends: u64,
    /// Number of removed vertices whose point was taken before.
    pub(crate) former: u64,
    /// The number of vertices that are left in each tile that lost any.
    pub(crate) left: BTreeMap<TileId, usize>,
}

/// What goes at a position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Gone {
    Point,
    /// A point that was taken from its vertex before. Another one may have come since, or the vertex
    /// may be gone.
    FormerPoint,
    /// An end of lines, or a site. The vertex may be gone, too.
    End,
}

/// A position whose vertex may go, by its tile.
pub(crate) type Position = (TileId, Point, Gone);

/// Removes vertices at positions, unless something else holds them. `has_lines` says whether any edge
/// may be a constraint.
pub(crate) fn delete(
    tiles: &mut Tiles,
    mut positions: Vec<Position>,
    has_lines: bool,
    is_stopped: &dyn Fn() -> bool,
) -> Result<Deleted, EditError> {
    // Of equal positions, the one whose point goes comes first.
    positions.sort_unstable_by(|a, b| {
        let by_point = a.0.cmp(&b.0).then_with(|| a.1.lex_cmp(b.1));
        by_point.then_with(|| a.2.cmp(&b.2))
    });
    positions.dedup_by(|next, kept| (next.0, next.1) == (kept.0, kept.1));
    let mut remover = VertexRemover::new(has_lines);
    let mut removed: BTreeMap<TileId, Vec<VertexIndex>> = BTreeMap::new();
    let mut deleted = Deleted::default();
    let mut groups = positions.chunk_by(|a, b| a.0 == b.0);
    while let Some(group) = groups.next() {
        tiles.read_ahead(groups.clone().map(|group| group[0].0));
        let id = group[0].0;
        for (index, gone) in vertices_that_may_go(tiles, group)? {
            if is_stopped() {
                return Err(EditError::Cancelled);
            }
            if remover.remove(tiles, VertexId { tile: id, index })? {
                removed.entry(id).or_default().push(index);
                deleted.ends += u64::from(gone == Gone::End);
                deleted.former += u64::from(gone == Gone::FormerPoint);
            } else if gone == Gone::Point {
                tiles.change(id)?.set_input_point(index, false);
                deleted.held += 1;
            }
        }
    }
    // Only now, since vertices get other numbers.
    for (id, vertices) in removed {
        let left = close_up(tiles, id, &vertices)?;
        deleted.left.insert(id, left);
    }
    Ok(deleted)
}

/// Returns the vertices at positions of one tile, except those where a point stays; and what goes
/// there.
fn vertices_that_may_go(tiles: &Tiles, positions: &[Position]) -> Result<Vec<(VertexIndex, Gone)>, EditError> {
    let id = positions[0].0;
    let tile = tiles.get(id)?;
    let table = PointTable::for_searches(tile.points(), positions.len());
    let mut found = Vec::with_capacity(positions.len());
    for &(_, point, gone) in positions {
        match table.at(point).map(VertexIndex) {
            Some(vertex) if gone == Gone::Point || !tile.is_input_point(vertex) => found.push((vertex, gone)),
            None if gone == Gone::Point => return Err(tiles.damaged(id, Contradiction::NoVertices)),
            _ => {}
        }
    }
    Ok(found)
}

/// Forgets vertices of a tile that have no triangle any more. Returns the number of those left.
fn close_up(tiles: &mut Tiles, id: TileId, vertices: &[VertexIndex]) -> Result<usize, EditError> {
    let mut tile = tiles.change(id)?;
    let moved = tile.remove_vertices(vertices);
    let left = tile.points().len();
    drop(tile);
    for vertex in moved {
        for other in vertex.tiles {
            tiles.change(other)?.rename(vertex.from, vertex.to);
        }
    }
    if left == 0 {
        tiles.set_emptied(id);
    }
    Ok(left)
}
