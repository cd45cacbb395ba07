//! What holds a vertex: a point, a site, or the end of a segment.
//!
//! What comes to a vertex that nothing holds any more determines its z, as in a build of what is
//! there after the edit.

use crate::edit::error::EditError;
use crate::edit::tiles::Tiles;
use crate::edit::vertex::{EditVertex, owner};
use crate::geometry::Point;
use crate::store::TileId;

/// The points that an edit deletes, and that are at their vertices until its end.
pub(crate) struct GoingPoints<'a>(&'a [(TileId, Point)]);

impl<'a> GoingPoints<'a> {
    /// Takes points by tile, and sorts them.
    pub(crate) fn new(points: &'a mut [(TileId, Point)]) -> Self {
        points.sort_unstable_by(|a, b| a.0.cmp(&b.0).then_with(|| a.1.lex_cmp(b.1)));
        Self(points)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn contains(&self, tile: TileId, point: Point) -> bool {
        let found = self
            .0
            .binary_search_by(|going| going.0.cmp(&tile).then_with(|| going.1.lex_cmp(point)));
        found.is_ok()
    }

    /// Returns whether a point that stays, a site or the end of a segment is at a vertex.
    pub(crate) fn is_held(&self, tiles: &Tiles, vertex: EditVertex) -> Result<bool, EditError> {
        let id = vertex.id;
        let tile = tiles.get(id.tile)?;
        let has_point = tile.is_input_point(id.index) && !self.contains(id.tile, vertex.point);
        if has_point || tile.has_site(id.index) {
            return Ok(true);
        }
        let mut others: Vec<EditVertex> = Vec::new();
        for half_edge in tile.around(id.index) {
            let both = [(half_edge, half_edge.next()), (half_edge.prev(), half_edge.prev())];
            let constraints = both.into_iter().filter(|(edge, _)| tile.is_constraint(*edge));
            others.extend(constraints.map(|(_, at)| tile.origin_vertex(at)));
        }
        drop(tile);
        for other in others {
            let edge = [vertex, other];
            let sources = tiles.get(owner(edge))?.sources_along(edge.map(|end| end.id));
            // The lines of a draft are not all known yet: any may end here.
            if sources.is_none_or(|sources| sources.iter().any(|part| part.begins())) {
                return Ok(true);
            }
        }
        Ok(false)
    }
}
