//! Takes lines off edges, one at a time.

use crate::edit::chain::constraint_bits;
use crate::edit::contradiction::Contradiction;
use crate::edit::error::EditError;
use crate::edit::marks::mark;
use crate::edit::summary::LineCounts;
use crate::edit::tiles::Tiles;
use crate::edit::touch::touch_along;
use crate::edit::unconstrain::flips::Flips;
use crate::edit::vertex::{EditVertex, owner};
use crate::geometry::Point;
use crate::store::{EdgeSource, LinePart, TileId, VertexId};

/// What came of the removal of lines.
#[derive(Debug, Default)]
pub(crate) struct Removed {
    pub(crate) counts: LineCounts,
    /// The positions of the ends of removed segments, by tile.
    pub(crate) ends: Vec<(TileId, Point)>,
}

/// A remover of lines, which reuses its buffers.
#[derive(Default)]
pub(super) struct LineRemover {
    flips: Flips,
    pub(super) removed: Removed,
}

impl LineRemover {
    /// Takes a source, as seen from the first end of an edge, off the edge. If the edge has several
    /// copies of it, it loses one.
    pub(super) fn take(
        &mut self,
        tiles: &mut Tiles,
        edge: [EditVertex; 2],
        source: EdgeSource,
    ) -> Result<(), EditError> {
        let (ids, tile) = (edge.map(|end| end.id), owner(edge));
        let unknown = |tiles: &Tiles| tiles.damaged(tile, Contradiction::NoSource);
        let sources = tiles.change(tile)?.take_sources(ids);
        let mut left = sources.ok_or_else(|| unknown(tiles))?;
        let place = left.iter().position(|part| part.source() == source);
        let part = left.swap_remove(place.ok_or_else(|| unknown(tiles))?);
        if !left.is_empty() {
            let given = tiles.change(tile)?.give_sources(ids, &left);
            given.ok_or_else(|| unknown(tiles))?;
        }
        for (end, is_end) in edge.into_iter().zip(part.end_bits()) {
            if is_end {
                self.removed.ends.push((end.id.tile, end.point));
            }
        }
        let bits = match &left[..] {
            [] => 0,
            left => constraint_bits(left.iter().copied().any(LinePart::is_wall)),
        };
        mark(tiles, &triangles_at(tiles, ids)?, |_| bits)?;
        touch_along(tiles, edge.map(|end| end.point))?;
        if left.is_empty() {
            self.removed.counts.freed_edges += 1;
            self.flips.spread_from(tiles, ids)?;
        }
        Ok(())
    }
}

/// Returns the triangles at an edge, from the edge on.
fn triangles_at(tiles: &Tiles, [from, to]: [VertexId; 2]) -> Result<Vec<[VertexId; 3]>, EditError> {
    let tile = tiles.get(from.tile)?;
    let sides = [[from, to], [to, from]].into_iter();
    let half_edges = sides.filter_map(|[from, to]| tile.half_edge_between(from, to));
    let corners = half_edges.map(|half_edge| tile.triangle(half_edge).0.map(|corner| corner.id));
    Ok(corners.collect())
}
