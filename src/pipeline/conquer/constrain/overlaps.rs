//! Lines that run along each other: each stretch of the plane is walked along once, however many of them there are.
//!
//! In: pieces or segments, any number of them on one straight line. Out: the same, cut where others of their line begin or
//! end, together with all that run along each part; or what they cover together.
//!
//! ```text
//!   a ●━━━━━━━━━━━━━━━━● c                  a ●━━━━━● b: a's
//!           b ●━━━━━━━━━━━━━━━━● d    ──▶   b ●━━━━━● c: a's and b's
//!                                           c ●━━━━━● d: b's
//! ```
//!
//! What comes out may be far more than what goes in: of n lines that all run along each other each edge knows its n lines.
//! That is what the file holds, so it has a limit, which the memory sets. A break line or a wall that runs along
//! itself counts once; rings of obstacles count each time.

use std::collections::BTreeMap;

use crate::collections::bucket_sort::bucket_sort;
use crate::constraints::segment::Segment;
use crate::geometry::{Point, compare_lines};
use crate::pipeline::conquer::constrain::refusal::{Overlaps, Refusal};
use crate::pipeline::records::Piece;
use crate::store::{EdgeSource, LineKind};

/// From the lexicographically smaller end to the larger one.
fn in_order([a, b]: [Point; 2]) -> [Point; 2] {
    if a.lex_cmp(b).is_le() { [a, b] } else { [b, a] }
}

/// Cuts pieces where others on their line begin or end, and gives all that run along each part, which have the same ends.
pub(crate) fn for_each_part<E>(
    pieces: &[Piece],
    point: impl Fn(u32) -> Point,
    mut take: impl FnMut(&[Piece]) -> Result<(), E>,
) -> Result<(), E> {
    // From the smaller end to the larger one, as are the sources.
    let along = |piece: &Piece| {
        let [a, b] = piece.ends;
        match point(a).lex_cmp(point(b)).is_lt() {
            true => ([a, b], piece.source),
            false => ([b, a], piece.source.reversed()),
        }
    };
    let mut pieces: Vec<([u32; 2], EdgeSource)> = pieces.iter().map(along).collect();
    let on = |ends: [u32; 2]| ends.map(&point);
    let lines = |a: [u32; 2], b: [u32; 2]| compare_lines(on(a), on(b));
    pieces.sort_unstable_by(|(a, _), (b, _)| lines(*a, *b).then_with(|| point(a[0]).lex_cmp(point(b[0]))));
    let mut part = Vec::new();
    for on_line in pieces.chunk_by(|a, b| lines(a.0, b.0).is_eq()) {
        let mut ends: Vec<([u32; 2], EdgeSource)> = on_line.to_vec();
        ends.sort_unstable_by(|(a, _), (b, _)| point(a[1]).lex_cmp(point(b[1])));
        let mut places: Vec<u32> = on_line.iter().flat_map(|(ends, _)| *ends).collect();
        places.sort_unstable_by(|&a, &b| point(a).lex_cmp(point(b)));
        places.dedup();
        let (mut starts, mut ends) = (on_line.iter().peekable(), ends.iter().peekable());
        let mut active: BTreeMap<EdgeSource, usize> = BTreeMap::new();
        for pair in places.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            while let Some((_, source)) = ends.next_if(|(ends, _)| ends[1] == from) {
                if let Some(count) = active.get_mut(source) {
                    *count -= 1;
                    if *count == 0 {
                        active.remove(source);
                    }
                }
            }
            while let Some((_, source)) = starts.next_if(|(ends, _)| ends[0] == from) {
                *active.entry(*source).or_default() += 1;
            }
            part.clear();
            for (&source, &count) in &active {
                let copies = match source.kind() {
                    LineKind::Obstacle => count,
                    LineKind::BreakLine | LineKind::Wall => 1,
                };
                part.extend(std::iter::repeat_n(Piece::new(from, to, source), copies));
            }
            if !part.is_empty() {
                take(&part)?;
            }
        }
    }
    Ok(())
}

/// What segments on one line cover together, without gaps, and those that do so.
pub(crate) fn covered(segments: &mut [Segment]) -> impl Iterator<Item = ([Point; 2], &[Segment])> {
    let ends = |segment: &Segment| in_order(segment.ends);
    segments.sort_unstable_by(|a, b| {
        let (a, b) = (ends(a), ends(b));
        compare_lines(a, b).then_with(|| a[0].lex_cmp(b[0]))
    });
    let mut rest = &*segments;
    std::iter::from_fn(move || {
        let mut whole = ends(rest.first()?);
        let mut count = 1;
        for segment in &rest[1..] {
            let [low, high] = ends(segment);
            if compare_lines(whole, [low, high]).is_ne() || low.lex_cmp(whole[1]).is_gt() {
                break;
            }
            if high.lex_cmp(whole[1]).is_gt() {
                whole[1] = high;
            }
            count += 1;
        }
        let (group, left) = rest.split_at(count);
        rest = left;
        Some((whole, group))
    })
}

/// Pieces, of which there may be so many.
#[derive(Debug)]
pub(crate) struct Limited {
    pub(crate) pieces: Vec<Piece>,
    most: usize,
    /// When they are to be looked through for those that are there twice.
    full: usize,
}

impl Limited {
    pub(crate) fn new(most: usize) -> Self {
        Self {
            pieces: Vec::new(),
            most,
            full: most,
        }
    }

    pub(crate) fn push(&mut self, piece: Piece, place: Point) -> Result<(), Overlaps> {
        self.pieces.push(piece);
        if self.pieces.len() > self.full {
            self.pieces.sort_unstable();
            dedup(&mut self.pieces);
            if self.pieces.len() > self.most {
                return Err(Overlaps {
                    sources: self.pieces.len() as u64,
                    place,
                });
            }
            self.full = self.most.max(2 * self.pieces.len());
        }
        Ok(())
    }

    /// In order, each once, but for rings of obstacles that run twice along an edge, which count twice.
    ///
    /// Their ends are below `vertices`.
    pub(crate) fn sorted(self, vertices: usize) -> Vec<Piece> {
        let mut pieces = bucket_sort(&self.pieces, vertices, |piece| piece.ends[0], |&piece| piece);
        dedup(&mut pieces);
        pieces
    }
}

/// Each once, of pieces in order; but rings of obstacles that run twice along an edge count twice.
fn dedup(pieces: &mut Vec<Piece>) {
    pieces.dedup_by(|a, b| a == b && a.source.kind() != LineKind::Obstacle);
}

impl From<Overlaps> for Refusal {
    fn from(overlaps: Overlaps) -> Self {
        Self::Overlaps(overlaps)
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use proptest::prelude::*;

    use super::*;

    /// Places on a few lines of different slope through the origin of a grid.
    fn place(line: u32, step: u32) -> Point {
        let (line, step) = (f64::from(line), f64::from(step));
        [
            Point::new(step, 100.0),
            Point::new(-200.0, step),
            Point::new(step, 300.0 - 3.0 * step),
        ][line as usize]
    }

    fn source(number: u64) -> EdgeSource {
        let kinds = [LineKind::BreakLine, LineKind::Wall, LineKind::Obstacle];
        EdgeSource::new(kinds[number as usize % 3], number)
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

        #[test]
        fn every_part_has_all_that_run_along_it(
            given in prop::collection::vec((0u32..3, 0u32..20, 0u32..20, 0u64..6), 0..40),
        ) {
            let point = |v: u32| place(v / 20, v % 20);
            let given = given.into_iter().filter(|(_, a, b, _)| a != b);
            let pieces: Vec<Piece> = given
                .map(|(line, a, b, number)| Piece::new(20 * line + a, 20 * line + b, source(number)))
                .collect();
            // Each step of each line, with what runs along it.
            let mut expected: Vec<Piece> = Vec::new();
            for piece in &pieces {
                let [a, b] = piece.ends;
                expected.extend((a..b).map(|step| Piece::new(step, step + 1, piece.source)));
            }
            let mut found: Vec<Piece> = Vec::new();
            for_each_part(&pieces, point, |part| {
                prop_assert!(part.windows(2).all(|pair| pair[0].ends == pair[1].ends));
                for piece in part {
                    let [a, b] = piece.ends;
                    found.extend((a..b).map(|step| Piece::new(step, step + 1, piece.source)));
                }
                Ok(())
            })?;
            expected.sort_unstable();
            dedup(&mut expected);
            // Nothing comes twice, but rings of obstacles.
            let before = found.len();
            found.sort_unstable();
            dedup(&mut found);
            prop_assert_eq!(found.len(), before);
            prop_assert_eq!(found, expected);
        }

        #[test]
        fn what_is_covered_has_no_gaps(
            given in prop::collection::vec((0u32..3, 0u32..20, 0u32..20), 0..30),
        ) {
            let mut segments: Vec<Segment> = given
                .iter()
                .filter(|(_, a, b)| a != b)
                .map(|&(line, a, b)| Segment { ends: [place(line, a), place(line, b)], source: source(0) })
                .collect();
            let mut steps: Vec<(u32, u32)> = given.iter().flat_map(|&(line, a, b)| (a.min(b)..a.max(b)).map(move |step| (line, step))).collect();
            steps.sort_unstable();
            steps.dedup();
            let count = segments.len();
            let (mut grouped, mut length, mut wholes) = (0, 0.0, Vec::new());
            for (whole, group) in covered(&mut segments) {
                grouped += group.len();
                let [low, high] = whole;
                length += (high.x - low.x).abs().max((high.y - low.y).abs() / if high.x == low.x { 1.0 } else { f64::INFINITY });
                prop_assert!(group.iter().all(|s| s.ends.iter().all(|end| end.lex_cmp(low).is_ge() && end.lex_cmp(high).is_le())));
                wholes.push(whole);
            }
            prop_assert_eq!(grouped, count);
            prop_assert_eq!(length, steps.len() as f64);
            wholes.dedup();
        }
    }

    #[test]
    fn more_than_there_may_be() {
        let mut limited = Limited::new(10);
        let piece = |number| Piece::new(0, 1, EdgeSource::new(LineKind::Wall, number));
        for round in 0..100 {
            limited.push(piece(round % 10), place(0, 0)).unwrap();
        }
        assert!(limited.pieces.len() <= 20);
        let all: Result<(), Overlaps> = (0..11).try_for_each(|number| limited.push(piece(number), place(0, 3)));
        let refused = all.and_then(|()| (0..11).try_for_each(|_| limited.push(piece(0), place(0, 3))));
        assert_eq!(refused.unwrap_err().place, place(0, 3));
        let none: Result<(), Infallible> = for_each_part(&[], |_| Point::default(), |_| Ok(()));
        none.unwrap();
    }
}
