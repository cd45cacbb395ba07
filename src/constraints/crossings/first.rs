//! The crossings that an error reports: the first in the order of the input's lines.

use std::cmp::Ordering;
use std::fmt;

use crate::geometry::Point;
use crate::store::EdgeSource;

/// Number of crossings that are kept.
pub(crate) const KEPT: usize = 10;

/// Two lines of the input that cross, and their crossing point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The lines, the smaller number first. They are equal if a line crosses itself.
    pub lines: [EdgeSource; 2],
    /// The crossing point, rounded.
    pub point: Point,
}

impl Crossing {
    /// Makes the crossing of two lines, given in any order and any direction.
    pub(crate) fn new(lines: [EdgeSource; 2], point: Point) -> Self {
        let [one, other] = lines.map(|line| EdgeSource::new(line.kind(), line.number()));
        Self {
            lines: [one.min(other), one.max(other)],
            point,
        }
    }

    fn order(&self, other: &Self) -> Ordering {
        let lines = self.lines.cmp(&other.lines);
        lines.then_with(|| self.point.lex_cmp(other.point))
    }
}

impl fmt::Display for Crossing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [one, other] = self.lines.map(|line| format!("{} {}", line.kind(), line.number()));
        write!(f, "{one} and {other} at ({}, {})", self.point.x, self.point.y)
    }
}

/// The first ten crossings by line numbers and point, and the number of all crossings. Neither
/// depends on the order in which crossings arrive.
///
/// Crossings of the same lines at the same point, as of segments that occur twice, are kept once.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct FirstCrossings {
    first: Vec<Crossing>,
    count: u64,
}

impl FirstCrossings {
    /// Adds a crossing.
    pub(crate) fn push(&mut self, crossing: Crossing) {
        self.count += 1;
        self.keep(crossing);
    }

    /// Adds all crossings of `other`.
    pub(crate) fn merge(&mut self, other: &Self) {
        self.count += other.count;
        for crossing in &other.first {
            self.keep(*crossing);
        }
    }

    /// Returns the first crossings, in order.
    pub(crate) fn first(&self) -> &[Crossing] {
        &self.first
    }

    /// Returns the number of pairs of segments that cross.
    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    fn keep(&mut self, crossing: Crossing) {
        if let Err(index) = self.first.binary_search_by(|kept| kept.order(&crossing))
            && index < KEPT
        {
            self.first.truncate(KEPT - 1);
            self.first.insert(index, crossing);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;
    use crate::store::LineKind;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

        #[test]
        fn the_ten_smallest_crossings_are_kept_whatever_their_order(
            pairs in prop::collection::vec((0u64..8, 0u64..8, 0u8..3), 0..60),
            at in 0usize..60,
        ) {
            let kind = |number: u64| [LineKind::BreakLine, LineKind::Wall, LineKind::Obstacle][number as usize / 3];
            let line = |number: u64| EdgeSource::new(kind(number), number);
            let crossing = |&(a, b, x): &(u64, u64, u8)| Crossing::new([line(a), line(b)], Point::new(x.into(), 0.0));
            let mut whole = FirstCrossings::default();
            pairs.iter().for_each(|pair| whole.push(crossing(pair)));

            let expected: BTreeSet<_> = pairs.iter().map(|&(a, b, x)| (a.min(b), a.max(b), x)).collect();
            let expected: Vec<_> = expected.iter().take(10).map(crossing).collect();
            prop_assert_eq!(whole.first(), &*expected);
            prop_assert_eq!(whole.count(), pairs.len() as u64);

            let (one, other) = pairs.split_at(at.min(pairs.len()));
            let mut parts = [FirstCrossings::default(), FirstCrossings::default()];
            // The same pair with its lines swapped and one of them reversed.
            let reversed = |&(a, b, x): &(u64, u64, u8)| {
                Crossing::new([line(b).reversed(), line(a)], Point::new(x.into(), 0.0))
            };
            one.iter().rev().for_each(|pair| parts[0].push(reversed(pair)));
            other.iter().for_each(|pair| parts[1].push(crossing(pair)));
            let [one, mut other] = parts;
            other.merge(&one);
            prop_assert_eq!(other, whole);
        }
    }
}
