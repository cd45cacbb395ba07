//! Codecs: how the bytes of a core or a border are stored.
//!
//! A codec maps bytes to bytes. It decodes to exactly the FlatBuffer that was encoded, so only the
//! code that appends extents and [`Tile::open`](crate::store::Tile) know of it.
//!
//! With [`Codec::Zstandard`], the FlatBuffer is first transformed into a *plan*, which is shorter
//! and compresses better: coordinates become integers where they are decimals, neighbours that
//! follow from others are left out, and the rest is coded as differences, in byte planes.
//! `schema/FORMAT.md` specifies plans.

#[cfg(feature = "compression")]
mod column;
#[cfg(feature = "compression")]
mod encode_column;
#[cfg(feature = "compression")]
mod encode_mesh;
#[cfg(feature = "compression")]
mod encode_plan;
#[cfg(feature = "compression")]
mod fields;
#[cfg(feature = "compression")]
mod mesh;
mod part;
#[cfg(feature = "compression")]
mod plan;
#[cfg(feature = "compression")]
mod planes;
#[cfg(all(test, feature = "compression"))]
mod tests;
#[cfg(feature = "compression")]
mod zstandard;

use bytes::Bytes;

pub(crate) use part::Part;

use crate::store::format::damage::Damage;

/// The most bytes that a stored byte may decode to. Counts of the entry are compared with the
/// decoded length, so with this limit they are in proportion to the length of the file.
pub(crate) const MAX_RATIO: u64 = 256;

/// How a core or a border is stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Codec {
    /// The FlatBuffer as it is.
    #[default]
    Raw,
    /// Transformed, and compressed by Zstandard. Needs the feature `compression`.
    Zstandard,
}

/// A core or a border as it is stored.
#[derive(Clone, Debug)]
pub(crate) struct StoredPart {
    pub(crate) bytes: Bytes,
    /// The checksum of these bytes.
    pub(crate) crc: u32,
    pub(crate) codec: Codec,
    /// The length of the FlatBuffer in bytes.
    pub(crate) decoded: usize,
}

impl From<&Bytes> for StoredPart {
    /// Stores a FlatBuffer as it is.
    fn from(flatbuffer: &Bytes) -> Self {
        Codec::Raw.store(flatbuffer.clone(), Part::Core)
    }
}

impl Codec {
    /// Whether this build of the library has [`Zstandard`](Self::Zstandard).
    pub(crate) const HAS_ZSTANDARD: bool = cfg!(feature = "compression");

    /// Returns the name of the codec in summaries.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Raw => "raw",
            Self::Zstandard => "zstd",
        }
    }

    /// Returns the number that stands for the codec in files.
    pub(crate) const fn number(self) -> u8 {
        match self {
            Self::Raw => 0,
            Self::Zstandard => 1,
        }
    }

    /// Returns the codec of a number.
    pub(crate) const fn of_number(number: u8) -> Option<Self> {
        match number {
            0 => Some(Self::Raw),
            1 => Some(Self::Zstandard),
            _ => None,
        }
    }

    /// Encodes a FlatBuffer. It is stored as it is if it decoded to more than [`MAX_RATIO`] bytes
    /// per stored byte.
    pub(crate) fn store(self, flatbuffer: Bytes, part: Part) -> StoredPart {
        #[cfg(feature = "compression")]
        if self == Self::Zstandard
            && let Some(stored) = zstandard::encode(&flatbuffer, part)
            && flatbuffer.len() as u64 <= MAX_RATIO * stored.len() as u64
        {
            return StoredPart {
                crc: crc32c::crc32c(&stored),
                bytes: stored.into(),
                codec: self,
                decoded: flatbuffer.len(),
            };
        }
        let _ = part;
        StoredPart {
            crc: crc32c::crc32c(&flatbuffer),
            decoded: flatbuffer.len(),
            bytes: flatbuffer,
            codec: Self::Raw,
        }
    }

    /// Decodes stored bytes to a FlatBuffer of `decoded` bytes, which were compared with the
    /// limits. Takes memory for the FlatBuffer and for a plan of about the same length at most.
    pub(crate) fn decode(self, stored: &Bytes, decoded: u32) -> Result<Bytes, Damage> {
        match self {
            Self::Raw => Ok(stored.clone()),
            #[cfg(feature = "compression")]
            Self::Zstandard => zstandard::decode(stored, decoded as usize).map(Bytes::from),
            #[cfg(not(feature = "compression"))]
            Self::Zstandard => Err(Damage::new(format!(
                "its {decoded} bytes are compressed, which this program cannot read: it was built without the \
                 feature `compression`"
            ))),
        }
    }
}
