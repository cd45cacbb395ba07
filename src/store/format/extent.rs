//! A range of bytes in the file.

use std::ops::Range;

use crate::io::memory_of;
use crate::store::format::codec::Codec;
use crate::store::format::damage::Damage;
use crate::store::format::limits::FIRST_EXTENT;

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
