//! Whether a tile may have a point at a position, without the tile.
//!
//! A small transaction must know what is at its positions. Mostly nothing is, and reading a tile takes
//! many times as long as writing the transaction to the log. So each tile that is read leaves a Bloom
//! filter, in which all bits of a position are in one word (Putze, Sanders and Singler, "Cache-, hash-
//! and space-efficient Bloom filters", 2007).

use std::hash::BuildHasher;

use foldhash::quality::FixedState;
use lru::LruCache;

use crate::geometry::Point;
use crate::store::{Tile, TileId};

/// Bloom filters of tiles, in a limited amount of memory.
pub(super) struct PositionFilters {
    filters: LruCache<TileId, Filter>,
    bytes: u64,
    limit: u64,
}

impl PositionFilters {
    /// Creates filters for no tile yet, which will take at most `limit` bytes.
    pub(super) fn new(limit: u64) -> Self {
        Self {
            filters: LruCache::unbounded(),
            bytes: 0,
            limit,
        }
    }

    /// Returns whether a tile may have a vertex at any of these positions. It may if its filter is not
    /// there.
    pub(super) fn may_have(&mut self, tile: TileId, mut positions: impl Iterator<Item = Point>) -> bool {
        let filter = self.filters.get(&tile);
        filter.is_none_or(|filter| positions.any(|point| filter.may_have(point)))
    }

    /// Remembers the positions of the vertices of a tile, once. The filters that were not used for the
    /// longest time make room.
    pub(super) fn remember(&mut self, tile: &Tile) {
        if self.filters.contains(&tile.id()) {
            return;
        }
        let filter = Filter::of(tile.points(), tile.vertex_count());
        self.bytes += filter.bytes();
        self.filters.put(tile.id(), filter);
        while self.bytes > self.limit
            && let Some((_, oldest)) = self.filters.pop_lru()
        {
            self.bytes -= oldest.bytes();
        }
    }
}

/// A set of positions that may have others besides.
struct Filter(Box<[u64]>);

impl Filter {
    /// With 16 bits for each position, of which 5 are set, fewer than one position in a hundred is taken
    /// for one of the set.
    const POSITIONS_PER_WORD: u32 = 4;
    const BITS: u32 = 5;

    fn of(positions: impl Iterator<Item = Point>, count: u32) -> Self {
        let words = count.div_ceil(Self::POSITIONS_PER_WORD).max(1);
        let mut filter = Self(vec![0; words as usize].into());
        for position in positions {
            let (word, bits) = filter.place(position);
            filter.0[word] |= bits;
        }
        filter
    }

    fn may_have(&self, position: Point) -> bool {
        let (word, bits) = self.place(position);
        self.0[word] & bits == bits
    }

    /// Returns the number of the word of a position, and its bits there.
    fn place(&self, position: Point) -> (usize, u64) {
        let hash = FixedState::default().hash_one(position.bits());
        // The bits come from the lower half of the hash, the word from its upper half.
        let bits = (0..Self::BITS).map(|place| 1 << (hash >> (6 * place) & 63));
        let word = (u128::from(hash) * self.0.len() as u128) >> 64;
        (word as usize, bits.fold(0, |all, bit: u64| all | bit))
    }

    fn bytes(&self) -> u64 {
        size_of_val(&*self.0) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(place: u32) -> Point {
        Point::new(f64::from(place), f64::from(place % 100))
    }

    #[test]
    fn a_filter_has_its_positions_and_few_others() {
        let filter = Filter::of((0..10_000).map(at), 10_000);
        assert!((0..10_000).all(|place| filter.may_have(at(place))));
        let others = (10_000..110_000).filter(|&place| filter.may_have(at(place))).count();
        assert!(others < 1000, "{others}");
        assert_eq!(filter.bytes(), 20_000);
        assert!(!Filter::of(std::iter::empty(), 0).may_have(at(1)));
    }
}
