//! Splits segments at the points where they cross, until none cross. Rounding bends them there.
//!
//! In: all segments of a future planar straight-line graph, which may still cross. Out: subsegments
//! that do not cross, each with the tag and the direction of its segment, and the new vertices.
//!
//! ```text
//!  \   /                  \   /
//!   \ /                    \ /        p is the crossing point, each coordinate rounded. If a is
//! ---x-------a---   ──▶   --p         an end on the lower segment, the segment is cut there as
//!   / \      |            / \ \__     well: rounding moves it off the straight line, and a wall
//!  /   \     |           /   \   a--  that ends at it must still do so.
//! ```
//!
//! One round finds all pairs that cross. Both segments of a pair are cut at the rounded crossing
//! point, and at the ends of other segments and the other points that lie exactly on them. Rounding
//! moves a bent subsegment off its segment, so that it may cross others. Hence the next round. The
//! result of each round is a function of the set of segments. It does not depend on their order, on
//! their direction, or on the cells of the search.
//!
//! # Order along a segment
//!
//! Rounding keeps the order of each coordinate. So the points of a segment, exact or rounded, are
//! ordered along it as both their coordinates are: they form a chain that never turns back. Points
//! that neither coordinate distinguishes are one.
//!
//! # Termination
//!
//! If two segments cross, the rounded point is in both bounding boxes. It is an end of at most one
//! of them, since otherwise they would share an end. Hence it cuts at least one of them. Each
//! subsegment of a cut segment has a bounding box that is within the segment's and lacks one of the
//! segment's ends, so it contains fewer representable points. This cannot go on forever. It can
//! take more than [`MOST_ROUNDS`] rounds where many segments lie within a few units in the last
//! place of each other. There the coordinates are too coarse to represent the lines, and
//! subsegments drift from their segments with each round.

use std::cmp::Ordering;
use std::ops::ControlFlow;

use crate::constraints::crossings::boxes::bounds;
use crate::constraints::crossings::ends::Ends;
use crate::constraints::crossings::find::find;
use crate::constraints::crossings::search::search;
use crate::constraints::error::SplitError;
use crate::geometry::{Orientation, Point, Rect, orient2d};

/// Largest number of rounds.
const MOST_ROUNDS: usize = 10;

/// A segment and its tag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TaggedSegment<T> {
    /// Start and end.
    pub(crate) ends: [Point; 2],
    /// A value that its subsegments have too.
    pub(crate) tag: T,
}

impl<T> Ends for TaggedSegment<T> {
    #[inline]
    fn ends(&self) -> [Point; 2] {
        self.ends
    }
}

/// The result of splitting segments that crossed.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Split {
    /// Number of pairs that crossed in each round; empty if nothing crossed.
    pub(crate) crossings: Vec<u64>,
    /// The rounded crossing points in lexicographic order, each once. Some may have been ends
    /// before.
    pub(crate) points: Vec<Point>,
}

/// A function that passes all points within a rectangle that are vertices too, and possibly more,
/// in batches; or fails.
pub(crate) type PointSource<'a, E> = dyn FnMut(Rect, &mut dyn FnMut(&[Point])) -> Result<(), E> + 'a;

/// Smallest number of points that are searched for on segments at once.
const BATCH: usize = 1 << 16;

/// A point at which a segment is cut.
#[derive(Clone, Copy)]
struct Cut {
    segment: u32,
    point: Point,
}

/// Returns whether any segments cross.
pub(crate) fn any_cross<S: Ends>(segments: &[S]) -> bool {
    find(segments, Rect::PLANE, &mut |_, _, _| ControlFlow::Break(())).is_break()
}

/// Splits segments at their crossing points until none cross. The first round also splits them at
/// their crossings with `borders`. Other vertices, which `points` passes, cut the bent segments on
/// which they lie, as the ends of segments do.
///
/// At most `limit` pairs may cross in a round; each takes about 50 bytes. The total memory is about
/// 200 bytes per segment. Segments of zero length are unchanged. After an error, the contents of
/// `segments` are unspecified.
pub(crate) fn split<T: Copy, E: From<SplitError>>(
    segments: &mut Vec<TaggedSegment<T>>,
    limit: usize,
    borders: &[[Point; 2]],
    points: &mut PointSource<'_, E>,
) -> Result<Split, E> {
    split_in_rounds(segments, (limit, MOST_ROUNDS), borders, points)
}

pub(crate) fn split_in_rounds<T: Copy, E: From<SplitError>>(
    segments: &mut Vec<TaggedSegment<T>>,
    (limit, rounds): (usize, usize),
    borders: &[[Point; 2]],
    points: &mut PointSource<'_, E>,
) -> Result<Split, E> {
    let mut done = Split::default();
    loop {
        let mut cuts = Vec::new();
        let count = segments.len() as u32;
        let mut crossings = 0;
        let mut found = |one: u32, other: u32, point| {
            // Borders come after the segments.
            let ours = [one, other].into_iter().filter(|&segment| segment < count);
            cuts.extend(ours.map(|segment| Cut { segment, point }));
            crossings += u64::from(one.max(other) < count);
            if cuts.len() / 2 > limit {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        let stopped = if borders.is_empty() || !done.crossings.is_empty() {
            find(segments, Rect::PLANE, &mut found)
        } else {
            let ends = segments.iter().map(|segment| segment.ends);
            let all: Vec<[Point; 2]> = ends.chain(borders.iter().copied()).collect();
            find(&all, Rect::PLANE, &mut found)
        };
        if stopped.is_break() {
            return Err(SplitError::TooMany { limit }.into());
        }
        let smallest = cuts.iter().map(|cut| cut.point).min_by(|p, q| p.lex_cmp(*q));
        let Some(point) = smallest else { break };
        if done.crossings.len() == rounds {
            return Err(SplitError::StillCrossing {
                rounds,
                crossings,
                point,
            }
            .into());
        }
        done.crossings.push(crossings);
        done.points.extend(cuts.iter().map(|cut| cut.point));
        make_distinct(&mut done.points);
        cut_at_vertices(segments, &mut cuts, points)?;
        apply_cuts(segments, cuts);
    }
    Ok(done)
}

fn make_distinct(points: &mut Vec<Point>) {
    points.sort_unstable_by(|p, q| p.lex_cmp(*q));
    points.dedup();
}

/// Adds the ends of other segments, and other points, that lie on the segments that are cut.
fn cut_at_vertices<T, E>(
    segments: &[TaggedSegment<T>],
    cuts: &mut Vec<Cut>,
    points: &mut PointSource<'_, E>,
) -> Result<(), E> {
    cuts.sort_unstable_by_key(|cut| cut.segment);
    let mut numbers: Vec<u32> = cuts.iter().map(|cut| cut.segment).collect();
    numbers.dedup();
    let cut_segments: Vec<[Point; 2]> = numbers.iter().map(|&number| segments[number as usize].ends).collect();
    let around = cut_segments
        .iter()
        .fold(Rect::EMPTY, |all, &line| all.union(bounds(line)));
    let ends = segments.iter().flat_map(|segment| segment.ends);
    let mut near: Vec<Point> = ends.filter(|&end| around.contains(end)).collect();
    cut_at(&cut_segments, &numbers, &mut near, cuts);
    // Each search examines all cut segments.
    let most = BATCH.max(cut_segments.len());
    points(around, &mut |some| {
        near.extend(some.iter().filter(|&&point| around.contains(point)));
        if near.len() >= most {
            cut_at(&cut_segments, &numbers, &mut near, cuts);
        }
    })?;
    cut_at(&cut_segments, &numbers, &mut near, cuts);
    Ok(())
}

/// Cuts segments, whose numbers are `numbers`, at the points that lie on them. Empties `points`.
fn cut_at(cut_segments: &[[Point; 2]], numbers: &[u32], points: &mut Vec<Point>, cuts: &mut Vec<Cut>) {
    make_distinct(points);
    // Points are searched for as segments of zero length.
    let mut all = cut_segments.to_vec();
    all.extend(points.drain(..).map(|point| [point; 2]));
    let point_of = |[a, b]: [Point; 2]| (a == b).then_some(a);
    let meet = |one: [Point; 2], other: [Point; 2], _: Rect| match (point_of(one), point_of(other)) {
        (Some(point), None) => is_on(point, other).then_some(point),
        (None, Some(point)) => is_on(point, one).then_some(point),
        _ => None,
    };
    let _never_breaks = search(&all, Rect::PLANE, &meet, &mut |one, other, point| {
        // The cut segments come before the points.
        let segment = numbers[one.min(other) as usize];
        cuts.push(Cut { segment, point });
        ControlFlow::Continue(())
    });
}

/// Returns whether a point in the bounding box of a segment is on the segment.
fn is_on(point: Point, [a, b]: [Point; 2]) -> bool {
    orient2d(a, b, point) == Orientation::Collinear
}

/// Replaces segments by their subsegments between cuts.
fn apply_cuts<T: Copy>(segments: &mut Vec<TaggedSegment<T>>, mut cuts: Vec<Cut>) {
    let along = |cut: &Cut, other: &Cut| {
        let ends = || segments[cut.segment as usize].ends;
        let segment = cut.segment.cmp(&other.segment);
        segment.then_with(|| along(ends(), cut.point, other.point))
    };
    cuts.sort_unstable_by(along);
    let mut subsegments = Vec::with_capacity(segments.len() + cuts.len());
    let mut cuts = cuts.into_iter().peekable();
    for (segment, number) in segments.iter().zip(0..=u32::MAX) {
        let [mut from, to] = segment.ends;
        while let Some(cut) = cuts.next_if(|cut| cut.segment == number) {
            if cut.point != from && cut.point != to {
                let ends = [from, cut.point];
                subsegments.push(TaggedSegment { ends, ..*segment });
                from = cut.point;
            }
        }
        let ends = [from, to];
        subsegments.push(TaggedSegment { ends, ..*segment });
    }
    *segments = subsegments;
}

/// Compares two points by their order along a segment. They are on it, up to rounding.
fn along([a, b]: [Point; 2], p: Point, q: Point) -> Ordering {
    let by = |a: f64, b: f64, p: f64, q: f64| if a <= b { p.total_cmp(&q) } else { q.total_cmp(&p) };
    by(a.x, b.x, p.x, q.x).then_with(|| by(a.y, b.y, p.y, q.y))
}
