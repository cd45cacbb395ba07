//! Entries of equal length, indexed by tile.

use std::ops::Range;

/// Entries of equal length, indexed by tile.
#[derive(Debug)]
pub(super) struct ByTile {
    bytes: Vec<u8>,
    entry: usize,
    /// Numbers of the entries, tile by tile.
    numbers: Vec<u32>,
    /// For each tile the start of its range in `numbers`, and the end of the last range.
    starts: Vec<usize>,
}

impl ByTile {
    /// Indexes entries by the tiles that `tiles_of` reads from each, some of which may be in other
    /// groups.
    pub(super) fn new<const N: usize>(
        bytes: Vec<u8>,
        entry: usize,
        tiles: &Range<u32>,
        tiles_of: impl Fn(&[u8]) -> [u32; N],
    ) -> Self {
        let mut starts = vec![0; tiles.len() + 1];
        let in_group = |bytes: &[u8]| {
            let entry_tiles = tiles_of(bytes);
            // Each tile once.
            let distinct_tiles = entry_tiles
                .into_iter()
                .enumerate()
                .filter(move |&(at, tile)| !entry_tiles[..at].contains(&tile));
            let in_group = distinct_tiles.filter(|(_, tile)| tiles.contains(tile));
            in_group.map(|(_, tile)| (tile - tiles.start) as usize)
        };
        for bytes in bytes.chunks_exact(entry) {
            in_group(bytes).for_each(|index| starts[index + 1] += 1);
        }
        for index in 1..starts.len() {
            starts[index] += starts[index - 1];
        }
        let mut numbers = vec![0; starts[tiles.len()]];
        let mut next = starts.clone();
        for (bytes, number) in bytes.chunks_exact(entry).zip(0..) {
            for index in in_group(bytes) {
                numbers[next[index]] = number;
                next[index] += 1;
            }
        }
        Self {
            bytes,
            entry,
            numbers,
            starts,
        }
    }

    pub(super) fn of(&self, index: u32) -> impl Iterator<Item = &[u8]> {
        let numbers = &self.numbers[self.starts[index as usize]..self.starts[index as usize + 1]];
        numbers.iter().map(|&number| {
            let at = number as usize * self.entry;
            &self.bytes[at..at + self.entry]
        })
    }

    /// Returns the size in bytes.
    pub(super) fn byte_size(&self) -> usize {
        self.bytes.len() + 4 * self.numbers.len() + 8 * self.starts.len()
    }
}
