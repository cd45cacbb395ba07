//! Where the segments of an obstacle end, once they are replaced by parts of them.
//!
//! In: the segments, and which of their ends are ends of segments of the input. Out: the same for a
//! part of them. Where segments overlap, one part replaces several. It has an end of a segment
//! where any of these has one, so that each vertex that a segment of the obstacle holds stays held.

use std::cmp::Ordering;

use crate::geometry::{Point, compare_lines};

/// The ends of the segments of an obstacle, each with the direction in which its segment leaves it.
#[derive(Debug)]
pub(crate) struct SegmentEnds {
    /// In order.
    ends: Vec<DirectedEnd>,
}

/// An end of a segment.
#[derive(Clone, Copy, Debug)]
struct DirectedEnd {
    at: Point,
    /// The other end of the segment.
    towards: Point,
}

impl DirectedEnd {
    /// Compares by position and direction.
    fn compare(&self, other: &Self) -> Ordering {
        let is_smaller = |end: &Self| end.at.lex_cmp(end.towards).is_lt();
        let forward = |end: &Self| match is_smaller(end) {
            true => [end.at, end.towards],
            false => [end.towards, end.at],
        };
        let places = self.at.lex_cmp(other.at);
        places
            .then_with(|| is_smaller(self).cmp(&is_smaller(other)))
            .then_with(|| compare_lines(forward(self), forward(other)))
    }
}

/// Returns both ends of a segment.
fn both_ends([a, b]: [Point; 2]) -> [DirectedEnd; 2] {
    [DirectedEnd { at: a, towards: b }, DirectedEnd { at: b, towards: a }]
}

impl SegmentEnds {
    /// Takes segments of positive length, each with the ends of it that count.
    pub(crate) fn of(segments: impl Iterator<Item = ([Point; 2], [bool; 2])>) -> Self {
        let ends = segments.flat_map(|(ends, is_end)| both_ends(ends).into_iter().zip(is_end));
        let mut ends: Vec<DirectedEnd> = ends.filter_map(|(end, is_end)| is_end.then_some(end)).collect();
        ends.sort_unstable_by(DirectedEnd::compare);
        Self { ends }
    }

    /// Returns which ends of a part of segments are ends of any segment along it.
    pub(crate) fn of_part(&self, ends: [Point; 2]) -> [bool; 2] {
        both_ends(ends).map(|end| self.ends.binary_search_by(|other| other.compare(&end)).is_ok())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_has_the_ends_of_all_segments_along_it() {
        let at = |x: f64, y: f64| Point::new(x, y);
        let (a, b, c, d) = (at(0.0, 0.0), at(2.0, 1.0), at(4.0, 2.0), at(6.0, 3.0));
        let aside = at(2.0, 5.0);
        let ends = SegmentEnds::of(
            [
                ([d, a], [true; 2]),
                ([b, c], [true, false]),
                // It leaves c in another direction, and does not hold it for the others.
                ([c, aside], [true; 2]),
            ]
            .into_iter(),
        );
        assert_eq!(ends.of_part([a, b]), [true, false]);
        assert_eq!(ends.of_part([b, c]), [true, false]);
        assert_eq!(ends.of_part([c, b]), [false, true]);
        assert_eq!(ends.of_part([c, d]), [false, true]);
        assert_eq!(ends.of_part([aside, c]), [true, true]);
        assert_eq!(ends.of_part([b, aside]), [false, false]);
    }
}
