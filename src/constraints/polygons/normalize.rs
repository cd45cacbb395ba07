//! Obstacles that cover each place 0 or 1 times.
//!
//! In: the segments of an obstacle. Out: segments whose direction says where the interior is. Along
//! each, the depth changes by what the obstacle covers on its left, 1 or 0, minus what it covers on
//! its right. A place is covered if the winding around it is not 0. Where the difference is 0, a
//! segment occurs once in each direction, and remains a wall. Segments that overlap are one. They
//! are cut where they touch others; no coordinate is changed, and none is new.

use std::ops::Range;

use crate::constraints::error::ConstraintError;
use crate::constraints::polygons::segment_ends::SegmentEnds;
use crate::constraints::segment::Segment;
use crate::constraints::segments::spool::SegmentSpool;
use crate::geometry::Point;
use crate::mesh::windings::sweep::{EdgePart, Outcome, Sweep};
use crate::store::{LineBatch, LineKind, LinePart};

/// A part of a segment: the number of the segment, and the ends.
pub(crate) type DirectedPart = (usize, [Point; 2]);

/// Returns the normalised segments of an obstacle, whose segments are `ends` and have been prepared
/// to be swept. Of several segments along an edge, that with the smallest number by `line_of` is
/// kept. The result is a function of the set of segments.
pub(crate) fn direct(ends: &[[Point; 2]], line_of: impl Fn(usize) -> u64, sweep: &Sweep) -> Vec<DirectedPart> {
    let (mut parts, mut out): (Vec<EdgePart>, Vec<DirectedPart>) = (Vec::new(), Vec::new());
    sweep.run(None, &mut |part| parts.push(part));
    // The parts of an edge are in their order along it.
    parts.sort_by_key(|part| part.edge);
    let mut is_directed = vec![false; sweep.edge_count()];
    let mut order: Vec<usize> = (0..ends.len()).collect();
    order.sort_by_key(|&at| line_of(at));
    for at in order {
        let Some(edge) = sweep.edge_between(ends[at][0], ends[at][1]) else {
            // Its edge is traversed equally often in both directions.
            out.push((at, ends[at]));
            continue;
        };
        if std::mem::replace(&mut is_directed[edge], true) {
            continue;
        }
        let along = &parts[parts.partition_point(|part| part.edge < edge)..];
        let along = along.iter().take_while(|part| part.edge == edge);
        for part in along.filter(|part| part.is_first) {
            let [low, high] = part.ends;
            let [below, above] = part.windings.map(|winding| i32::from(winding != 0));
            if above >= below {
                out.push((at, [low, high]));
            }
            if above <= below {
                out.push((at, [high, low]));
            }
        }
    }
    out
}

/// A normaliser of the obstacles that a [`PolygonCheck`](crate::PolygonCheck) found to cover a place
/// more than once. All other segments pass through it unchanged.
///
/// ```
/// use delaunay_tiles::PolygonCheck;
/// use delaunay_tiles::geometry::Point;
/// use delaunay_tiles::input::SegmentBatch;
/// use delaunay_tiles::store::{EdgeSource, LineBatch, LineKind, LinePart};
///
/// // A triangle whose ring goes round twice.
/// let corners = [[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]].map(|[x, y]| Point::new(x, y));
/// let ends: Vec<[Point; 2]> = (0..6).map(|i| [corners[i % 3], corners[(i + 1) % 3]]).collect();
/// let lines = vec![0; 6];
/// let mut check = PolygonCheck::new(&std::env::temp_dir(), 1 << 20);
/// check.push(0, &SegmentBatch { ends: ends.clone(), lines, ..SegmentBatch::default() })?;
/// check.finish()?;
/// let mut normalizer = check.normalizer().unwrap();
/// let ring = LinePart::whole(EdgeSource::new(LineKind::Obstacle, 0));
/// let mut batch = LineBatch { ends, sources: vec![ring; 6] };
/// normalizer.normalize(&mut batch);
/// assert_eq!(batch.ends.len(), 3);
/// # Ok::<(), delaunay_tiles::ConstraintError>(())
/// ```
#[derive(Clone, Debug)]
pub struct PolygonNormalizer {
    /// The segments of the obstacles, by their numbers among all segments of obstacles.
    obstacles: Vec<Range<u64>>,
    /// Number of obstacles that were normalised.
    done: usize,
    /// Number of segments of obstacles so far.
    taken: u64,
    /// The segments of the current obstacle.
    held: Vec<Segment>,
}

impl PolygonNormalizer {
    pub(crate) fn new(obstacles: Vec<Range<u64>>) -> Self {
        Self {
            obstacles,
            done: 0,
            taken: 0,
            held: Vec::new(),
        }
    }

    /// Takes the segments of a batch, and leaves those in it that are ready: all whose obstacle is
    /// complete, normalised. Segments of zero length are removed.
    pub fn normalize(&mut self, batch: &mut LineBatch) {
        let mut ready = Vec::with_capacity(batch.ends.len());
        for (&ends, &source) in batch.ends.iter().zip(&batch.sources) {
            let ends = ends.map(Point::normalized);
            self.take(Segment { ends, source }, &mut ready);
        }
        batch.ends = ready.iter().map(|segment| segment.ends).collect();
        batch.sources = ready.iter().map(|segment| segment.source).collect();
    }

    /// Returns whether it holds segments of an obstacle that is not complete.
    pub(crate) fn is_within(&self) -> bool {
        !self.held.is_empty()
    }

    /// Copies all segments from one spool to another one, without z.
    pub(crate) fn copy(mut self, from: &mut SegmentSpool, to: &mut SegmentSpool) -> Result<(), ConstraintError> {
        let mut ready: Vec<Segment> = Vec::new();
        from.for_each_chunk(|segments| {
            segments.iter().for_each(|segment| self.take(*segment, &mut ready));
            to.push_parts(ready.drain(..))
        })
    }

    /// Takes a segment, and adds the segments that are ready to `ready`.
    pub(crate) fn take(&mut self, mut segment: Segment, ready: &mut Vec<Segment>) {
        if segment.source.depth_change() < 0 {
            segment.ends.reverse();
            segment.source = segment.source.reversed();
        }
        if segment.ends[0] == segment.ends[1] {
            return;
        }
        if segment.source.kind() != LineKind::Obstacle {
            ready.push(segment);
            return;
        }
        let number = self.taken;
        self.taken += 1;
        let of = self.obstacles.get(self.done);
        let Some(of) = of.filter(|of| of.contains(&number)) else {
            ready.push(segment);
            return;
        };
        self.held.push(segment);
        if self.taken == of.end {
            ready.extend(normalized(&self.held));
            self.held = Vec::new();
            self.done += 1;
        }
    }
}

/// Returns the normalised segments of an obstacle.
fn normalized(its: &[Segment]) -> Vec<Segment> {
    let ends: Vec<[Point; 2]> = its.iter().map(|segment| segment.ends).collect();
    let sweep = Sweep::new(ends.iter().copied());
    let overlaps = matches!(sweep.run(None, &mut |_| {}), Outcome::Seen { overlap: Some(_), .. });
    if !overlaps {
        return its.to_vec();
    }
    let parts = direct(&ends, |at| its[at].source.number(), &sweep);
    drop((ends, sweep));
    let segment_ends = SegmentEnds::of(its.iter().map(|segment| (segment.ends, segment.source.end_bits())));
    let segment = |(at, ends): DirectedPart| {
        let [begins, is_end] = segment_ends.of_part(ends);
        let source = LinePart::of(its[at].source.source(), begins, is_end);
        Segment { ends, source }
    };
    parts.into_iter().map(segment).collect()
}
