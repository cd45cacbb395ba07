//! Pairs of segments that cells do not separate.
//!
//! In: segments most of which are in each other's bounding boxes. Out: the pairs that may meet.
//!
//! - Equal segments are treated as one.
//! - The sweep runs in the direction in which segments are thinnest: that of their mean normal, or
//!   an axis. Segments are sorted by their start in that direction. Each is compared with those
//!   that have started before and not ended. So parallels of any slope are separated, which their
//!   bounding boxes do not achieve.
//! - Segments that share an end do not meet elsewhere. The segments at an end that many share, like
//!   the centre of a star, are a **fan**, and not compared with each other. Many segments on one
//!   straight line do not cross either, so they are a fan too.

use std::collections::HashMap;
use std::f64;
use std::ops::ControlFlow;

use crate::constraints::crossings::boxes::{bounds, boxes_meet, share_an_end};
use crate::geometry::{Point, Rect, compare_lines};

/// Smallest number of segments of a fan.
const FAN: usize = 32;

/// Largest number of comparisons per segment at which a sweep is cheap.
const CHEAP: usize = 200;

/// Largest fraction of all pairs that may remain for segments to be separated before they are
/// swept.
const WORTH_PARTING: f64 = 0.9;

/// A group of equal segments, with their lexicographically smaller end first.
struct DistinctSegment {
    ends: [Point; 2],
    bounds: Rect,
    /// Number of its fan, from 1; 0 if it is in none.
    fan: usize,
    /// Start and end of its range in `Sweep::numbers`.
    numbers: [usize; 2],
}

/// Segments that are prepared for a sweep.
pub(crate) struct Sweep {
    segments: Vec<DistinctSegment>,
    numbers: Vec<u32>,
    /// Number of segments in each fan. Entry 0 counts those in no fan.
    fans: Vec<usize>,
    /// Start and end of each segment in the direction of the sweep.
    intervals: Vec<[f64; 2]>,
    /// Average length of an interval, as a fraction of the whole range.
    thickness: f64,
}

impl Sweep {
    /// Prepares to sweep segments, given with their numbers.
    pub(crate) fn new(segments: impl Iterator<Item = ([Point; 2], u32)>) -> Self {
        let (mut segments, numbers) = distinct(segments);
        let fans = find_fans(&mut segments);
        let (intervals, thickness) = intervals(&segments);
        Self {
            segments,
            numbers,
            fans,
            intervals,
            thickness,
        }
    }

    /// Returns whether there are few pairs to compare, relative to the number of segments.
    pub(crate) fn is_cheap(&self) -> bool {
        let pairs = self.pairs() * self.thickness.min(1.0);
        pairs <= (CHEAP * self.segments.len()) as f64
    }

    /// Returns whether there are more pairs to compare than within all `parts` together. Each part
    /// is a list of segment numbers.
    pub(crate) fn is_worse_than<'a>(&self, parts: impl Iterator<Item = &'a [u32]>) -> bool {
        let in_fans = self.segments.iter().filter(|segment| segment.fan > 0);
        let fans: HashMap<u32, usize> = in_fans
            .flat_map(|segment| self.numbers(segment).iter().map(|&number| (number, segment.fan)))
            .collect();
        let in_parts = parts.map(|part| {
            let fan = |number: &u32| fans.get(number).copied().unwrap_or_default();
            let mut its: Vec<usize> = part.iter().map(fan).collect();
            its.sort_unstable();
            pairs_between(its.chunk_by(|a, b| a == b).map(|fan| (fan[0], fan.len())))
        });
        in_parts.sum::<f64>() <= WORTH_PARTING * self.pairs()
    }

    fn pairs(&self) -> f64 {
        pairs_between(self.fans.iter().copied().enumerate())
    }

    /// Visits pairs of segments that may meet. Each of the two comes with the numbers of all
    /// segments that are equal to it.
    pub(crate) fn visit(
        &self,
        mut visit: impl FnMut(([Point; 2], &[u32]), ([Point; 2], &[u32])) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut order: Vec<usize> = (0..self.segments.len()).collect();
        order.sort_unstable_by(|&a, &b| self.intervals[a][0].total_cmp(&self.intervals[b][0]));
        // The segments that have started, by fan.
        let mut open: Vec<Vec<usize>> = vec![Vec::new(); self.fans.len()];
        for number in order {
            let segment = &self.segments[number];
            let begin = self.intervals[number][0];
            let others = open.iter_mut().enumerate();
            for (_, others) in others.filter(|(fan, _)| *fan == 0 || *fan != segment.fan) {
                let mut index = 0;
                while let Some(&other) = others.get(index) {
                    if self.intervals[other][1] < begin {
                        others.swap_remove(index);
                        continue;
                    }
                    index += 1;
                    let other = &self.segments[other];
                    if boxes_meet(&segment.bounds, &other.bounds) && !share_an_end(segment.ends, other.ends) {
                        visit((segment.ends, self.numbers(segment)), (other.ends, self.numbers(other)))?;
                    }
                }
            }
            open[segment.fan].push(number);
        }
        ControlFlow::Continue(())
    }

    fn numbers(&self, segment: &DistinctSegment) -> &[u32] {
        &self.numbers[segment.numbers[0]..segment.numbers[1]]
    }
}

/// Returns twice the number of pairs of segments that are not in the same fan. `fans` has the
/// number and the size of each fan; number 0 stands for no fan.
fn pairs_between(fans: impl Iterator<Item = (usize, usize)>) -> f64 {
    let (mut all, mut in_fans) = (0.0, 0.0);
    for (fan, count) in fans {
        let count = count as f64;
        all += count;
        in_fans += if fan > 0 { count * count } else { 0.0 };
    }
    all * all - in_fans
}

/// Returns the distinct segments, and the numbers of all segments, with those of equal segments
/// together.
fn distinct(segments: impl Iterator<Item = ([Point; 2], u32)>) -> (Vec<DistinctSegment>, Vec<u32>) {
    let directed = |[a, b]: [Point; 2]| if b.lex_cmp(a).is_lt() { [b, a] } else { [a, b] };
    let mut sorted: Vec<_> = segments.map(|(ends, number)| (directed(ends), number)).collect();
    sorted.sort_unstable_by(|([a, b], _), ([c, d], _)| a.lex_cmp(*c).then(b.lex_cmp(*d)));
    let mut begin = 0;
    let segments = sorted.chunk_by(|one, other| one.0 == other.0).map(|equals| {
        let numbers = [begin, begin + equals.len()];
        begin = numbers[1];
        let ends = equals[0].0;
        DistinctSegment {
            ends,
            bounds: bounds(ends),
            fan: 0,
            numbers,
        }
    });
    (segments.collect(), sorted.iter().map(|(_, number)| *number).collect())
}

/// Numbers the fans from 1, and assigns each segment to the largest fan that it is in. Returns the
/// number of segments in each fan.
fn find_fans(segments: &mut [DistinctSegment]) -> Vec<usize> {
    let mut ends: Vec<(Point, usize)> = Vec::with_capacity(2 * segments.len());
    for (number, segment) in segments.iter().enumerate() {
        ends.extend(segment.ends.map(|end| (end, number)));
    }
    ends.sort_unstable_by(|a, b| a.0.lex_cmp(b.0));
    let with_length = segments
        .iter()
        .zip(0..)
        .filter(|(segment, _)| segment.ends[0] != segment.ends[1]);
    let mut along: Vec<([Point; 2], usize)> = with_length.map(|(segment, number)| (segment.ends, number)).collect();
    along.sort_unstable_by(|a, b| compare_lines(a.0, b.0));
    let around = ends.chunk_by(|a, b| a.0 == b.0).filter(|fan| fan.len() >= FAN);
    let on_line = along.chunk_by(|a, b| compare_lines(a.0, b.0).is_eq());
    let on_line = on_line.filter(|fan| fan.len() >= FAN);
    let mut fans: Vec<Vec<usize>> = around.map(numbers_of).chain(on_line.map(numbers_of)).collect();
    // The largest fan comes last and overrides the others.
    fans.sort_by_key(|fan| fan.len());
    for (fan, members) in (1..).zip(&fans) {
        for &number in members {
            segments[number].fan = fan;
        }
    }
    let mut counts = vec![0; fans.len() + 1];
    segments.iter().for_each(|segment| counts[segment.fan] += 1);
    counts
}

fn numbers_of<T>(some: &[(T, usize)]) -> Vec<usize> {
    some.iter().map(|(_, number)| *number).collect()
}

/// Returns the start and end of each segment, rounded outwards, in the direction in which segments
/// are thinnest. Also returns how thin they are: the average fraction of the whole range that a
/// segment takes.
fn intervals(segments: &[DistinctSegment]) -> (Vec<[f64; 2]>, f64) {
    // Angles are doubled, so that opposite directions are the same.
    let (mut cosine, mut sine) = (0.0, 0.0);
    for DistinctSegment { ends: [a, b], .. } in segments {
        let (x, y) = (b.x - a.x, b.y - a.y);
        let length = x.hypot(y);
        if length > 0.0 {
            cosine += (x / length) * x - (y / length) * y;
            sine += 2.0 * (x / length) * y;
        }
    }
    let normal = sine.atan2(cosine) / 2.0 + f64::consts::FRAC_PI_2;
    let directions = [[1.0, 0.0], [0.0, 1.0], [normal.cos(), normal.sin()]];
    let all = directions.map(|direction| {
        let intervals: Vec<[f64; 2]> = segments.iter().map(|segment| project(segment, direction)).collect();
        let around = |[low, high]: [f64; 2], [a, b]: &[f64; 2]| [low.min(*a), high.max(*b)];
        let [low, high] = intervals.iter().fold([f64::INFINITY, f64::NEG_INFINITY], around);
        let sum: f64 = intervals.iter().map(|[low, high]| high - low).sum();
        let range = (high - low) * segments.len() as f64;
        (intervals, if range > 0.0 { sum / range } else { 1.0 })
    });
    let thinnest = all.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
    thinnest.unwrap_or_default()
}

/// Returns the interval of a segment's projection on a direction whose components are at most 1.
fn project(segment: &DistinctSegment, [x, y]: [f64; 2]) -> [f64; 2] {
    let along = segment.ends.map(|p| {
        let (along_x, along_y) = (x * p.x, y * p.y);
        // Three roundings of half a unit in the last place each.
        let error = (along_x.abs() + along_y.abs()) * (2.0 * f64::EPSILON);
        [along_x + along_y - error, along_x + along_y + error]
    });
    [along[0][0].min(along[1][0]), along[0][1].max(along[1][1])]
}
