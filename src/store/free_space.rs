//! Free ranges of bytes in a file.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Free ranges, none of which touch each other.
#[derive(Debug, Default)]
pub(crate) struct FreeSpace {
    /// The end of each range, by its start.
    ends: BTreeMap<u64, u64>,
    /// The length and the start of each range.
    lengths: BTreeSet<(u64, u64)>,
}

impl FreeSpace {
    /// Returns what is free in a range of which some parts are used.
    pub(crate) fn around(mut used: Vec<Range<u64>>, within: Range<u64>) -> Self {
        used.sort_unstable_by_key(|range| range.start);
        let mut this = Self::default();
        let mut end = within.start;
        for range in used {
            if end < range.start {
                this.insert(end..range.start);
            }
            end = end.max(range.end);
        }
        if end < within.end {
            this.insert(end..within.end);
        }
        this
    }

    /// Takes `length` bytes from the shortest range that has them at a multiple of `alignment`.
    /// Returns where they start.
    pub(crate) fn take(&mut self, length: u64, alignment: u64) -> Option<u64> {
        let long_enough = self.lengths.range((length.max(1), 0)..);
        let aligned = long_enough.map(|&(room, start)| (start, start + room, start.next_multiple_of(alignment)));
        let (start, end, offset) = aligned.into_iter().find(|(_, end, offset)| offset + length <= *end)?;
        self.remove(start..end);
        self.insert(start..offset);
        self.insert(offset + length..end);
        Some(offset)
    }

    /// Gives a range back.
    pub(crate) fn give(&mut self, range: Range<u64>) {
        let before = self.ends.range(..=range.start).next_back();
        let before = before
            .map(|(&start, &end)| start..end)
            .filter(|before| before.end >= range.start);
        let after = self.ends.range(range.start..).next().map(|(&start, &end)| start..end);
        let after = after.filter(|after| after.start <= range.end);
        let mut whole = range;
        for other in [before, after].into_iter().flatten() {
            whole = whole.start.min(other.start)..whole.end.max(other.end);
            self.remove(other);
        }
        self.insert(whole);
    }

    fn insert(&mut self, range: Range<u64>) {
        if !range.is_empty() {
            self.ends.insert(range.start, range.end);
            self.lengths.insert((range.end - range.start, range.start));
        }
    }

    fn remove(&mut self, range: Range<u64>) {
        self.ends.remove(&range.start);
        self.lengths.remove(&(range.end - range.start, range.start));
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_shortest_range_that_suffices_is_taken() {
        let mut free = FreeSpace::around(vec![100..200, 5200..8000, 150..300, 9000..9100], 0..20_000);
        assert_eq!(free.take(90, 1), Some(0));
        assert_eq!(free.take(10, 1), Some(90));
        assert_eq!(free.take(1000, 4096), Some(4096));
        assert_eq!(free.take(1000, 4096), Some(12_288));
        assert_eq!(free.take(20_000, 1), None);
        free.give(4096..5096);
        assert_eq!(free.take(4700, 1), Some(300));
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

        /// No byte is taken twice, and what is given back can be taken again.
        #[test]
        fn what_is_taken_was_free(calls in prop::collection::vec((1u64..3000, 0u32..13, 0usize..8), 1..60)) {
            let used = vec![500..700, 2000..2001, 10_000..14_000];
            let mut free = FreeSpace::around(used.clone(), 100..20_000);
            let mut taken: Vec<Range<u64>> = Vec::new();
            for (length, alignment, gone) in calls {
                if let Some(offset) = free.take(length, 1 << alignment) {
                    let new = offset..offset + length;
                    prop_assert_eq!(offset % (1 << alignment), 0);
                    prop_assert!(offset >= 100 && new.end <= 20_000);
                    for other in used.iter().chain(&taken) {
                        prop_assert!(new.end <= other.start || other.end <= new.start, "{new:?} {other:?}");
                    }
                    taken.push(new);
                }
                if gone < taken.len() {
                    free.give(taken.swap_remove(gone));
                }
            }
            taken.into_iter().for_each(|range| free.give(range));
            prop_assert_eq!(free.take(6000, 1), Some(14_000));
            prop_assert_eq!(free.take(8000, 1), None);
            prop_assert_eq!(free.take(7999, 1), Some(2001));
        }
    }
}
