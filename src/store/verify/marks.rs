//! What of a file has been found in its input: a bit for each thing of each tile, while the input passes by in parts.

use std::sync::atomic::{AtomicU64, Ordering};

use futures::stream::StreamExt;

use crate::store::format::ids::TileId;
use crate::store::format::tile::Tile;
use crate::store::pass::Needs;
use crate::store::reader::TileReader;
use crate::store::verify::error::{Fault, VerifyError};

impl TileReader {
    /// How many things to mark there are in each tile.
    pub(super) async fn count_in_tiles(
        &self,
        count: impl Fn(&Tile) -> Result<u32, Fault> + Clone + Send + 'static,
    ) -> Result<Vec<u32>, VerifyError> {
        let mut plan = self.plan(Needs::default())?;
        // Reading takes longer than counting, and what tiles took the passes to come need for other things.
        plan.tiles = plan.tiles.min(plan.threads + 1);
        let all = self.tile_ids().into_iter().map(|id| (id, ())).collect();
        let mut counts = Vec::with_capacity(self.directory().tiles.len());
        let mut tiles = self.for_some_tiles(all, plan, move |tile, ()| (tile.id(), count(&tile)));
        while let Some(counted) = tiles.next().await {
            let (tile, count) = counted?;
            counts.push(count.map_err(|fault| fault.of(tile))?);
        }
        Ok(counts)
    }
}

/// Bits for things that tiles have, set by any thread. No two threads work on the same tile at once.
pub(super) struct Marks {
    /// For each tile the number of its first thing, and behind them how many there are.
    first: Vec<u64>,
    bits: Vec<AtomicU64>,
}

impl Marks {
    /// Bytes for so many things; those for each tile count with the directory.
    pub(super) fn byte_size(things: u64) -> u64 {
        things.div_ceil(64) * size_of::<AtomicU64>() as u64
    }

    /// No bit is set, of so many things in each tile.
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

    /// Marks one thing, again or for the first time.
    pub(super) fn set(&self, tile: TileId, thing: u32) {
        let number = self.first[tile.0 as usize] + u64::from(thing);
        self.bits[(number / 64) as usize].fetch_or(1 << (number % 64), Ordering::Relaxed);
    }

    /// Marks so many more of some things that are all alike, or as many as are left, which it returns.
    pub(super) fn set_more(&self, tile: TileId, alike: impl Iterator<Item = u32>, more: usize) -> usize {
        let free = alike.filter(|&thing| !self.is_set(tile, thing));
        free.take(more).map(|thing| self.set(tile, thing)).count()
    }

    fn is_set(&self, tile: TileId, thing: u32) -> bool {
        let number = self.first[tile.0 as usize] + u64::from(thing);
        self.bits[(number / 64) as usize].load(Ordering::Relaxed) >> (number % 64) & 1 == 1
    }

    /// The first thing that is not marked, if there is one.
    pub(super) fn first_unset(&self) -> Option<(TileId, u32)> {
        let word = |place: usize| self.bits[place].load(Ordering::Relaxed);
        let place = (0..self.bits.len()).find(|&place| word(place) != u64::MAX)?;
        let number = 64 * place as u64 + u64::from(word(place).trailing_ones());
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
    fn the_first_that_is_not_marked() {
        let marks = Marks::new([3, 0, 70, 1, 0]);
        assert_eq!(marks.first_unset(), Some((TileId(0), 0)));
        let all = [(0, 3), (2, 70), (3, 1)];
        let all: Vec<_> = all
            .into_iter()
            .flat_map(|(tile, count)| (0..count).map(move |thing| (TileId(tile), thing)))
            .collect();
        for (place, &(tile, thing)) in all.iter().enumerate() {
            assert_eq!(marks.first_unset(), Some((tile, thing)), "{place}");
            marks.set(tile, thing);
        }
        assert_eq!(marks.first_unset(), None);
        assert_eq!(Marks::new([]).first_unset(), None);
    }

    #[test]
    fn of_things_alike_each_is_marked_once() {
        let marks = Marks::new([4, 5]);
        let alike = || [1, 2, 4].into_iter();
        let set_more = |more| marks.set_more(TileId(1), alike(), more);
        assert_eq!([2, 0, 3, 1].map(set_more), [2, 0, 1, 0]);
        let set: Vec<u32> = (0..5).filter(|&thing| marks.is_set(TileId(1), thing)).collect();
        assert_eq!(set, [1, 2, 4]);
        assert_eq!(marks.first_unset(), Some((TileId(0), 0)));
    }
}
