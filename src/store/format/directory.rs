//! The whole directory in memory: the k-d tree, an entry for each tile, and the metadata and lists
//! of the file.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::geometry::Rect;
use crate::store::format::codec::Codec;
use crate::store::format::damage::Damage;
use crate::store::format::entry::TileEntry;
use crate::store::format::extent::Extent;
use crate::store::format::ids::TileId;
use crate::store::format::kd_tree::{KdNode, KdTree};
use crate::store::format::layout::{Layout, PageLayout, PageListLayout};
use crate::store::format::lists::Lists;
use crate::store::format::metadata::Metadata;
use crate::store::format::overview::OverviewEntry;
use crate::store::format::page::{Page, PageRef};
use crate::store::format::page_list::PageList;
use crate::store::format::root::Root;

/// The whole directory of a tile file, in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Directory {
    /// The metadata of the whole file.
    pub metadata: Metadata,
    /// The lists of the file.
    pub lists: Lists,
    /// The k-d tree of the cells.
    pub tree: KdTree,
    /// The entry of each tile, by its number. Numbers may be unused.
    pub tiles: Vec<TileEntry>,
    /// The overviews, from the finest to the coarsest, stale ones too.
    pub(crate) overviews: Vec<OverviewEntry>,
    /// The division into pages.
    pub(crate) layout: Layout,
}

impl Directory {
    /// Returns whether lines were split where they cross each other or cell borders.
    pub(crate) fn has_split_lines(&self) -> bool {
        self.metadata.crossings > 0 || !self.lists.cell_borders.is_empty()
    }

    /// Creates a directory that is in no file yet.
    pub(crate) fn new(metadata: Metadata, lists: Lists, tree: KdTree, tiles: Vec<TileEntry>) -> Self {
        Self {
            layout: Layout::of(&tree, tiles.len() as u32),
            metadata: Metadata {
                tiles: tree.tiles(),
                ..metadata
            },
            lists,
            tree,
            tiles,
            overviews: Vec::new(),
        }
    }

    /// Returns the tiles in the order of the leaves of the tree, which is that of scans.
    pub fn tile_ids(&self) -> impl Iterator<Item = TileId> {
        self.tree.leaves()
    }

    /// Returns the entry of a tile, or `None` if there is no tile of this number.
    #[must_use]
    pub fn entry(&self, id: TileId) -> Option<&TileEntry> {
        self.tiles.get(id.0 as usize).filter(|entry| !entry.is_unused())
    }

    /// Returns the codec of the first tile, which new ones take over.
    pub(crate) fn codec(&self) -> Codec {
        let first = self.tile_ids().find_map(|id| self.entry(id));
        first.map_or(Codec::Raw, TileEntry::codec)
    }

    /// Returns the number of bytes that the directory takes in the file that it was read from.
    #[must_use]
    pub fn stored_bytes(&self) -> u64 {
        let extents = self.own_extents().flatten();
        extents.map(|extent| u64::from(extent.length)).sum()
    }

    /// Returns the ranges of the file that it refers to, and its own, in no order. Overviews count as
    /// a whole.
    pub(crate) fn ranges(&self) -> Vec<Range<u64>> {
        let used = self.tiles.iter().filter(|entry| !entry.is_unused());
        let of_tiles = used.flat_map(|entry| [Some(entry.core), Some(entry.border), entry.table.apart()]);
        let overviews = self.overviews.iter().map(OverviewEntry::range);
        let extents = of_tiles.chain(self.own_extents()).flatten();
        extents.map(Extent::range).chain(overviews).collect()
    }

    /// Returns the extents of the directory itself.
    fn own_extents(&self) -> impl Iterator<Item = Option<Extent>> {
        let Layout {
            page_lists,
            pages,
            lists,
            root,
            ..
        } = &self.layout;
        let extents = page_lists.iter().map(|list| list.extent);
        extents
            .chain(pages.iter().map(|page| page.extent))
            .chain(*lists)
            .chain([*root])
    }

    /// Replaces the entries of all tiles. Pages in which one differs are no longer in the file.
    pub(crate) fn set_tiles(&mut self, tiles: Vec<TileEntry>) {
        let before = std::mem::replace(&mut self.tiles, tiles);
        for list in &mut self.layout.page_lists {
            for page in &mut self.layout.pages[list.pages.start as usize..list.pages.end as usize] {
                let range = page.tiles.start as usize..page.tiles.end as usize;
                if before[range.clone()] != self.tiles[range] {
                    page.extent = None;
                    list.extent = None;
                }
            }
        }
    }

    /// Removes the leaves of tiles that have no vertices any more. The numbers of tiles stay.
    pub(crate) fn remove_emptied(&mut self) {
        if self.tile_ids().all(|id| self.entry(id).is_some()) {
            return;
        }
        self.tree = self.tree.without(|id: TileId| self.entry(id).is_none());
        if self.tree.tiles() == 0 {
            self.tiles.clear();
        }
        self.divide_anew();
    }

    /// Replaces leaves by subtrees, by their tiles. With them there are `count` numbers of tiles; new
    /// ones have no entries yet.
    pub(crate) fn cut_leaves(&mut self, subtrees: &BTreeMap<TileId, KdTree>, count: usize) {
        self.tree = self.tree.with_subtrees(subtrees);
        self.tiles.resize(count, TileEntry::UNUSED);
        self.divide_anew();
    }

    /// Divides the directory into pages, after the tree was changed.
    fn divide_anew(&mut self) {
        self.metadata.tiles = self.tree.tiles();
        let lists = self.layout.lists;
        self.layout = Layout {
            lists,
            ..Layout::of(&self.tree, self.tiles.len() as u32)
        };
    }

    /// Makes the box around all vertices the one around all tiles. References to pages have boxes
    /// that are relative to it.
    pub(crate) fn renew_bounds(&mut self) {
        let boxes = self.tiles.iter().map(|entry| entry.bounds);
        let bounds = boxes.fold(Rect::EMPTY, Rect::union);
        if bounds != self.metadata.bounds {
            self.metadata.bounds = bounds;
            self.layout.page_lists.iter_mut().for_each(|list| list.extent = None);
        }
    }

    /// Returns the page with this number.
    pub(crate) fn page(&self, number: usize) -> Page {
        let PageLayout { tiles, nodes, .. } = &self.layout.pages[number];
        Page {
            first: tiles.start,
            entries: self.tiles[tiles.start as usize..tiles.end as usize].to_vec(),
            tree: self.tree.subtree(nodes.clone()),
        }
    }

    /// Returns the list of pages at a place. `pages` are the references to all pages.
    pub(crate) fn page_list(&self, place: usize, pages: &[PageRef]) -> PageList {
        let PageListLayout { pages: range, tree, .. } = &self.layout.page_lists[place];
        PageList {
            first: range.start,
            pages: pages[range.start as usize..range.end as usize].to_vec(),
            tree: tree.clone(),
        }
    }

    /// Puts a directory together from its parts, each of which was checked by itself. The error
    /// says how they contradict each other, or the `file_length`.
    pub(crate) fn assemble(
        (root, extent): (Root, Extent),
        page_lists: &[PageList],
        pages: Vec<Page>,
        lists: Lists,
        file_length: u64,
    ) -> Result<Self, Damage> {
        // A part that is named twice would make the whole larger than its parts.
        let mut is_named = Named::new("list of pages", page_lists.len());
        let above = root.tree.grafted(|list| {
            is_named.take(list)?;
            Ok(&page_lists[list as usize].tree)
        })?;
        let mut is_named = Named::new("page", pages.len());
        let tree = above.grafted(|page| {
            is_named.take(page)?;
            Ok(&pages[page as usize].tree)
        })?;
        let mut is_named = Named::new("tile", root.next_tile as usize);
        tree.leaves().try_for_each(|tile| is_named.take(tile.0))?;
        if root.metadata.line_kinds != lists.line_kinds() {
            return Err(Damage::new("its kinds of lines are not those of the list of lines"));
        }
        let mut layout = layout(&root, page_lists, &pages, &above);
        layout.root = Some(extent);
        let tiles: Vec<TileEntry> = pages.into_iter().flat_map(|page| page.entries).collect();
        let this = Self {
            metadata: root.metadata,
            lists,
            tree,
            tiles,
            overviews: root.overviews,
            layout,
        };
        this.check_counts(file_length)?;
        Ok(this)
    }

    fn check_counts(&self, file_length: u64) -> Result<(), Damage> {
        let used = || self.tiles.iter().filter(|entry| !entry.is_unused());
        let (count, named) = (used().count(), self.tree.tiles());
        if self.tile_ids().any(|id| self.entry(id).is_none()) || count != named as usize || named != self.metadata.tiles
        {
            return Err(Damage::new(format!(
                "it counts {} tiles, but has {count} entries and {named} cells",
                self.metadata.tiles
            )));
        }
        let stored: u64 = used()
            .map(|t| u64::from(t.core.length) + u64::from(t.border.length))
            .sum();
        if stored > file_length {
            return Err(Damage::new(format!(
                "its tiles take {stored} bytes, more than the file has"
            )));
        }
        let sum = |count: fn(&TileEntry) -> u32| used().map(|t| u64::from(count(t))).sum::<u64>();
        let (vertices, triangles) = (sum(|t| t.vertices), sum(|t| t.owned_triangles));
        if vertices != self.metadata.vertices || triangles != self.metadata.triangles {
            return Err(Damage::new("the counts of its tiles do not add up"));
        }
        Ok(())
    }
}

/// Checks that things are named at most once each, and exist.
struct Named {
    what: &'static str,
    is_named: Vec<bool>,
}

impl Named {
    fn new(what: &'static str, count: usize) -> Self {
        Self {
            what,
            is_named: vec![false; count],
        }
    }

    fn take(&mut self, number: u32) -> Result<(), Damage> {
        match self.is_named.get_mut(number as usize) {
            Some(is_named) if !*is_named => {
                *is_named = true;
                Ok(())
            }
            _ => Err(Damage::new(format!(
                "the k-d tree names {} {number} twice, or there is none",
                self.what
            ))),
        }
    }
}

/// Returns how the parts of a directory are divided, and where they are. `above` is the tree whose
/// leaves are pages.
fn layout(root: &Root, page_lists: &[PageList], pages: &[Page], above: &KdTree<u32>) -> Layout {
    let mut nodes = vec![0..0; pages.len()];
    // In preorder, each leaf that is a page stands for the nodes of that page.
    let mut at = 0;
    for node in above.nodes() {
        let mut count = 1;
        if let KdNode::Leaf(page) = *node {
            count = pages[page as usize].tree.nodes().len() as u32;
            nodes[page as usize] = at..at + count;
        }
        at += count;
    }
    let extents = page_lists.iter().flat_map(|list| &list.pages);
    let pages = pages
        .iter()
        .zip(extents)
        .zip(nodes)
        .map(|((page, at), nodes)| PageLayout {
            extent: Some(at.extent),
            tiles: page.first..page.first + page.entries.len() as u32,
            nodes,
        });
    let page_lists = page_lists
        .iter()
        .zip(&root.page_lists)
        .map(|(list, at)| PageListLayout {
            extent: Some(at.extent),
            pages: list.first..list.first + list.pages.len() as u32,
            tree: list.tree.clone(),
        });
    Layout {
        top: root.tree.clone(),
        page_lists: page_lists.collect(),
        pages: pages.collect(),
        lists: root.lists,
        root: None,
    }
}
