//! Where the component table of a tile is.

use crate::store::format::extent::Extent;

/// Where the [component table](crate::store::format::component_table) of a tile is. Nearly all
/// tables are short, and lie in the directory's page with the entry of the tile.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum TablePlace {
    /// Nowhere: the tile is one component, of which nothing is known.
    #[default]
    Nowhere,
    /// In the page.
    InPage(ShortTable),
    /// In an extent of its own.
    Apart(Extent),
}

/// A component table that lies in a page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ShortTable {
    length: u8,
    bytes: [u8; Self::MAX],
}

impl ShortTable {
    /// The maximum number of bytes. With the tables of all its tiles, a page must not exceed its
    /// own limit.
    pub(crate) const MAX: usize = 56;

    /// Returns the table, unless it is empty or too long for a page.
    pub(crate) fn new(table: &[u8]) -> Option<Self> {
        if table.is_empty() {
            return None;
        }
        let mut bytes = [0; Self::MAX];
        bytes.get_mut(..table.len())?.copy_from_slice(table);
        Some(Self {
            length: table.len() as u8,
            bytes,
        })
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        &self.bytes[..self.length.into()]
    }
}

impl TablePlace {
    /// Returns the extent of the table, if it lies apart.
    pub(crate) fn apart(&self) -> Option<Extent> {
        match self {
            Self::Apart(extent) => Some(*extent),
            _ => None,
        }
    }

    /// Returns the length of the table in bytes.
    pub(crate) fn byte_size(&self) -> u64 {
        match self {
            Self::Nowhere => 0,
            Self::InPage(table) => table.length.into(),
            Self::Apart(extent) => extent.decoded.into(),
        }
    }

    /// Returns the checksum of the table.
    pub(crate) fn crc(&self) -> u32 {
        match self {
            Self::Nowhere => 0,
            Self::InPage(table) => crc32c::crc32c(table.bytes()),
            Self::Apart(extent) => extent.crc,
        }
    }

    /// Returns whether the place holds this table, which may be empty.
    pub(crate) fn holds(&self, table: &[u8]) -> bool {
        match self {
            Self::Nowhere => table.is_empty(),
            Self::InPage(short) => short.bytes() == table,
            Self::Apart(extent) => (extent.length as usize, extent.crc) == (table.len(), crc32c::crc32c(table)),
        }
    }
}
