//! The root of the directory: the metadata, and where everything else of the directory lies.

use bytes::Bytes;
use flatbuffers::FlatBufferBuilder;

use crate::store::format::cells_code;
use crate::store::format::coarse_bounds::CoarseBounds;
use crate::store::format::damage::Damage;
use crate::store::format::extent::Extent;
use crate::store::format::flat_buffer::{finished, verified};
use crate::store::format::generated::directory as schema;
use crate::store::format::ids::TileId;
use crate::store::format::kd_tree::KdTree;
use crate::store::format::limits::{MAX_FLATBUFFER, MAX_PAGE};
use crate::store::format::lists::{LIST_NAMES, OfLists};
use crate::store::format::metadata::Metadata;
use crate::store::format::overview;
use crate::store::format::overview::OverviewEntry;
use crate::store::format::page::Frame;

/// The root.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Root {
    pub(crate) metadata: Metadata,
    /// Tiles have numbers below this one.
    pub(crate) next_tile: u32,
    /// The number of pages.
    pub(crate) pages: u32,
    pub(crate) lists: OfLists<Option<Extent>>,
    pub(crate) page_lists: Vec<PageListRef>,
    /// The top of the k-d tree. Leaves name lists of pages.
    pub(crate) tree: KdTree<u32>,
    /// From the finest to the coarsest.
    pub(crate) overviews: Vec<OverviewEntry>,
}

/// Where a list of pages lies, and what it contains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PageListRef {
    pub(crate) extent: Extent,
    /// The number of its first page.
    pub(crate) first_page: u32,
    /// The first tile of its first page.
    pub(crate) first_tile: u32,
    pub(crate) bounds: CoarseBounds,
}

impl Root {
    pub(crate) fn encode(&self) -> Vec<u8> {
        let mut builder = FlatBufferBuilder::new();
        let page_lists: Vec<_> = self.page_lists.iter().map(encode_ref).collect();
        let page_lists = Some(builder.create_vector(&page_lists));
        let cells = Some(cells_code::encode(&mut builder, &self.tree, 0, |list| list));
        let overviews: Vec<_> = self.overviews.iter().map(overview::encode).collect();
        let overviews = (!overviews.is_empty()).then(|| builder.create_vector(&overviews));
        let parts = self.lists.map(|list| list.map(encode_part));
        let [sources, crs, lines, hole_points, cell_borders, polygon_lines] = &parts;
        let [triangles, vertices, constraint_edges, holes, z, edge_sources, sites] = self.metadata.digest.to_schema();
        let args = schema::DirectoryArgs {
            triangle_sum: Some(&triangles),
            vertex_sum: Some(&vertices),
            constraint_edge_sum: Some(&constraint_edges),
            hole_sum: Some(&holes),
            vertex_z_sum: Some(&z),
            edge_source_sum: Some(&edge_sources),
            site_sum: Some(&sites),
            next_tile: self.next_tile,
            pages: self.pages,
            cells,
            page_lists,
            overviews,
            sources: sources.as_ref(),
            crs: crs.as_ref(),
            lines: lines.as_ref(),
            hole_points: hole_points.as_ref(),
            cell_borders: cell_borders.as_ref(),
            polygon_lines: polygon_lines.as_ref(),
            ..self.metadata.encode(&mut builder)
        };
        let root = schema::Directory::create(&mut builder, &args);
        finished(builder, root)
    }

    /// Decodes the root of a file of `file_length` bytes from its bytes. The error says what is
    /// wrong.
    pub(crate) fn decode(bytes: &Bytes, file_length: u64) -> Result<Self, Damage> {
        let root: schema::Directory<'_> = verified(bytes, "the directory's root")?;
        let metadata = Metadata::decode(root)?;
        let parts = [
            root.sources(),
            root.crs(),
            root.lines(),
            root.hole_points(),
            root.cell_borders(),
            root.polygon_lines(),
        ];
        let mut lists = OfLists::default();
        for ((list, part), name) in lists.iter_mut().zip(parts).zip(LIST_NAMES) {
            *list = part.map(|part| decode_part(name, part, file_length)).transpose()?;
        }
        let refs = root.page_lists().iter().map(|list| decode_ref(list, file_length));
        let page_lists: Vec<PageListRef> = refs.collect::<Result<_, _>>()?;
        let (next_tile, pages) = (root.next_tile(), root.pages());
        let tiles = page_lists.iter().map(|list| list.first_tile).chain([next_tile]);
        let starts = page_lists.iter().map(|list| list.first_page).chain([pages]);
        if !tiles.is_sorted() || !starts.is_sorted_by(|a, b| a < b) {
            return Err(Damage::new("its lists of pages are not in order"));
        }
        if page_lists.is_empty() && (pages > 0 || next_tile > 0) {
            return Err(Damage::new("it has tiles, but no pages"));
        }
        if page_lists
            .first()
            .is_some_and(|first| first.first_tile > 0 || first.first_page > 0)
        {
            return Err(Damage::new("its first list of pages does not start at tile 0"));
        }
        let count = page_lists.len() as u32;
        let tree = cells_code::decode(root.cells(), 0, |list| match list < count {
            true => Ok(list),
            false => Err(Damage::new(format!(
                "the k-d tree names list {list}, which there is not"
            ))),
        })?;
        if metadata.tiles > next_tile || (metadata.tiles > 0) != (tree.tiles() > 0) {
            return Err(Damage::new(format!(
                "it counts {} tiles, but has numbers for {next_tile}",
                metadata.tiles
            )));
        }
        let overviews = root.overviews().map(|list| list.iter().copied());
        let overviews = overviews.map(|list| overview::decode(list, file_length));
        let overviews = overviews.transpose()?.unwrap_or_default();
        for list in &page_lists {
            overview::check_apart(&overviews, list.extent.offset, list.extent.length.into())?;
        }
        Ok(Self {
            metadata,
            next_tile,
            pages,
            lists,
            page_lists,
            tree,
            overviews,
        })
    }

    /// Returns what the parts of the directory have in common, for a file of this length.
    pub(crate) fn frame(&self, file_length: u64) -> Frame {
        Frame {
            bounds: self.metadata.bounds,
            next_tile: self.next_tile,
            file_length,
        }
    }

    /// Returns the place of the list of pages that leads to a tile.
    pub(crate) fn list_with(&self, id: TileId) -> usize {
        let after = self.page_lists.partition_point(|list| list.first_tile <= id.0);
        after.saturating_sub(1)
    }

    /// Returns the place of the list that has a page.
    pub(crate) fn list_of_page(&self, page: u32) -> usize {
        let after = self.page_lists.partition_point(|list| list.first_page <= page);
        after.saturating_sub(1)
    }

    /// Returns the first tile after a list of pages.
    pub(crate) fn next_tile(&self, list: usize) -> u32 {
        self.page_lists
            .get(list + 1)
            .map_or(self.next_tile, |list| list.first_tile)
    }

    /// Returns the number of pages in a list of pages.
    pub(crate) fn pages_of(&self, list: usize) -> u32 {
        let next = self.page_lists.get(list + 1).map_or(self.pages, |list| list.first_page);
        next - self.page_lists[list].first_page
    }
}

fn encode_part(extent: Extent) -> schema::PartExtent {
    schema::PartExtent::new(extent.offset, extent.length, extent.crc)
}

fn decode_part(what: &str, part: &schema::PartExtent, file_length: u64) -> Result<Extent, Damage> {
    let extent = Extent::raw(part.offset(), part.length(), part.crc());
    extent.check(what, file_length, MAX_FLATBUFFER)?;
    Ok(extent)
}

fn encode_ref(list: &PageListRef) -> schema::PageListRef {
    let [min_x, min_y] = list.bounds.min;
    let [max_x, max_y] = list.bounds.max;
    let Extent {
        offset, length, crc, ..
    } = list.extent;
    let (first_page, first_tile) = (list.first_page, list.first_tile);
    schema::PageListRef::new(offset, length, crc, first_page, first_tile, min_x, min_y, max_x, max_y)
}

fn decode_ref(list: &schema::PageListRef, file_length: u64) -> Result<PageListRef, Damage> {
    let extent = Extent::raw(list.offset(), list.length(), list.crc());
    extent.check("a list of pages", file_length, MAX_PAGE)?;
    Ok(PageListRef {
        extent,
        first_page: list.first_page(),
        first_tile: list.first_tile(),
        bounds: CoarseBounds {
            min: [list.min_x(), list.min_y()],
            max: [list.max_x(), list.max_y()],
        },
    })
}
