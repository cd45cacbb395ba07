//! Changes bytes of a file and makes its checksums right again.

use std::ops::Range;

use crc32c::crc32c;
use ruzstd::decoding::FrameDecoder;

use super::support::flat::{Table, u16_at, u32_at, u64_at};

/// Slots of fields that `schema/FORMAT.md` names; the tests in `format` compare that page with the
/// code.
const PAGE_LISTS: usize = 14;
const LISTS: [usize; 6] = [16, 17, 27, 30, 31, 38];
const PAGES: usize = 1;
const ENTRIES: usize = 1;
const TABLES: usize = 3;
const TABLE_LENGTHS: usize = 4;
const TABLES_APART: usize = 5;
/// Bytes of structs.
const PAGE_LIST_REF: usize = 32;
const PAGE_REF: usize = 24;
const ENTRY: usize = 96;
const PART_EXTENT: usize = 16;

/// A part of a file: its offset and length, and the offset of its checksum.
#[derive(Clone, Copy, Debug)]
pub struct FilePart {
    pub at: usize,
    pub length: usize,
    crc: usize,
}

/// Returns, for each page that has a vector in this slot, the bytes of its elements, which have
/// `size` bytes each.
fn vectors(bytes: &[u8], pages: &[FilePart], slot: usize, size: usize) -> Vec<Range<usize>> {
    let found = pages.iter().filter_map(|page| {
        let (first, count) = Table::root(&bytes[page.at..]).vector(slot)?;
        Some(page.at + first..page.at + first + count * size)
    });
    found.collect()
}

/// A file whose parts are known.
#[derive(Clone)]
pub struct Patient {
    pub bytes: Vec<u8>,
    pub root: FilePart,
    /// The sources, the reference system, and what else is long.
    pub lists: Vec<FilePart>,
    pub page_lists: Vec<FilePart>,
    pub pages: Vec<FilePart>,
    /// The offset of each tile's entry.
    pub entries: Vec<usize>,
    pub cores: Vec<FilePart>,
    pub borders: Vec<FilePart>,
    /// The component tables that lie apart.
    pub tables: Vec<FilePart>,
    /// For each page that has them, the bytes of the component tables in it, of their lengths, and
    /// of the extents of those that lie apart.
    pub tables_in_pages: Vec<Range<usize>>,
    pub table_lengths: Vec<Range<usize>>,
    pub tables_apart: Vec<Range<usize>>,
}

impl Patient {
    pub fn new(bytes: Vec<u8>) -> Self {
        let start = u64_at(&bytes, 48) as usize;
        let root = FilePart {
            at: start,
            length: u32_at(&bytes, 56) as usize,
            crc: 60,
        };
        let table = Table::root(&bytes[start..]);
        let extent = |at: usize| FilePart {
            at: u64_at(&bytes, at) as usize,
            length: u32_at(&bytes, at + 8) as usize,
            crc: at + 12,
        };
        let lists = LISTS.iter().filter_map(|&slot| table.field(slot));
        let lists: Vec<FilePart> = lists.map(|at| extent(start + at)).collect();
        let (first, count) = table.vector(PAGE_LISTS).unwrap();
        let page_lists: Vec<FilePart> = (0..count).map(|i| extent(start + first + PAGE_LIST_REF * i)).collect();
        let pages_of = |list: &FilePart| {
            let (first, count) = Table::root(&bytes[list.at..]).vector(PAGES).unwrap();
            let at = list.at + first;
            (0..count).map(move |i| at + PAGE_REF * i)
        };
        let pages: Vec<FilePart> = page_lists
            .iter()
            .flat_map(pages_of)
            .map(|page| FilePart {
                at: 4096 * u32_at(&bytes, page) as usize,
                length: u16_at(&bytes, page + 12).into(),
                crc: page + 4,
            })
            .collect();
        let entries = vectors(&bytes, &pages, ENTRIES, ENTRY);
        let entries: Vec<usize> = entries.into_iter().flat_map(|all| all.step_by(ENTRY)).collect();
        let part = |entry: &usize, which: usize| FilePart {
            at: u64_at(&bytes, entry + 8 * which) as usize,
            length: u32_at(&bytes, entry + 16 + 4 * which) as usize,
            crc: entry + 32 + 4 * which,
        };
        let cores = entries.iter().map(|entry| part(entry, 0)).collect();
        let borders = entries.iter().map(|entry| part(entry, 1)).collect();
        let in_pages = |slot, size| vectors(&bytes, &pages, slot, size);
        let tables_apart = in_pages(TABLES_APART, PART_EXTENT);
        let tables = tables_apart.iter().flat_map(|all| all.clone().step_by(PART_EXTENT));
        Self {
            tables: tables.map(extent).collect(),
            tables_in_pages: in_pages(TABLES, 1),
            table_lengths: in_pages(TABLE_LENGTHS, 1),
            tables_apart,
            bytes,
            root,
            lists,
            page_lists,
            pages,
            entries,
            cores,
            borders,
        }
    }

    /// Returns the parts of tiles.
    pub fn of_tiles(&self) -> impl Iterator<Item = &FilePart> {
        self.cores.iter().chain(&self.borders).chain(&self.tables)
    }

    /// Returns the parts of the directory.
    pub fn directory(&self) -> impl Iterator<Item = &FilePart> {
        let lists = self.lists.iter().chain(&self.page_lists);
        lists.chain(&self.pages).chain([&self.root])
    }

    /// Replaces each compressed part by one whose bytes can be changed: the Zstandard frames, which
    /// hardly survive a change, give way to one frame that stores the plan as it is.
    pub fn unpacked(mut self) -> Self {
        for (&entry, which) in self.entries.iter().flat_map(|entry| [(entry, 0), (entry, 1)]) {
            let parts = [&mut self.cores, &mut self.borders];
            let part = parts.into_iter().nth(which).unwrap().iter_mut();
            let part = part
                .min_by_key(|part| part.crc.abs_diff(entry + 32 + 4 * which))
                .unwrap();
            let stored = &self.bytes[part.at..part.at + part.length];
            let mut plan = vec![0; u32_at(stored, 0) as usize];
            FrameDecoder::new().decode_all(&stored[4..], &mut plan).unwrap();
            let mut unpacked = (plan.len() as u32).to_le_bytes().to_vec();
            // A single segment, whose length has four bytes.
            unpacked.extend([0x28, 0xb5, 0x2f, 0xfd, 0xa0]);
            unpacked.extend((plan.len() as u32).to_le_bytes());
            let blocks = plan.chunks(1 << 17);
            for (block, number) in blocks.clone().zip(1..) {
                let is_last = u32::from(number == blocks.len());
                unpacked.extend(&((block.len() as u32) << 3 | is_last).to_le_bytes()[..3]);
                unpacked.extend(block);
            }
            (part.at, part.length) = (self.bytes.len(), unpacked.len());
            self.bytes.extend(unpacked);
            let (at, length) = (part.at as u64, part.length as u32);
            self.bytes[entry + 8 * which..][..8].copy_from_slice(&at.to_le_bytes());
            self.bytes[entry + 16 + 4 * which..][..4].copy_from_slice(&length.to_le_bytes());
        }
        let length = self.bytes.len() as u64;
        self.put(40, &length.to_le_bytes());
        self.sew();
        self
    }

    pub fn put(&mut self, at: usize, bytes: &[u8]) {
        self.bytes[at..at + bytes.len()].copy_from_slice(bytes);
    }

    /// Makes all checksums right, from the tiles up to the superblocks.
    pub fn sew(&mut self) {
        let mut parts = self.cores.clone();
        parts.extend(&self.borders);
        parts.extend(&self.tables);
        parts.extend(&self.pages);
        parts.extend(&self.page_lists);
        parts.extend(&self.lists);
        parts.push(self.root);
        for part in parts {
            let crc = crc32c(&self.bytes[part.at..part.at + part.length]);
            self.put(part.crc, &crc.to_le_bytes());
        }
        self.sew_superblocks();
    }

    /// Makes the superblocks right; the second becomes a copy of the first.
    pub fn sew_superblocks(&mut self) {
        let crc = crc32c(&self.bytes[..4092]);
        self.put(4092, &crc.to_le_bytes());
        self.bytes.copy_within(..4096, 4096);
    }
}
