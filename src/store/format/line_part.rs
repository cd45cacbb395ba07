//! The part of a line along an edge: the source, and whether a segment of the line begins or ends
//! with the edge.

use std::fmt;

use crate::store::format::edge_source::{EdgeSource, LineKind};

/// The part of a line that runs along an edge, as seen in one direction of the edge: the
/// [source](EdgeSource) of the edge, and which ends of the edge are ends of a segment of the line.
///
/// A segment passes the vertices between its ends, and is cut there. So the first of its edges
/// begins a segment, the last one ends it, and those between do neither. If several segments of the
/// line run along an edge, the edge begins a segment if it begins any of them, and likewise for
/// ends.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LinePart(u64);

/// The bits below those of the source.
const BEGINS: u64 = 1;
const ENDS: u64 = 2;
const ENDS_BITS: u32 = 2;

impl LinePart {
    /// Creates the part of a line whose segment is the edge itself: it begins and ends there.
    #[must_use]
    pub const fn whole(source: EdgeSource) -> Self {
        Self(source.to_bits() << ENDS_BITS | BEGINS | ENDS)
    }

    /// Returns the source of the edge.
    #[must_use]
    pub const fn source(self) -> EdgeSource {
        EdgeSource::from_bits(self.0 >> ENDS_BITS)
    }

    /// Returns whether a segment of the line begins where the edge starts. The direction in which
    /// the input gives the segment does not matter.
    #[must_use]
    pub const fn begins(self) -> bool {
        self.0 & BEGINS != 0
    }

    /// Returns whether a segment of the line ends where the edge ends.
    #[must_use]
    pub const fn ends(self) -> bool {
        self.0 & ENDS != 0
    }

    /// Returns the line's number.
    #[must_use]
    pub const fn number(self) -> u64 {
        self.source().number()
    }

    /// Returns the line's kind.
    #[must_use]
    pub const fn kind(self) -> LineKind {
        self.source().kind()
    }

    /// Returns whether paths must not cross the line.
    #[must_use]
    pub const fn is_wall(self) -> bool {
        self.source().is_wall()
    }

    /// Returns by how many more obstacles the left side of the edge is covered than the right side:
    /// 1, 0 or −1.
    #[must_use]
    pub const fn depth_change(self) -> i32 {
        self.source().depth_change()
    }

    /// Returns the same part, as seen in the other direction of the edge.
    #[must_use]
    pub const fn reversed(self) -> Self {
        Self::of(self.source().reversed(), self.ends(), self.begins())
    }

    /// Returns the part of a line that begins and ends segments as the arguments say.
    #[must_use]
    pub const fn of(source: EdgeSource, begins: bool, ends: bool) -> Self {
        let (begins, ends) = (if begins { BEGINS } else { 0 }, if ends { ENDS } else { 0 });
        Self(source.to_bits() << ENDS_BITS | begins | ends)
    }

    /// Returns the part of this part that has its beginning, or its end, or both, or neither.
    pub(crate) const fn cut(self, has_beginning: bool, has_end: bool) -> Self {
        Self::of(self.source(), self.begins() && has_beginning, self.ends() && has_end)
    }

    /// Returns the part from one position to another of this part, which is between the positions
    /// `ends`.
    pub(crate) fn between<T: PartialEq>(self, [from, to]: [T; 2], ends: [T; 2]) -> Self {
        let [start, end] = ends;
        self.cut(from == start, to == end)
    }

    /// Returns this part and another one of the same source together.
    pub(crate) const fn joined(self, other: Self) -> Self {
        Self(self.0 | other.0 & (BEGINS | ENDS))
    }

    /// Returns the number that stands for this value in memory and in spilled data.
    pub(crate) const fn to_bits(self) -> u64 {
        self.0
    }

    /// Returns the part that a number in memory stands for.
    pub(crate) const fn from_bits(bits: u64) -> Self {
        Self(bits)
    }

    /// Returns the two bits that stand for the ends in a file: whether it begins, and whether it
    /// ends a segment.
    pub(crate) const fn end_bits(self) -> [bool; 2] {
        [self.begins(), self.ends()]
    }
}

/// Gives the parts of equal sources the ends of all of them. The parts are sorted.
pub(crate) fn join_equal(parts: &mut [LinePart]) {
    for equal in parts.chunk_by_mut(|a, b| a.source() == b.source()) {
        let all = equal.iter().fold(equal[0], |all, &part| all.joined(part));
        equal.fill(all);
    }
}

impl From<EdgeSource> for LinePart {
    /// Returns the part of a line whose segment is the edge itself.
    fn from(source: EdgeSource) -> Self {
        Self::whole(source)
    }
}

impl fmt::Debug for LinePart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ends = match self.end_bits() {
            [false, false] => "",
            [true, false] => " from its start",
            [false, true] => " to its end",
            [true, true] => " from end to end",
        };
        write!(f, "{:?}{ends}", self.source())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reversing_a_part_swaps_its_ends_and_the_sides_of_obstacles() {
        for kind in [LineKind::BreakLine, LineKind::Wall, LineKind::Obstacle] {
            for number in [0, 1, 77, EdgeSource::MAX_NUMBER] {
                let source = EdgeSource::new(kind, number);
                for [begins, ends] in [[false, false], [false, true], [true, false], [true, true]] {
                    let part = LinePart::of(source, begins, ends);
                    assert_eq!((part.source(), part.end_bits()), (source, [begins, ends]));
                    let reversed = part.reversed();
                    assert_eq!(
                        (reversed.source(), reversed.end_bits()),
                        (source.reversed(), [ends, begins])
                    );
                    assert_eq!(reversed.reversed(), part);
                    assert_eq!(LinePart::from_bits(part.to_bits()), part);
                    assert_eq!(part.joined(LinePart::whole(source)), LinePart::whole(source));
                    assert_eq!(part.cut(true, false), LinePart::of(source, begins, false));
                }
            }
        }
    }
}
