//! How a directory is divided into pages, and where they are.

use std::ops::Range;

use crate::store::format::entry::Extent;
use crate::store::format::ids::TileId;
use crate::store::format::kd_tree::KdTree;
use crate::store::format::limits::{LIST_PAGES, PAGE_TILES};
use crate::store::format::lists::OfLists;

/// The division of a directory into pages. Parts without an extent are not in a file yet, or differ
/// from what is there.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Layout {
    /// The top of the k-d tree. Leaves name lists of pages.
    pub(crate) top: KdTree<u32>,
    pub(crate) page_lists: Vec<PageListLayout>,
    pub(crate) pages: Vec<PageLayout>,
    /// The lists of the file.
    pub(crate) lists: OfLists<Option<Extent>>,
    pub(crate) root: Option<Extent>,
}

/// A list of pages.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PageListLayout {
    pub(crate) extent: Option<Extent>,
    pub(crate) pages: Range<u32>,
    pub(crate) tree: KdTree<u32>,
}

/// A page.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PageLayout {
    pub(crate) extent: Option<Extent>,
    /// The tiles whose entries the page has.
    pub(crate) tiles: Range<u32>,
    /// The nodes of the page's part of the k-d tree.
    pub(crate) nodes: Range<u32>,
}

impl Layout {
    /// Divides a directory whose tiles have numbers below `next_tile`.
    pub(crate) fn of(tree: &KdTree, next_tile: u32) -> Self {
        let (above, mut nodes) = tree.cut_into(PAGE_TILES);
        let mut tiles = tiles_of_subtrees(tree, &nodes, next_tile).unwrap_or_else(|| {
            let starts = (0..next_tile).step_by(PAGE_TILES as usize);
            starts.map(|first| first..next_tile.min(first + PAGE_TILES)).collect()
        });
        // A page may have no part of the tree, or no entries.
        let count = nodes.len().max(tiles.len());
        nodes.resize(count, 0..0);
        tiles.resize(count, next_tile..next_tile);
        let pages = nodes.into_iter().zip(tiles).map(|(nodes, tiles)| PageLayout {
            extent: None,
            tiles,
            nodes,
        });
        let (top, parts) = above.cut_into(LIST_PAGES);
        let mut page_lists: Vec<PageListLayout> = Vec::new();
        for part in parts {
            let tree = above.subtree(part);
            let first = page_lists.last().map_or(0, |list| list.pages.end);
            page_lists.push(PageListLayout {
                extent: None,
                pages: first..first + tree.tiles(),
                tree,
            });
        }
        // Pages without a part of the tree come last.
        let count = count as u32;
        let mut done = 0;
        if let Some(last) = page_lists.last_mut() {
            last.pages.end = last.pages.end.max(count.min(last.pages.start + LIST_PAGES));
            done = last.pages.end;
        }
        while done < count {
            let pages = done..count.min(done + LIST_PAGES);
            done = pages.end;
            page_lists.push(PageListLayout {
                extent: None,
                pages,
                tree: KdTree::default(),
            });
        }
        Self {
            top,
            page_lists,
            pages: pages.collect(),
            lists: OfLists::default(),
            root: None,
        }
    }
}

/// Returns the tiles of each subtree, if all tiles are numbered in the order of the leaves.
fn tiles_of_subtrees(tree: &KdTree, subtrees: &[Range<u32>], next_tile: u32) -> Option<Vec<Range<u32>>> {
    if tree.tiles() != next_tile || !tree.leaves().eq((0..next_tile).map(TileId)) {
        return None;
    }
    let mut first = 0;
    let of_subtree = |nodes: &Range<u32>| {
        let start = first;
        first += nodes.len().div_ceil(2) as u32;
        start..first
    };
    Some(subtrees.iter().map(of_subtree).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::format::kd_tree::KdNode;
    use crate::store::format::preorder::Preorder;

    /// Returns a balanced tree with these leaves.
    fn tree(leaves: &[u32]) -> KdTree {
        fn grow(leaves: &[u32], out: &mut Preorder<TileId>) {
            if let [leaf] = leaves {
                return out.push(KdNode::Leaf(TileId(*leaf))).unwrap();
            }
            let (left, right) = leaves.split_at(leaves.len() / 2);
            out.push(KdNode::X { cut: 0.0, right: 0 }).unwrap();
            grow(left, out);
            grow(right, out);
        }
        let mut out = Preorder::default();
        if !leaves.is_empty() {
            grow(leaves, &mut out);
        }
        out.finish().unwrap()
    }

    fn check(leaves: &[u32], next_tile: u32) -> Layout {
        let layout = Layout::of(&tree(leaves), next_tile);
        let mut tiles = 0;
        for page in &layout.pages {
            assert_eq!(page.tiles.start, tiles);
            assert!(page.tiles.len() as u32 <= PAGE_TILES);
            tiles = page.tiles.end;
        }
        assert_eq!(tiles, next_tile);
        let mut pages = 0;
        for list in &layout.page_lists {
            assert_eq!(list.pages.start, pages);
            assert!((1..=LIST_PAGES).contains(&(list.pages.len() as u32)));
            pages = list.pages.end;
        }
        assert_eq!(pages as usize, layout.pages.len());
        layout
    }

    #[test]
    fn new_directories_have_the_entries_of_a_page_with_its_part_of_the_tree() {
        for count in [0, 1, 127, 128, 129, 5000, 100_000] {
            let leaves: Vec<u32> = (0..count).collect();
            let layout = check(&leaves, count);
            for page in &layout.pages {
                assert_eq!(2 * page.tiles.len(), page.nodes.len() + 1);
            }
        }
    }

    #[test]
    fn numbers_may_be_unused_and_in_any_order() {
        for (count, next) in [(0, 300), (1, 1), (2, 2), (200, 200), (300, 100_000)] {
            let leaves: Vec<u32> = (0..count).rev().collect();
            check(&leaves, next);
        }
    }
}
