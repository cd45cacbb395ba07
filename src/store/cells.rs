//! The cells of the k-d tree, followed from the root down, and what is found that way.

use crate::geometry::{Point, Rect};
use crate::store::error::ReadError;
use crate::store::format::ids::TileId;
use crate::store::format::kd_tree::KdNode;
use crate::store::reader::TileReader;

/// A cell of the k-d tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    /// The number of the node.
    pub(crate) node: u32,
    /// The part of the plane that the cell covers.
    pub(crate) rect: Rect,
}

/// What a cell consists of.
#[derive(Clone, Copy, Debug)]
pub(crate) enum CellContent {
    /// The two cells on the lower and the upper side of a cut.
    Cut([Cell; 2]),
    /// The cell of one tile.
    Tile(TileId),
}

impl TileReader {
    /// Returns the cell of the root, within the bounds of the vertices, or `None` if the file has
    /// no tiles.
    pub(crate) fn root_cell(&self) -> Option<Cell> {
        let rect = self.metadata().bounds;
        (self.metadata().vertices > 0).then_some(Cell { node: 0, rect })
    }

    /// Returns what a cell consists of.
    pub(crate) async fn content_of(&self, Cell { node, rect }: Cell) -> Result<CellContent, ReadError> {
        let directory = self.directory().await?;
        let (right, low, high) = match directory.tree.nodes()[node as usize] {
            KdNode::X { cut, right } => (right, Rect { max_x: cut, ..rect }, Rect { min_x: cut, ..rect }),
            KdNode::Y { cut, right } => (right, Rect { max_y: cut, ..rect }, Rect { min_y: cut, ..rect }),
            KdNode::Leaf(tile) => return Ok(CellContent::Tile(tile)),
        };
        let low = Cell {
            node: node + 1,
            rect: low,
        };
        Ok(CellContent::Cut([
            low,
            Cell {
                node: right,
                rect: high,
            },
        ]))
    }

    /// Returns the tile whose cell contains `p`, or `None` if the file has no tiles.
    ///
    /// # Errors
    ///
    /// Returns an error if a part of the directory cannot be read or is damaged.
    pub async fn tile_at(&self, p: Point) -> Result<Option<TileId>, ReadError> {
        Ok(self.directory().await?.tree.tile_at(p))
    }

    /// Returns the tiles for whose bounds `is_wanted` returns true, in order.
    pub(crate) async fn tiles_where(&self, is_wanted: impl Fn(Rect) -> bool) -> Result<Vec<TileId>, ReadError> {
        let directory = self.directory().await?;
        let wanted = directory
            .tiles
            .iter()
            .zip(0..)
            .filter(|(entry, _)| is_wanted(entry.bounds));
        Ok(wanted.map(|(_, id)| TileId(id)).collect())
    }
}
