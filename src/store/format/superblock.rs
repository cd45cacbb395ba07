//! The two superblocks at the start of a tile file.
//!
//! Both have the same layout. The valid one with the higher generation is in force.
//! `schema/FORMAT.md` specifies their bytes, and `tests/building/format` checks this file against
//! that page.

use std::fmt;

use crate::store::format::damage::Damage;
use crate::store::format::extent::Extent;
use crate::store::format::limits::{BLOCK, MAX_PAGE};

/// The version of the format that this library writes and reads.
pub const FORMAT_VERSION: u32 = 2;
/// The last version that no release wrote. Its files are not worth a reader: they are built again.
const LAST_UNRELEASED: u32 = 1;

const MAGIC: [u8; 8] = *b"DELTILES";

/// The identity of a file: a hash of the directory with which it was made. Edits do not change it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FileId(pub u128);

impl fmt::Display for FileId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

/// The content of a superblock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Superblock {
    pub(crate) file_id: FileId,
    pub(crate) generation: u64,
    /// Length of the whole file in bytes.
    pub(crate) file_length: u64,
    /// Where the root of the directory is.
    pub(crate) root: Extent,
}

impl Superblock {
    pub(crate) fn encode(&self) -> Vec<u8> {
        let mut block = vec![0; BLOCK as usize];
        block[0..8].copy_from_slice(&MAGIC);
        block[8..12].copy_from_slice(&FORMAT_VERSION.to_le_bytes());
        // 12..16: feature flags, none so far.
        block[16..32].copy_from_slice(&self.file_id.0.to_le_bytes());
        block[32..40].copy_from_slice(&self.generation.to_le_bytes());
        block[40..48].copy_from_slice(&self.file_length.to_le_bytes());
        block[48..56].copy_from_slice(&self.root.offset.to_le_bytes());
        block[56..60].copy_from_slice(&self.root.length.to_le_bytes());
        block[60..64].copy_from_slice(&self.root.crc.to_le_bytes());
        let crc = crc32c::crc32c(&block[..4092]);
        block[4092..].copy_from_slice(&crc.to_le_bytes());
        block
    }

    /// Returns the checksum that it is stored with.
    pub(crate) fn crc(&self) -> u32 {
        let block = self.encode();
        u32::from_le_bytes(block[4092..].try_into().expect("four bytes"))
    }

    /// Decodes one superblock. The error says what is wrong with it.
    fn decode(block: &[u8]) -> Result<Self, Damage> {
        let u32_at = |at: usize| u32::from_le_bytes(block[at..at + 4].try_into().expect("four bytes"));
        let u64_at = |at: usize| u64::from_le_bytes(block[at..at + 8].try_into().expect("eight bytes"));
        if block.len() < BLOCK as usize || block[0..8] != MAGIC {
            return Err(Damage::new("it is no tile file: the superblock's magic is missing"));
        }
        let version = u32_at(8);
        if version != FORMAT_VERSION {
            let why = match version <= LAST_UNRELEASED {
                true => "; it was written by a pre-release; build it again",
                false => "",
            };
            return Err(Damage::new(format!(
                "it has format version {version}, this program reads version {FORMAT_VERSION}{why}"
            )));
        }
        let (expected, found) = (u32_at(4092), crc32c::crc32c(&block[..4092]));
        if expected != found {
            return Err(Damage::new(format!(
                "the superblock's checksum is {found:08x}, not {expected:08x}"
            )));
        }
        if u32_at(12) != 0 {
            return Err(Damage::new(format!(
                "it needs features {:#x}, which this program does not know",
                u32_at(12)
            )));
        }
        let this = Self {
            file_id: FileId(u128::from_le_bytes(block[16..32].try_into().expect("sixteen bytes"))),
            generation: u64_at(32),
            file_length: u64_at(40),
            root: Extent::raw(u64_at(48), u32_at(56), u32_at(60)),
        };
        this.root.check("the directory's root", this.file_length, MAX_PAGE)?;
        Ok(this)
    }

    /// Chooses the superblock in force from the first 8192 bytes of a file.
    pub(crate) fn choose(head: &[u8]) -> Result<InForce, Damage> {
        let (a, b) = head.split_at(head.len().min(BLOCK as usize));
        let (superblock, is_second) = match (Self::decode(a), Self::decode(b)) {
            (Ok(a), Ok(b)) if b.generation > a.generation => (b, true),
            (Ok(a), _) => (a, false),
            (Err(_), Ok(b)) => (b, true),
            (Err(reason), Err(_)) => return Err(reason),
        };
        Ok(InForce { superblock, is_second })
    }
}

/// The superblock in force, and its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct InForce {
    pub(crate) superblock: Superblock,
    is_second: bool,
}

impl InForce {
    /// Returns the offset of the other superblock, which the next generation overwrites.
    pub(crate) fn other_offset(&self) -> u64 {
        if self.is_second { 0 } else { BLOCK }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(generation: u64) -> Superblock {
        Superblock {
            file_id: FileId(7),
            generation,
            file_length: 20_000,
            root: Extent::raw(8192, 304, 9),
        }
    }

    #[test]
    fn the_higher_valid_generation_wins() {
        let head = |a: &Superblock, b: &Superblock| [a.encode(), b.encode()].concat();
        let chosen = |head: &[u8]| Superblock::choose(head).map(|found| (found.superblock, found.other_offset()));
        assert_eq!(chosen(&head(&block(1), &block(2))), Ok((block(2), 0)));
        assert_eq!(chosen(&head(&block(3), &block(2))), Ok((block(3), 4096)));
        assert_eq!(chosen(&head(&block(2), &block(2))), Ok((block(2), 4096)));
        let mut torn = head(&block(1), &block(2));
        torn[5000] ^= 1;
        assert_eq!(chosen(&torn), Ok((block(1), 4096)));
        torn[50] ^= 1;
        assert!(Superblock::choose(&torn).is_err());
    }

    #[test]
    fn a_file_of_a_pre_release_is_refused_with_advice() {
        let of_version = |version: u32| {
            let mut old = block(1).encode();
            old[8..12].copy_from_slice(&version.to_le_bytes());
            Superblock::decode(&old).unwrap_err().to_string()
        };
        for version in [0, 1] {
            let error = of_version(version);
            assert!(error.contains("written by a pre-release; build it again"), "{error}");
        }
        let error = of_version(FORMAT_VERSION + 1);
        assert!(!error.contains("pre-release"), "{error}");
    }

    #[test]
    fn a_flipped_bit_or_a_shortened_head_is_detected() {
        let good = block(1).encode();
        for bit in 0..8 * good.len() {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            assert!(Superblock::decode(&bad).is_err(), "bit {bit}");
        }
        for length in 0..good.len() {
            assert!(Superblock::choose(&good[..length]).is_err(), "length {length}");
        }
    }
}
