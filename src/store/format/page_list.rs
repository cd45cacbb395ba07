//! A list of pages: the level of the directory between the root and the pages.

use flatbuffers::FlatBufferBuilder;

use crate::store::format::cells_code;
use crate::store::format::coarse_bounds::CoarseBounds;
use crate::store::format::damage::Damage;
use crate::store::format::entry::Extent;
use crate::store::format::flat_buffer::{check_crc, finished, verified};
use crate::store::format::generated::directory as schema;
use crate::store::format::ids::TileId;
use crate::store::format::kd_tree::KdTree;
use crate::store::format::limits::{BLOCK, MAX_PAGE};
use crate::store::format::page::PageRef;
use crate::store::format::root::{PageListRef, Root};

/// A list of consecutive pages, and the part of the k-d tree above them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PageList {
    /// The number of the first page.
    pub(crate) first: u32,
    pub(crate) pages: Vec<PageRef>,
    /// Leaves name pages.
    pub(crate) tree: KdTree<u32>,
}

impl PageList {
    pub(crate) fn encode(&self) -> Vec<u8> {
        let mut builder = FlatBufferBuilder::new();
        let pages: Vec<_> = self.pages.iter().map(encode_ref).collect();
        let pages = Some(builder.create_vector(&pages));
        let cells = Some(cells_code::encode(&mut builder, &self.tree, self.first, |page| page));
        let first_page = self.first;
        let args = schema::PageListArgs {
            first_page,
            pages,
            cells,
        };
        let root = schema::PageList::create(&mut builder, &args);
        finished(builder, root)
    }

    /// Decodes the list at a place in the root of a file of `file_length` bytes. The error says what
    /// is wrong.
    pub(crate) fn decode(bytes: &[u8], place: usize, root: &Root, file_length: u64) -> Result<Self, Damage> {
        let list = &root.page_lists[place];
        check_crc("a list of pages", bytes, list.extent.crc)?;
        let table: schema::PageList<'_> = verified(bytes, "a list of pages")?;
        let first = table.first_page();
        let pages = table.pages().iter().map(|page| decode_ref(page, file_length));
        let pages: Vec<PageRef> = pages.collect::<Result<_, _>>()?;
        let tiles = pages.iter().map(|page| page.first).chain([root.next_tile(place)]);
        if first != list.first_page
            || pages.len() != root.pages_of(place) as usize
            || pages.first().is_none_or(|page| page.first != list.first_tile)
            || !tiles.is_sorted()
        {
            return Err(Damage::new("a list of pages is not the one that the root names"));
        }
        let bounds = pages
            .iter()
            .fold(CoarseBounds::EMPTY, |all, page| all.union(page.bounds));
        if bounds.union(list.bounds) != list.bounds {
            return Err(Damage::new("the bounds of a list of pages do not contain its pages"));
        }
        let tree = cells_code::decode(table.cells(), first, |page| match page < root.pages {
            true => Ok(page),
            false => Err(Damage::new(format!(
                "the k-d tree names page {page}, which there is not"
            ))),
        })?;
        Ok(Self { first, pages, tree })
    }

    /// Returns what refers to the list, given where it is.
    pub(crate) fn at(&self, extent: Extent) -> PageListRef {
        PageListRef {
            extent,
            first_page: self.first,
            first_tile: self.pages.first().map_or(0, |page| page.first),
            bounds: self
                .pages
                .iter()
                .fold(CoarseBounds::EMPTY, |all, page| all.union(page.bounds)),
        }
    }

    /// Returns the place in this list of the page that has the entry of a tile. The tile must not
    /// precede the list.
    pub(crate) fn page_with(&self, id: TileId) -> usize {
        self.pages.partition_point(|page| page.first <= id.0).saturating_sub(1)
    }

    /// Returns the first tile after the page at a place in this list. `next` is the first tile
    /// after the list.
    pub(crate) fn next_tile(&self, place: usize, next: u32) -> u32 {
        self.pages.get(place + 1).map_or(next, |page| page.first)
    }
}

fn encode_ref(page: &PageRef) -> schema::PageRef {
    let [min_x, min_y] = page.bounds.min;
    let [max_x, max_y] = page.bounds.max;
    schema::PageRef::new(
        (page.extent.offset / BLOCK) as u32,
        page.extent.crc,
        page.first,
        page.extent.length as u16,
        min_x,
        min_y,
        max_x,
        max_y,
        0,
    )
}

fn decode_ref(page: &schema::PageRef, file_length: u64) -> Result<PageRef, Damage> {
    let extent = Extent::raw(u64::from(page.offset()) * BLOCK, page.length().into(), page.crc());
    extent.check("a page of the directory", file_length, MAX_PAGE)?;
    Ok(PageRef {
        extent,
        first: page.first_tile(),
        bounds: CoarseBounds {
            min: [page.min_x(), page.min_y()],
            max: [page.max_x(), page.max_y()],
        },
    })
}
