//! The cells of the k-d tree, followed from the root down, and what is found that way.
//!
//! The tree is divided among the root, the lists of pages, and the pages. What a search does not
//! visit is not read.

use std::sync::Arc;

use crate::geometry::{Point, Rect};
use crate::store::error::ReadError;
use crate::store::format::ids::TileId;
use crate::store::format::kd_tree::{KdNode, KdTree};
use crate::store::format::page::Page;
use crate::store::reader::TileReader;

/// A cell of the k-d tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    part: TreePart,
    /// The number of the node in its part of the tree.
    node: u32,
    /// The part of the plane that the cell covers.
    pub(crate) rect: Rect,
}

/// A part of the tree.
#[derive(Clone, Copy, Debug)]
enum TreePart {
    Root,
    List(u32),
    Page(u32),
}

/// What a cell consists of.
#[derive(Clone, Copy, Debug)]
pub(crate) enum CellContent {
    /// The two cells on the lower and the upper side of a cut.
    Cut([Cell; 2]),
    /// The cell of one tile.
    Tile(TileId),
}

/// What a node of a part of the tree is.
enum Step<L> {
    Cut([Cell; 2]),
    Leaf(L),
}

impl Cell {
    /// Returns a number that no other cell has.
    pub(crate) fn number(self) -> u64 {
        let part = match self.part {
            TreePart::Root => 0,
            TreePart::List(list) => 1 + u64::from(list),
            TreePart::Page(page) => 1 << 31 | u64::from(page),
        };
        part << 32 | u64::from(self.node)
    }

    /// Returns what the cell's node is, in the tree of the cell's part. `None` in an empty tree.
    fn step<L: Copy>(self, tree: &KdTree<L>) -> Option<Step<L>> {
        let rect = self.rect;
        let (right, low, high) = match *tree.nodes().get(self.node as usize)? {
            KdNode::X { cut, right } => (right, Rect { max_x: cut, ..rect }, Rect { min_x: cut, ..rect }),
            KdNode::Y { cut, right } => (right, Rect { max_y: cut, ..rect }, Rect { min_y: cut, ..rect }),
            KdNode::Leaf(leaf) => return Some(Step::Leaf(leaf)),
        };
        Some(Step::Cut([(self.node + 1, low), (right, high)].map(|(node, rect)| {
            let part = self.part;
            Self { part, node, rect }
        })))
    }

    /// Returns the same cell as the root of another part of the tree.
    fn in_part(self, part: TreePart) -> Self {
        Self { part, node: 0, ..self }
    }
}

impl TileReader {
    /// Returns the cell of the root, within the bounds of the vertices, or `None` if the file has
    /// no tiles.
    pub(crate) fn root_cell(&self) -> Option<Cell> {
        (self.metadata().vertices > 0).then_some(Cell {
            part: TreePart::Root,
            node: 0,
            rect: self.metadata().bounds,
        })
    }

    /// Returns what a cell consists of.
    pub(crate) async fn content_of(&self, mut cell: Cell) -> Result<CellContent, ReadError> {
        loop {
            let step = match cell.part {
                TreePart::Root => cell.step(&self.pages().root.tree).map(|step| step.to(TreePart::List)),
                TreePart::List(list) => {
                    let list = self.pages().page_list(list as usize).await?;
                    cell.step(&list.tree).map(|step| step.to(TreePart::Page))
                }
                TreePart::Page(page) => {
                    let page = self.pages().page(page).await?;
                    match cell.step(&page.tree) {
                        Some(Step::Cut(cells)) => Some(Step::Cut(cells)),
                        Some(Step::Leaf(tile)) => return Ok(CellContent::Tile(tile)),
                        None => None,
                    }
                }
            };
            match step {
                Some(Step::Cut(cells)) => return Ok(CellContent::Cut(cells)),
                Some(Step::Leaf(part)) => cell = cell.in_part(part),
                None => return Err(self.empty_part()),
            }
        }
    }

    /// Returns the tile whose cell contains `p`, or `None` if the file has no tiles.
    ///
    /// # Errors
    ///
    /// Returns an error if a part of the directory cannot be read or is damaged.
    pub async fn tile_at(&self, p: Point) -> Result<Option<TileId>, ReadError> {
        let Some(page) = self.page_at(p).await? else {
            return Ok(None);
        };
        let page = self.page(page).await?;
        self.tile_in(&page, p).map(Some)
    }

    /// Returns the number of the directory's page whose cells contain `p`, or `None` if the file has
    /// no tiles.
    pub(crate) async fn page_at(&self, p: Point) -> Result<Option<u32>, ReadError> {
        let pages = self.pages();
        let Some(list) = pages.root.tree.leaf_at(p) else {
            return Ok(None);
        };
        let list = pages.page_list(list as usize).await?;
        list.tree.leaf_at(p).ok_or_else(|| self.empty_part()).map(Some)
    }

    /// Returns a page of the directory.
    pub(crate) async fn page(&self, number: u32) -> Result<Arc<Page>, ReadError> {
        self.pages().page(number).await
    }

    /// Returns the tile whose cell contains `p`, which is in the cells of a page.
    pub(crate) fn tile_in(&self, page: &Page, p: Point) -> Result<TileId, ReadError> {
        page.tree.leaf_at(p).ok_or_else(|| self.empty_part())
    }

    /// Returns the tiles for whose bounds `is_wanted` returns true, in the order of their numbers.
    /// If it returns true for a rectangle, it must return true for any larger one.
    pub(crate) async fn tiles_where(&self, is_wanted: impl Fn(Rect) -> bool) -> Result<Vec<TileId>, ReadError> {
        let pages = self.pages();
        let whole = pages.root.metadata.bounds;
        let mut found = Vec::new();
        for (place, list) in pages.root.page_lists.iter().enumerate() {
            if !is_wanted(list.bounds.rect(whole)) {
                continue;
            }
            let list = pages.page_list(place).await?;
            for (page, number) in list.pages.iter().zip(list.first..) {
                if !is_wanted(page.bounds.rect(whole)) {
                    continue;
                }
                let page = pages.page(number).await?;
                let used = page.entries.iter().zip(page.first..);
                let wanted = used.filter(|(entry, _)| !entry.is_unused() && is_wanted(entry.bounds));
                found.extend(wanted.map(|(_, tile)| TileId(tile)));
            }
        }
        Ok(found)
    }

    /// Returns the tiles whose bounds meet a rectangle, in the order of their numbers. It stops when it
    /// has found more than `most`.
    #[cfg(feature = "map-tiles")]
    pub(crate) async fn tiles_in(&self, rect: Rect, most: usize) -> Result<Vec<TileId>, ReadError> {
        let pages = self.pages();
        let whole = pages.root.metadata.bounds;
        let mut found = Vec::new();
        for (place, list) in pages.root.page_lists.iter().enumerate() {
            if !list.bounds.rect(whole).intersects(rect) {
                continue;
            }
            let list = pages.page_list(place).await?;
            for (page, number) in list.pages.iter().zip(list.first..) {
                if !page.bounds.rect(whole).intersects(rect) {
                    continue;
                }
                let page = pages.page(number).await?;
                let used = page.entries.iter().zip(page.first..);
                let meeting = used.filter(|(entry, _)| !entry.is_unused() && entry.bounds.intersects(rect));
                found.extend(meeting.map(|(_, tile)| TileId(tile)));
                if found.len() > most {
                    return Ok(found);
                }
            }
        }
        Ok(found)
    }

    /// Returns the error for a tree that leads to a part without cells.
    pub(super) fn empty_part(&self) -> ReadError {
        ReadError::Invalid {
            file: self.name().into(),
            reason: "its directory is damaged: the k-d tree leads to an empty part".to_owned(),
        }
    }
}

impl Step<u32> {
    /// Returns the step with the part of the tree that a leaf stands for.
    fn to(self, part: fn(u32) -> TreePart) -> Step<TreePart> {
        match self {
            Self::Cut(cells) => Step::Cut(cells),
            Self::Leaf(number) => Step::Leaf(part(number)),
        }
    }
}
