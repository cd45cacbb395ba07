//! Overlapping lines: each interval of a line is followed once, however many lines overlap there.
//!
//! In: subsegments or segments, any number of them on one straight line. Out: the same, cut where
//! others on their line begin or end, grouped by interval; or the union of those that overlap.
//!
//! ```text
//!   a ●━━━━━━━━━━━━━━━━● c                  a ●━━━━━● b: a's
//!           b ●━━━━━━━━━━━━━━━━● d    ──▶   b ●━━━━━● c: a's and b's
//!                                           c ●━━━━━● d: b's
//! ```
//!
//! The output may be far larger than the input: if n lines all overlap, each edge records n lines.
//! The file holds that too, so it has a limit, which the memory sets. A break line or a wall that
//! overlaps itself counts once; rings of obstacles count each time.

use std::collections::BTreeMap;

use crate::collections::bucket_sort::bucket_sort;
use crate::constraints::segment::Segment;
use crate::geometry::{Point, compare_lines};
use crate::pipeline::conquer::constrain::refusal::{Overlaps, Refusal};
use crate::pipeline::records::Subsegment;
use crate::store::{EdgeSource, LineKind, LinePart};

/// Returns the ends, the lexicographically smaller one first.
fn in_order([a, b]: [Point; 2]) -> [Point; 2] {
    if a.lex_cmp(b).is_le() { [a, b] } else { [b, a] }
}

/// Cuts subsegments where others on their line begin or end. Passes to `take`, for each interval,
/// all subsegments there, which have the same ends.
pub(crate) fn for_each_part<E>(
    subsegments: &[Subsegment],
    point: impl Fn(u32) -> Point,
    mut take: impl FnMut(&[Subsegment]) -> Result<(), E>,
) -> Result<(), E> {
    // From the smaller end to the larger one, and the source likewise.
    let along = |subsegment: &Subsegment| {
        let [a, b] = subsegment.ends;
        match point(a).lex_cmp(point(b)).is_lt() {
            true => ([a, b], subsegment.source),
            false => ([b, a], subsegment.source.reversed()),
        }
    };
    let mut subsegments: Vec<([u32; 2], LinePart)> = subsegments.iter().map(along).collect();
    let on = |ends: [u32; 2]| ends.map(&point);
    let lines = |a: [u32; 2], b: [u32; 2]| compare_lines(on(a), on(b));
    subsegments.sort_unstable_by(|(a, _), (b, _)| lines(*a, *b).then_with(|| point(a[0]).lex_cmp(point(b[0]))));
    let mut part = Vec::new();
    for on_line in subsegments.chunk_by(|a, b| lines(a.0, b.0).is_eq()) {
        let mut ends: Vec<([u32; 2], LinePart)> = on_line.to_vec();
        ends.sort_unstable_by(|(a, _), (b, _)| point(a[1]).lex_cmp(point(b[1])));
        let mut vertices: Vec<u32> = on_line.iter().flat_map(|(ends, _)| *ends).collect();
        vertices.sort_unstable_by(|&a, &b| point(a).lex_cmp(point(b)));
        vertices.dedup();
        let (mut starts, mut ends) = (on_line, &*ends);
        let mut active: BTreeMap<EdgeSource, Active> = BTreeMap::new();
        for pair in vertices.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            for (_, part) in take_while(&mut ends, |(ends, _)| ends[1] == from) {
                if let Some(its) = active.get_mut(&part.source()) {
                    its.count -= 1;
                    if its.count == 0 {
                        active.remove(&part.source());
                    }
                }
            }
            for (_, part) in take_while(&mut starts, |(ends, _)| ends[0] == from) {
                let its = active.entry(part.source()).or_default();
                its.count += 1;
                its.begins |= part.begins();
            }
            // Those that end where the interval ends; the next interval removes them.
            for (_, part) in ends.iter().take_while(|(ends, _)| ends[1] == to) {
                if let Some(its) = active.get_mut(&part.source()) {
                    its.ends |= part.ends();
                }
            }
            part.clear();
            for (&source, its) in &mut active {
                let copies = match source.kind() {
                    LineKind::Obstacle => its.count,
                    LineKind::BreakLine | LineKind::Wall => 1,
                };
                let along = LinePart::of(source, its.begins, its.ends);
                part.extend(std::iter::repeat_n(Subsegment::new(from, to, along), copies));
                (its.begins, its.ends) = (false, false);
            }
            if !part.is_empty() {
                take(&part)?;
            }
        }
    }
    Ok(())
}

/// The subsegments of one source that run along an interval.
#[derive(Default)]
struct Active {
    count: usize,
    /// Whether any of them begins, or ends, a segment with the interval.
    begins: bool,
    ends: bool,
}

/// Takes the first elements off a slice for which the condition holds.
fn take_while<'a, T>(rest: &mut &'a [T], condition: impl Fn(&T) -> bool) -> &'a [T] {
    let count = rest.iter().take_while(|element| condition(element)).count();
    let (taken, left) = rest.split_at(count);
    *rest = left;
    taken
}

/// Returns the unions of overlapping segments on one line, without gaps, each with its segments.
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

/// A list of subsegments with a limit.
#[derive(Debug)]
pub(crate) struct LimitedSubsegments {
    pub(crate) subsegments: Vec<Subsegment>,
    most: usize,
    /// Length at which duplicates are removed.
    full: usize,
}

impl LimitedSubsegments {
    pub(crate) fn new(most: usize) -> Self {
        Self {
            subsegments: Vec::new(),
            most,
            full: most,
        }
    }

    pub(crate) fn push(&mut self, subsegment: Subsegment, point: Point) -> Result<(), Overlaps> {
        self.subsegments.push(subsegment);
        if self.subsegments.len() > self.full {
            self.subsegments.sort_unstable();
            dedup(&mut self.subsegments);
            if self.subsegments.len() > self.most {
                return Err(Overlaps {
                    sources: self.subsegments.len() as u64,
                    point,
                });
            }
            self.full = self.most.max(2 * self.subsegments.len());
        }
        Ok(())
    }

    /// Returns the subsegments sorted and without duplicates. Only rings of obstacles that run
    /// along an edge twice count twice.
    ///
    /// The ends are less than `vertices`.
    pub(crate) fn sorted(self, vertices: usize) -> Vec<Subsegment> {
        let mut subsegments = self.subsegments;
        // Those that are inserted in order mostly are.
        if !subsegments.is_sorted() {
            let end = |subsegment: &Subsegment| subsegment.ends[0];
            subsegments = bucket_sort(&subsegments, vertices, end, |&subsegment| subsegment);
        }
        dedup(&mut subsegments);
        subsegments
    }
}

/// Removes duplicates from sorted subsegments. Only rings of obstacles that run along an edge twice
/// count twice. Subsegments of one source along one edge get the ends of all of them.
fn dedup(subsegments: &mut Vec<Subsegment>) {
    let is_same = |a: &Subsegment, b: &Subsegment| a.ends == b.ends && a.source.source() == b.source.source();
    for equal in subsegments.chunk_by_mut(is_same).filter(|equal| equal.len() > 1) {
        let all = equal.iter().fold(equal[0].source, |all, one| all.joined(one.source));
        equal.iter_mut().for_each(|one| one.source = all);
    }
    subsegments.dedup_by(|a, b| a == b && a.source.kind() != LineKind::Obstacle);
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

    /// Points on a few lines of different slopes on a grid.
    fn grid_point(line: u32, step: u32) -> Point {
        let (line, step) = (f64::from(line), f64::from(step));
        [
            Point::new(step, 100.0),
            Point::new(-200.0, step),
            Point::new(step, 300.0 - 3.0 * step),
        ][line as usize]
    }

    fn source(number: u64) -> LinePart {
        let kinds = [LineKind::BreakLine, LineKind::Wall, LineKind::Obstacle];
        LinePart::whole(EdgeSource::new(kinds[number as usize % 3], number))
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

        #[test]
        fn every_interval_has_all_subsegments_that_run_along_it(
            given in prop::collection::vec((0u32..3, 0u32..20, 0u32..20, 0u64..6), 0..40),
        ) {
            let point = |v: u32| grid_point(v / 20, v % 20);
            let given = given.into_iter().filter(|(_, a, b, _)| a != b);
            let subsegments: Vec<Subsegment> = given
                .map(|(line, a, b, number)| Subsegment::new(20 * line + a, 20 * line + b, source(number)))
                .collect();
            // The unit steps of each line, with their sources.
            let mut expected: Vec<Subsegment> = Vec::new();
            for subsegment in &subsegments {
                let [a, b] = subsegment.ends;
                expected.extend((a..b).map(|step| subsegment.part([step, step + 1])));
            }
            let mut found: Vec<Subsegment> = Vec::new();
            for_each_part(&subsegments, point, |part| {
                prop_assert!(part.windows(2).all(|pair| pair[0].ends == pair[1].ends));
                for subsegment in part {
                    let [a, b] = subsegment.ends;
                    found.extend((a..b).map(|step| subsegment.part([step, step + 1])));
                }
                Ok(())
            })?;
            expected.sort_unstable();
            dedup(&mut expected);
            // There are no duplicates, except rings of obstacles.
            let before = found.len();
            found.sort_unstable();
            dedup(&mut found);
            prop_assert_eq!(found.len(), before);
            prop_assert_eq!(found, expected);
        }

        #[test]
        fn unions_of_overlapping_segments_have_no_gaps(
            given in prop::collection::vec((0u32..3, 0u32..20, 0u32..20), 0..30),
        ) {
            let mut segments: Vec<Segment> = given
                .iter()
                .filter(|(_, a, b)| a != b)
                .map(|&(line, a, b)| Segment { ends: [grid_point(line, a), grid_point(line, b)], source: source(0) })
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
    fn a_list_refuses_more_subsegments_than_its_limit() {
        let mut limited = LimitedSubsegments::new(10);
        let subsegment = |number| Subsegment::new(0, 1, LinePart::whole(EdgeSource::new(LineKind::Wall, number)));
        for round in 0..100 {
            limited.push(subsegment(round % 10), grid_point(0, 0)).unwrap();
        }
        assert!(limited.subsegments.len() <= 20);
        let all: Result<(), Overlaps> =
            (0..11).try_for_each(|number| limited.push(subsegment(number), grid_point(0, 3)));
        let refused = all.and_then(|()| (0..11).try_for_each(|_| limited.push(subsegment(0), grid_point(0, 3))));
        assert_eq!(refused.unwrap_err().point, grid_point(0, 3));
        let none: Result<(), Infallible> = for_each_part(&[], |_| Point::default(), |_| Ok(()));
        none.unwrap();
    }
}
