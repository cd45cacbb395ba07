//! A bit for each item of each tile, such as a site, which says whether the input has the item. The
//! bits are kept while the input is read in parts.

use std::sync::atomic::{AtomicU64, Ordering};

use futures::stream::StreamExt;

use crate::store::format::ids::TileId;
use crate::store::format::tile::Tile;
use crate::store::pass::{Needs, PassReader};
use crate::store::verify::error::{Fault, VerifyError};

impl PassReader {
    /// Counts the items in each tile.
    pub(super) async fn count_in_tiles(
        &self,
        count: impl Fn(&Tile) -> Result<u32, Fault> + Clone + Send + 'static,
    ) -> Result<Vec<u32>, VerifyError> {
        let mut plan = self.plan(Needs::default())?;
        // Reading takes longer than counting, and the memory that tiles take here is needed for
        // other things by the passes that follow.
        plan.tiles = plan.tiles.min(plan.threads + 1);
        let all = self.tile_ids().into_iter().map(|id| (id, ())).collect();
        let mut counts = vec![0; self.directory().tiles.len()];
        let mut tiles = self.for_some_tiles(all, plan, move |tile, ()| (tile.id(), count(&tile)));
        while let Some(counted) = tiles.next().await {
            let (tile, count) = counted?;
            counts[tile.0 as usize] = count.map_err(|fault| fault.of(tile))?;
        }
        Ok(counts)
    }
}

/// Bits for items of tiles, which any thread may set. No two threads work on the same tile at once.
pub(super) struct TileBits {
    /// For each tile, the number of its first item, and after them the number of all items.
    first: Vec<u64>,
    bits: Vec<AtomicU64>,
}

impl TileBits {
    /// Returns the bytes that `items` bits take. The numbers per tile count with the directory.
    pub(super) fn byte_size(items: u64) -> u64 {
        items.div_ceil(64) * size_of::<AtomicU64>() as u64
    }

    /// Creates the bits for `counts` items in each tile, none of them set.
    pub(super) fn new(counts: impl IntoIterator<Item = u32>) -> Self {
        let mut first = vec![0];
        let mut total = 0;
        for count in counts {
            total += u64::from(count);
            first.push(total);
        }
        let mut bits = Vec::new();
        bits.resize_with(total.div_ceil(64) as usize, || AtomicU64::new(0));
        Self { first, bits }
    }

    /// Sets the bit of an item. It may be set already.
    pub(super) fn set(&self, tile: TileId, item: u32) {
        let number = self.first[tile.0 as usize] + u64::from(item);
        self.bits[(number / 64) as usize].fetch_or(1 << (number % 64), Ordering::Relaxed);
    }

    /// Sets up to `more` unset bits among those of `alike`. Returns the number of bits that it set.
    pub(super) fn set_more(&self, tile: TileId, alike: impl Iterator<Item = u32>, more: usize) -> usize {
        let free = alike.filter(|&item| !self.is_set(tile, item));
        free.take(more).map(|item| self.set(tile, item)).count()
    }

    fn is_set(&self, tile: TileId, item: u32) -> bool {
        let number = self.first[tile.0 as usize] + u64::from(item);
        self.bits[(number / 64) as usize].load(Ordering::Relaxed) >> (number % 64) & 1 == 1
    }

    /// Returns the first item whose bit is not set, if there is one.
    pub(super) fn first_unset(&self) -> Option<(TileId, u32)> {
        let word = |index: usize| self.bits[index].load(Ordering::Relaxed);
        let index = (0..self.bits.len()).find(|&index| word(index) != u64::MAX)?;
        let number = 64 * index as u64 + u64::from(word(index).trailing_ones());
        if number >= *self.first.last()? {
            return None;
        }
        let tile = self.first.partition_point(|&first| first <= number) - 1;
        Some((TileId(tile as u32), (number - self.first[tile]) as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_unset_returns_the_first_item_whose_bit_is_not_set() {
        let tile_bits = TileBits::new([3, 0, 70, 1, 0]);
        assert_eq!(tile_bits.first_unset(), Some((TileId(0), 0)));
        let all = [(0, 3), (2, 70), (3, 1)];
        let all: Vec<_> = all
            .into_iter()
            .flat_map(|(tile, count)| (0..count).map(move |item| (TileId(tile), item)))
            .collect();
        for (index, &(tile, item)) in all.iter().enumerate() {
            assert_eq!(tile_bits.first_unset(), Some((tile, item)), "{index}");
            tile_bits.set(tile, item);
        }
        assert_eq!(tile_bits.first_unset(), None);
        assert_eq!(TileBits::new([]).first_unset(), None);
    }

    #[test]
    fn set_more_sets_only_unset_bits() {
        let tile_bits = TileBits::new([4, 5]);
        let alike = || [1, 2, 4].into_iter();
        let set_more = |more| tile_bits.set_more(TileId(1), alike(), more);
        assert_eq!([2, 0, 3, 1].map(set_more), [2, 0, 1, 0]);
        let set: Vec<u32> = (0..5).filter(|&item| tile_bits.is_set(TileId(1), item)).collect();
        assert_eq!(set, [1, 2, 4]);
        assert_eq!(tile_bits.first_unset(), Some((TileId(0), 0)));
    }
}
