//! The entry of a tile in the directory: where its core and its border lie, and what they hold.

use std::ops::Range;

use crate::geometry::Rect;
use crate::store::format::damage::Damage;
use crate::store::format::generated::directory as schema;
use crate::store::format::superblock::{FIRST_EXTENT, MAX_FLATBUFFER, Superblock};

/// The minimum number of bytes of a core per vertex: x and y.
const VERTEX_BYTES: u64 = 16;
/// The minimum number of bytes per triangle: corners and neighbours.
const TRIANGLE_BYTES: u64 = 6;

/// A range of bytes in the file, and its CRC-32C.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// The offset from the start of the file, in bytes.
    pub offset: u64,
    /// The length in bytes.
    pub length: u32,
    /// The CRC-32C of the bytes.
    pub crc: u32,
}

impl Extent {
    /// Returns the range of the bytes, counted from the start of the file.
    #[must_use]
    pub fn range(self) -> Range<u64> {
        self.offset..self.offset + u64::from(self.length)
    }
}

/// The entry of a tile in the directory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileEntry {
    /// The extent of the tile's core.
    pub core: Extent,
    /// The extent of the tile's border.
    pub border: Extent,
    /// The generation of the file in which the tile was written.
    pub generation: u32,
    /// The number of vertices that the tile owns.
    pub vertices: u32,
    /// The number of triangles in its core.
    pub core_triangles: u32,
    /// The number of triangles in its border, which may be in the borders of other tiles too.
    pub border_triangles: u32,
    /// The number of triangles that belong to this tile: all of its core, and those of its border
    /// whose lexicographically smallest vertex the tile owns.
    pub owned_triangles: u32,
    /// The bounding rectangle of the tile's vertices and of all corners of the triangles that
    /// belong to it.
    pub bounds: Rect,
}

pub(super) fn encode_entry(entry: &TileEntry) -> schema::TileEntry {
    schema::TileEntry::new(
        entry.core.offset,
        entry.border.offset,
        entry.core.length,
        entry.border.length,
        entry.core.crc,
        entry.border.crc,
        entry.generation,
        0,
        entry.vertices,
        entry.core_triangles,
        entry.border_triangles,
        entry.owned_triangles,
        entry.bounds.min_x,
        entry.bounds.min_y,
        entry.bounds.max_x,
        entry.bounds.max_y,
    )
}

pub(super) fn decode_entry(entry: &schema::TileEntry, superblock: &Superblock) -> Result<TileEntry, Damage> {
    if entry.codec() != 0 {
        return Err(Damage::new(format!(
            "it is stored with codec {}, which this program does not know",
            entry.codec()
        )));
    }
    for (offset, length) in [
        (entry.core_offset(), entry.core_length()),
        (entry.border_offset(), entry.border_length()),
    ] {
        let end = offset.checked_add(length.into());
        let inside = offset >= FIRST_EXTENT && end.is_some_and(|end| end <= superblock.file_length);
        if !inside || u64::from(length) > MAX_FLATBUFFER {
            return Err(Damage::new(format!(
                "its extent of {length} bytes at {offset} is out of range"
            )));
        }
    }
    // Callers allocate memory according to these counts, so the extents must have room for what
    // they count.
    let (core, border) = (u64::from(entry.core_triangles()), u64::from(entry.border_triangles()));
    let core_bytes = VERTEX_BYTES * u64::from(entry.vertices()) + TRIANGLE_BYTES * core;
    let owned = u64::from(entry.owned_triangles());
    if core_bytes > entry.core_length().into()
        || TRIANGLE_BYTES * border > entry.border_length().into()
        || !(core..=core + border).contains(&owned)
    {
        return Err(Damage::new(
            "its counts are larger than its extents, or contradict each other",
        ));
    }
    Ok(TileEntry {
        core: Extent {
            offset: entry.core_offset(),
            length: entry.core_length(),
            crc: entry.core_crc(),
        },
        border: Extent {
            offset: entry.border_offset(),
            length: entry.border_length(),
            crc: entry.border_crc(),
        },
        generation: entry.generation(),
        vertices: entry.vertices(),
        core_triangles: entry.core_triangles(),
        border_triangles: entry.border_triangles(),
        owned_triangles: entry.owned_triangles(),
        bounds: Rect::new(entry.min_x(), entry.min_y(), entry.max_x(), entry.max_y()),
    })
}
