//! A page of the directory: the entries of tiles with consecutive numbers, and a subtree of the
//! k-d tree.

use flatbuffers::FlatBufferBuilder;

use crate::geometry::Rect;
use crate::store::format::cells_code;
use crate::store::format::coarse_bounds::CoarseBounds;
use crate::store::format::damage::Damage;
use crate::store::format::entry::{Extent, TileEntry, decode_entry, encode_entry};
use crate::store::format::flat_buffer::{check_crc, finished, verified};
use crate::store::format::generated::directory as schema;
use crate::store::format::ids::TileId;
use crate::store::format::kd_tree::KdTree;

/// A page.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Page {
    /// The tile of the first entry.
    pub(crate) first: u32,
    pub(crate) entries: Vec<TileEntry>,
    pub(crate) tree: KdTree,
}

/// Where a page lies, and what it contains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PageRef {
    pub(crate) extent: Extent,
    /// The tile of its first entry.
    pub(crate) first: u32,
    /// The bounds of its tiles.
    pub(crate) bounds: CoarseBounds,
}

/// What the parts of a directory have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    /// The bounds of all vertices.
    pub(crate) bounds: Rect,
    /// Tiles have numbers below this one.
    pub(crate) next_tile: u32,
    /// The length of the file in bytes.
    pub(crate) file_length: u64,
}

impl Page {
    pub(crate) fn encode(&self) -> Vec<u8> {
        let mut builder = FlatBufferBuilder::new();
        let entries: Vec<_> = self.entries.iter().map(encode_entry).collect();
        let entries = Some(builder.create_vector(&entries));
        let cells = Some(cells_code::encode(&mut builder, &self.tree, self.first, |tile| tile.0));
        let first_tile = self.first;
        let args = schema::PageArgs {
            first_tile,
            entries,
            cells,
        };
        let root = schema::Page::create(&mut builder, &args);
        finished(builder, root)
    }

    /// Decodes a page from its bytes, and checks it against the reference to it. `next` is the
    /// first tile after it. The error says what is wrong.
    pub(crate) fn decode(bytes: &[u8], page: &PageRef, next: u32, frame: &Frame) -> Result<Self, Damage> {
        check_crc("a page of the directory", bytes, page.extent.crc)?;
        let root: schema::Page<'_> = verified(bytes, "a page of the directory")?;
        let first = root.first_tile();
        if first != page.first || first.checked_add(root.entries().len() as u32) != Some(next) {
            return Err(Damage::new(format!(
                "a page has {} tiles from {first} on, not those from {} up to {next}",
                root.entries().len(),
                page.first
            )));
        }
        let entries = root.entries().iter().zip(first..).map(|(entry, tile)| {
            decode_entry(entry, frame.file_length).map_err(|damage| damage.of(&format!("tile {tile}")))
        });
        let entries: Vec<TileEntry> = entries.collect::<Result<_, _>>()?;
        let tree = cells_code::decode(root.cells(), first, |tile| match tile < frame.next_tile {
            true => Ok(TileId(tile)),
            false => Err(Damage::new(format!("a leaf names tile {tile}, which there is not"))),
        })?;
        let is_within = |e: &TileEntry| e.is_unused() || frame.bounds.union(e.bounds) == frame.bounds;
        if let Some(place) = entries.iter().position(|entry| !is_within(entry)) {
            let tile = first as usize + place;
            return Err(Damage::new(format!(
                "the bounds of tile {tile} exceed those of the file"
            )));
        }
        let this = Self { first, entries, tree };
        // Queries skip pages by their bounds.
        let bounds = this.bounds(frame.bounds);
        if bounds.union(page.bounds) != page.bounds {
            return Err(Damage::new("the bounds of a page do not contain its tiles"));
        }
        Ok(this)
    }

    /// Returns the bounds of the page's tiles. `whole` contains all vertices.
    pub(crate) fn bounds(&self, whole: Rect) -> CoarseBounds {
        let used = self.entries.iter().filter(|entry| !entry.is_unused());
        let all = used.fold(Rect::EMPTY, |all, entry| all.union(entry.bounds));
        CoarseBounds::around(all, whole)
    }

    /// Returns what refers to the page, given where it is.
    pub(crate) fn at(&self, extent: Extent, whole: Rect) -> PageRef {
        PageRef {
            extent,
            first: self.first,
            bounds: self.bounds(whole),
        }
    }

    /// Returns the entry of a tile, if it is in this page and in use.
    pub(crate) fn entry(&self, id: TileId) -> Option<&TileEntry> {
        let slot = id.0.checked_sub(self.first)?;
        self.entries.get(slot as usize).filter(|entry| !entry.is_unused())
    }

    /// Returns the number of bytes that the page takes in memory.
    pub(crate) fn byte_size(&self) -> usize {
        size_of::<Self>() + size_of_val(&*self.entries) + size_of_val(self.tree.nodes())
    }
}
