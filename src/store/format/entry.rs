//! The entry of a tile in the directory: where its core and its border lie, and what they hold.

use std::ops::Range;

use crate::geometry::Rect;
use crate::io::memory_of;
use crate::store::format::codec::{Codec, MAX_RATIO};
use crate::store::format::damage::Damage;
use crate::store::format::generated::directory as schema;
use crate::store::format::limits::{FIRST_EXTENT, MAX_FLATBUFFER};

/// The minimum number of bytes of a core per vertex: x and y.
const VERTEX_BYTES: u64 = 16;
/// The minimum number of bytes per triangle: corners and neighbours.
const TRIANGLE_BYTES: u64 = 6;

/// A range of bytes in the file, its CRC-32C, and its codec.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// The offset from the start of the file, in bytes.
    pub offset: u64,
    /// The length in bytes.
    pub length: u32,
    /// The CRC-32C of the bytes.
    pub crc: u32,
    /// How the bytes are stored.
    pub codec: Codec,
    /// The length of what they decode to, in bytes.
    pub decoded: u32,
}

impl Extent {
    /// Returns the extent of bytes that are stored as they are.
    pub(crate) const fn raw(offset: u64, length: u32, crc: u32) -> Self {
        Self {
            offset,
            length,
            crc,
            codec: Codec::Raw,
            decoded: length,
        }
    }

    /// Returns the bytes of memory that reading and decoding take at most: the stored bytes, and,
    /// if these are not used in place, a plan and what it decodes to.
    pub(crate) fn memory_to_open(self) -> u64 {
        let decoding = match self.codec {
            Codec::Raw => 0,
            Codec::Zstandard => 2 * u64::from(self.decoded),
        };
        memory_of(self.length as usize) as u64 + decoding
    }

    /// Returns the range of the bytes, counted from the start of the file.
    #[must_use]
    pub fn range(self) -> Range<u64> {
        self.offset..self.offset + u64::from(self.length)
    }

    /// Checks that the bytes are within a file of `file_length` bytes, and not longer than `most`.
    /// `what` names them in the error.
    pub(super) fn check(self, what: &str, file_length: u64, most: u64) -> Result<(), Damage> {
        let end = self.offset.checked_add(self.length.into());
        let is_inside = self.offset >= FIRST_EXTENT && end.is_some_and(|end| end <= file_length);
        if is_inside && u64::from(self.length) <= most {
            return Ok(());
        }
        let Self { offset, length, .. } = self;
        Err(Damage::new(format!(
            "{what}: the extent of {length} bytes at {offset} is out of range"
        )))
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

    /// Returns the lengths of core and border together, as they are stored, in bytes.
    #[must_use]
    pub fn stored_bytes(&self) -> u64 {
        u64::from(self.core.length) + u64::from(self.border.length)
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
    })
}
