//! The entry of a tile in the directory: where its core and its border lie, and what they hold.

use std::ops::Range;

use crate::geometry::Rect;
use crate::store::format::codec::{Codec, MAX_RATIO};
use crate::store::format::damage::Damage;
use crate::store::format::extent::Extent;
use crate::store::format::generated::directory as schema;
use crate::store::format::limits::MAX_FLATBUFFER;
use crate::store::format::table_place::TablePlace;

/// The minimum number of bytes of a core per vertex: x and y.
const VERTEX_BYTES: u64 = 16;
/// The minimum number of bytes per triangle: corners and neighbours.
const TRIANGLE_BYTES: u64 = 6;

/// The number of bytes that a tile takes in a cache besides its content, at most.
const CACHED_BYTES: u64 = 2 << 10;

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
    /// Where the component table of the tile is.
    pub(crate) table: TablePlace,
}

impl TileEntry {
    /// The entry of a number that no tile has.
    pub(crate) const UNUSED: Self = {
        let nowhere = Extent::raw(0, 0, 0);
        Self {
            core: nowhere,
            border: nowhere,
            generation: 0,
            vertices: 0,
            core_triangles: 0,
            border_triangles: 0,
            owned_triangles: 0,
            bounds: Rect::EMPTY,
            table: TablePlace::Nowhere,
        }
    };

    /// Returns whether no tile has the number of this entry. Every tile has a vertex.
    #[must_use]
    pub fn is_unused(&self) -> bool {
        self.vertices == 0
    }

    /// Returns the codec of the tile: [`Codec::Raw`] if both extents are stored as they are.
    pub(crate) fn codec(&self) -> Codec {
        match self.core.codec {
            Codec::Raw => self.border.codec,
            codec => codec,
        }
    }

    /// Returns the lengths of core and border together, decoded, in bytes.
    #[must_use]
    pub fn decoded_bytes(&self) -> u64 {
        u64::from(self.core.decoded) + u64::from(self.border.decoded)
    }

    /// Returns about how many bytes the tile takes in a cache at most: 1.3 times those of core, border
    /// and component table, decoded.
    #[must_use]
    pub fn cached_bytes(&self) -> u64 {
        let bytes = self.decoded_bytes() + self.table.byte_size();
        bytes + bytes / 10 * 3 + CACHED_BYTES
    }

    /// Returns the lengths of core and border together, as they are stored, in bytes.
    #[must_use]
    pub fn stored_bytes(&self) -> u64 {
        u64::from(self.core.length) + u64::from(self.border.length)
    }

    /// Returns the range of the border together with the component table, if that lies behind it.
    pub(crate) fn border_and_table(&self) -> Option<Range<u64>> {
        let (border, table) = (self.border.range(), self.table.apart()?.range());
        (table.start == border.end.next_multiple_of(8)).then_some(border.start..table.end)
    }
}

pub(super) fn encode_entry(entry: &TileEntry) -> schema::TileEntry {
    schema::TileEntry::new(
        entry.core.offset,
        entry.border.offset,
        entry.core.length,
        entry.border.length,
        entry.core.decoded,
        entry.border.decoded,
        entry.core.crc,
        entry.border.crc,
        entry.generation,
        u32::from_le_bytes([entry.core.codec.number(), entry.border.codec.number(), 0, 0]),
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

/// Checks an extent: that it is in the file, and that its lengths are within the limits.
fn decode_extent(
    [offset, file_length]: [u64; 2],
    [length, decoded, crc]: [u32; 3],
    codec: u8,
) -> Result<Extent, Damage> {
    let codec = Codec::of_number(codec).ok_or_else(|| {
        Damage::new(format!(
            "it is stored with codec {codec}, which this program does not know"
        ))
    })?;
    let extent = Extent {
        offset,
        length,
        crc,
        codec,
        decoded,
    };
    extent.check("it", file_length, MAX_FLATBUFFER)?;
    let is_possible = match codec {
        Codec::Raw => decoded == length,
        Codec::Zstandard => u64::from(decoded) <= MAX_FLATBUFFER.min(MAX_RATIO * u64::from(length)),
    };
    if !is_possible {
        return Err(Damage::new(format!(
            "its extent of {length} bytes at {offset} cannot decode to {decoded} bytes"
        )));
    }
    Ok(extent)
}

/// Decodes an entry of a file of `file_length` bytes. The error says what is wrong with it.
pub(super) fn decode_entry(entry: &schema::TileEntry, file_length: u64) -> Result<TileEntry, Damage> {
    if entry.vertices() == 0 {
        return match (entry.core_length(), entry.border_length()) {
            (0, 0) => Ok(TileEntry::UNUSED),
            _ => Err(Damage::new("it has no vertex")),
        };
    }
    let [core_codec, border_codec, 0, 0] = entry.codecs().to_le_bytes() else {
        return Err(Damage::new(format!(
            "its codecs are {:#x}, which this program does not know",
            entry.codecs()
        )));
    };
    let core = decode_extent(
        [entry.core_offset(), file_length],
        [entry.core_length(), entry.core_decoded(), entry.core_crc()],
        core_codec,
    )?;
    let border = decode_extent(
        [entry.border_offset(), file_length],
        [entry.border_length(), entry.border_decoded(), entry.border_crc()],
        border_codec,
    )?;
    // Callers allocate memory according to these counts, so the extents must have room for what
    // they count.
    let [in_core, in_border] = [entry.core_triangles(), entry.border_triangles()].map(u64::from);
    let core_bytes = VERTEX_BYTES * u64::from(entry.vertices()) + TRIANGLE_BYTES * in_core;
    let owned = u64::from(entry.owned_triangles());
    if core_bytes > core.decoded.into()
        || TRIANGLE_BYTES * in_border > border.decoded.into()
        || !(in_core..=in_core + in_border).contains(&owned)
    {
        return Err(Damage::new(
            "its counts are larger than its extents, or contradict each other",
        ));
    }
    Ok(TileEntry {
        core,
        border,
        generation: entry.generation(),
        vertices: entry.vertices(),
        core_triangles: entry.core_triangles(),
        border_triangles: entry.border_triangles(),
        owned_triangles: entry.owned_triangles(),
        bounds: Rect::new(entry.min_x(), entry.min_y(), entry.max_x(), entry.max_y()),
        // It is in the page, beside the entry.
        table: TablePlace::Nowhere,
    })
}
