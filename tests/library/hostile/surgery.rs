//! Changes bytes of a file and makes its checksums right again.

use crc32c::crc32c;
use xxhash_rust::xxh3::xxh3_128;

use super::support::flat::{Table, u32_at, u64_at};

/// Slots of fields that `schema/FORMAT.md` names; the tests in `format` compare that page with the
/// code.
const PAGES: usize = 13;
const ENTRIES: usize = 1;

/// A part of a file: its offset and length, and the offset of its checksum.
#[derive(Clone, Copy, Debug)]
pub struct FilePart {
    pub at: usize,
    pub length: usize,
    crc: usize,
}

/// A file whose parts are known.
#[derive(Clone)]
pub struct Patient {
    pub bytes: Vec<u8>,
    pub root: FilePart,
    pub pages: Vec<FilePart>,
    /// The offset of each tile's entry.
    pub entries: Vec<usize>,
    pub cores: Vec<FilePart>,
    pub borders: Vec<FilePart>,
}

impl Patient {
    pub fn new(bytes: Vec<u8>) -> Self {
        let start = u64_at(&bytes, 48) as usize;
        let root = FilePart {
            at: start,
            length: u32_at(&bytes, 64) as usize,
            crc: 68,
        };
        let (first, count) = Table::root(&bytes[start..]).vector(PAGES).unwrap();
        let pages: Vec<FilePart> = (0..count)
            .map(|i| start + first + 16 * i)
            .map(|extent| FilePart {
                at: start + u64_at(&bytes, extent) as usize,
                length: u32_at(&bytes, extent + 8) as usize,
                crc: extent + 12,
            })
            .collect();
        let entries: Vec<usize> = pages
            .iter()
            .flat_map(|page| {
                let (first, count) = Table::root(&bytes[page.at..]).vector(ENTRIES).unwrap();
                (0..count).map(move |i| page.at + first + 88 * i)
            })
            .collect();
        let part = |entry: &usize, which: usize| FilePart {
            at: u64_at(&bytes, entry + 8 * which) as usize,
            length: u32_at(&bytes, entry + 16 + 4 * which) as usize,
            crc: entry + 24 + 4 * which,
        };
        let cores = entries.iter().map(|entry| part(entry, 0)).collect();
        let borders = entries.iter().map(|entry| part(entry, 1)).collect();
        Self {
            bytes,
            root,
            pages,
            entries,
            cores,
            borders,
        }
    }

    pub fn put(&mut self, at: usize, bytes: &[u8]) {
        self.bytes[at..at + bytes.len()].copy_from_slice(bytes);
    }

    /// Makes all checksums right, from the tiles up to the superblocks, and the file's id.
    pub fn sew(&mut self) {
        let mut parts = self.cores.clone();
        parts.extend(&self.borders);
        parts.extend(&self.pages);
        parts.push(self.root);
        for part in parts {
            let crc = crc32c(&self.bytes[part.at..part.at + part.length]);
            self.put(part.crc, &crc.to_le_bytes());
        }
        self.sew_superblocks();
    }

    /// Makes the superblocks right; the second becomes a copy of the first.
    pub fn sew_superblocks(&mut self) {
        let start = u64_at(&self.bytes, 48) as usize;
        let length = u64_at(&self.bytes, 56) as usize;
        if let Some(directory) = start.checked_add(length).and_then(|end| self.bytes.get(start..end)) {
            let id = xxh3_128(directory);
            self.put(16, &id.to_le_bytes());
        }
        let crc = crc32c(&self.bytes[..4092]);
        self.put(4092, &crc.to_le_bytes());
        self.bytes.copy_within(..4096, 4096);
    }
}
