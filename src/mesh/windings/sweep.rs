//! The exact winding of the rings of one polygon around each point, by a line that sweeps over its
//! edges.
//!
//! In: the segments of a polygon, the interior on their left. Out: whether the winding is negative
//! anywhere, or more than 1, and where first; and the windings on both sides of each part of an edge.
//!
//! ```text
//!                      │  The sweep line, just behind P. Points are ordered by (x, y), so the
//!          ╲     1     │  line is slightly tilted: of two points with the same x it meets the
//!      0    ╲       ╱──┤  lower one first.
//!        ────P─────╱ 0 │  At each point P that is an end of an edge, the edges through P leave
//!          ╱  ╲        │  the status. What is left of them and the edges that begin at P enter
//!         ╱ 1  ╲───────┤  it, by direction. The winding below is known, and each edge changes
//!                      │  it. A face has a leftmost corner, so every winding is met there.
//! ```
//!
//! Only orientations of given points are computed. Edges may touch, overlap and occur several
//! times. Where two edges cross, the sweep continues if the crossing point is representable as a
//! point: something else may have a vertex there, in which the edges meet. Otherwise no vertex can
//! be there, and the build reports the crossing.
//!
//! Bentley and Ottmann 1979; Shamos and Hoey 1976 for the pairs that are tested.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;
use std::ops::Range;

use crate::collections::union_find::UnionFind;
use crate::geometry::{ExactCrossing, Orientation, Point, orient2d, segments_cross};
use crate::mesh::windings::status::{Status, StatusEntry};

/// An edge: all segments between the same ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    /// The ends, the smaller one first.
    pub(crate) ends: [Point; 2],
    /// The winding above the edge minus the winding below it.
    rise: i32,
}

/// A part of an edge whose interior no other edge touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EdgePart {
    /// The number of the edge.
    pub(crate) edge: usize,
    /// The ends, the smaller one first.
    pub(crate) ends: [Point; 2],
    /// The windings below and above the part and all edges that overlap it.
    pub(crate) windings: [i32; 2],
    /// Whether it is the first of the edges that overlap each other.
    pub(crate) is_first: bool,
}

/// The result of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Outcome {
    /// Rings cross in a location that is not representable as a point.
    Crosses,
    /// A ring does not close.
    Open,
    /// All windings were computed.
    Seen {
        /// The smallest corner of a face whose winding is negative.
        first: Option<Point>,
        /// Number of faces whose winding is negative.
        faces: u64,
        /// The smallest corner of a face whose winding is more than 1.
        overlap: Option<Point>,
        /// Whether rings cross in a point that is not an end of an edge.
        meets: bool,
    },
}

/// A polygon that is prepared for a sweep.
#[derive(Debug)]
pub(crate) struct Sweep {
    /// The edges, in order.
    edges: Vec<Edge>,
    /// The larger ends, in order.
    ends: Vec<Point>,
}

/// Largest number of bytes that a segment takes while it is swept, itself included.
pub(crate) const BYTES: u64 = 160;

impl Sweep {
    /// Prepares to sweep segments with valid ends, the interior on their left.
    pub(crate) fn new(segments: impl Iterator<Item = [Point; 2]>) -> Self {
        let edges = segments.filter_map(|[a, b]| {
            let (ends, rise) = match a.lex_cmp(b) {
                Ordering::Less => ([a, b], 1),
                Ordering::Greater => ([b, a], -1),
                Ordering::Equal => return None,
            };
            Some(Edge { ends, rise })
        });
        let mut edges: Vec<Edge> = edges.collect();
        edges.sort_unstable_by(|one, other| order(one.ends, other.ends));
        edges.dedup_by(|next, kept| {
            let is_same = next.ends == kept.ends;
            if is_same {
                kept.rise += next.rise;
            }
            is_same
        });
        // Segments that cancel each other change nothing.
        edges.retain(|edge| edge.rise != 0);
        let mut ends: Vec<Point> = edges.iter().map(|edge| edge.ends[1]).collect();
        ends.sort_unstable_by(|p, q| p.lex_cmp(*q));
        ends.dedup();
        Self { edges, ends }
    }

    /// Returns the number of edges, which are numbered from 0.
    pub(crate) fn edge_count(&self) -> usize {
        self.edges.len()
    }

    /// Returns the number of the edge between two points; `None` if that edge changes no winding.
    pub(crate) fn edge_between(&self, a: Point, b: Point) -> Option<usize> {
        let ends = if a.lex_cmp(b).is_lt() { [a, b] } else { [b, a] };
        self.edges.binary_search_by(|edge| order(edge.ends, ends)).ok()
    }

    /// Sweeps over the whole polygon, or over the points whose x is in `range`. Edges that do not
    /// meet the range may be missing. Passes each part of an edge to `take`.
    pub(crate) fn run(&self, range: Option<[f64; 2]>, take: &mut dyn FnMut(EdgePart)) -> Outcome {
        SweepLine::over(self, range, take).run()
    }
}

fn order([a, b]: [Point; 2], [c, d]: [Point; 2]) -> Ordering {
    a.lex_cmp(c).then_with(|| b.lex_cmp(d))
}

/// A point, ordered as the sweep meets it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Event(Point);

impl Eq for Event {}

impl PartialOrd for Event {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Event {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.lex_cmp(other.0)
    }
}

/// The sweep line.
struct SweepLine<'a> {
    sweep: &'a Sweep,
    range: [f64; 2],
    /// Whether the windings are known. They are not before the range begins.
    is_within: bool,
    take: &'a mut dyn FnMut(EdgePart),
    status: Status,
    /// Number of edges that have begun, and of larger ends that were met.
    begun: usize,
    ended: usize,
    /// Crossing points that the sweep has not reached.
    crossings: BinaryHeap<Reverse<Event>>,
    meets: bool,
    faces: Faces,
    /// Buffers, kept for their capacity.
    taken: Vec<StatusEntry>,
    made: Vec<StatusEntry>,
}

impl<'a> SweepLine<'a> {
    fn over(sweep: &'a Sweep, range: Option<[f64; 2]>, take: &'a mut dyn FnMut(EdgePart)) -> Self {
        Self {
            sweep,
            range: range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]),
            is_within: range.is_none(),
            take,
            status: Status::new(),
            begun: 0,
            ended: 0,
            crossings: BinaryHeap::new(),
            meets: false,
            faces: Faces::new(),
            taken: Vec::new(),
            made: Vec::new(),
        }
    }

    fn run(mut self) -> Outcome {
        while let Some(point) = self.next_point() {
            if point.x >= self.range[1] {
                break;
            }
            if !self.is_within && point.x >= self.range[0] {
                self.enter();
            }
            if let Some(outcome) = self.pass(point) {
                return outcome;
            }
        }
        Outcome::Seen {
            first: self.faces.first,
            faces: self.faces.count,
            overlap: self.faces.overlap,
            meets: self.meets,
        }
    }

    fn next_point(&self) -> Option<Point> {
        let begin = self.sweep.edges.get(self.begun).map(|edge| edge.ends[0]);
        let end = self.sweep.ends.get(self.ended).copied();
        let crossing = self.crossings.peek().map(|Reverse(Event(point))| *point);
        let points = [begin, end, crossing].into_iter().flatten();
        points.min_by(|p, q| p.lex_cmp(*q))
    }

    /// Computes the windings of all entries of the status, which is complete now.
    fn enter(&mut self) {
        self.is_within = true;
        let mut above = 0;
        for entry in self.status.entries_mut() {
            let below = above;
            above += self.sweep.edges[entry.edge as usize].rise;
            entry.windings = [below, above];
        }
    }

    /// Moves the sweep line over a point. Returns an outcome if the sweep ends there.
    fn pass(&mut self, point: Point) -> Option<Outcome> {
        let edges = &*self.sweep.edges;
        let starting = edges[self.begun..].iter().take_while(|edge| edge.ends[0] == point);
        let starting = self.begun..self.begun + starting.count();
        self.begun = starting.end;
        let is_end = self.sweep.ends.get(self.ended) == Some(&point);
        self.ended += usize::from(is_end);
        while self.crossings.peek() == Some(&Reverse(Event(point))) {
            self.crossings.pop();
            self.meets |= starting.is_empty() && !is_end;
        }
        let orientation = |entry: &StatusEntry| {
            let [from, to] = edges[entry.edge as usize].ends;
            orient2d(from, to, point)
        };
        let at = self
            .status
            .search(|entry| orientation(entry) == Orientation::CounterClockwise);
        let lower = self.status.below(at).copied();
        let (faces, is_within) = (&mut self.faces, self.is_within);
        let mut is_closed = true;
        let behind = self.status.replace(
            at,
            |entry| orientation(entry) == Orientation::Collinear,
            [&mut self.taken, &mut self.made],
            |taken, made| {
                leave(edges, point, taken, starting, made);
                if is_within {
                    is_closed = faces.label(edges, point, [lower.as_ref(), taken.last()], made);
                }
            },
        );
        for entry in self.taken.iter().filter(|_| is_within) {
            (self.take)(EdgePart {
                edge: entry.edge as usize,
                ends: [entry.from, point],
                windings: entry.windings,
                is_first: entry.is_first,
            });
        }
        if !is_closed {
            return Some(Outcome::Open);
        }
        let upper = self.status.above(behind).map(|entry| entry.edge);
        let lower = lower.map(|entry| entry.edge);
        let (lowest, highest) = match &*self.made {
            [] => (upper, None),
            [lowest, .., highest] => (Some(lowest.edge), Some(highest.edge)),
            [only] => (Some(only.edge), Some(only.edge)),
        };
        let are_apart = self.check_neighbours(point, lower, lowest) && self.check_neighbours(point, highest, upper);
        (!are_apart).then_some(Outcome::Crosses)
    }

    /// Records where two neighbours cross. Returns `false` if they cross in a location that is not
    /// representable as a point.
    fn check_neighbours(&mut self, point: Point, one: Option<u32>, other: Option<u32>) -> bool {
        let (Some(one), Some(other)) = (one, other) else {
            return true;
        };
        let [one, other] = [one, other].map(|edge| self.sweep.edges[edge as usize].ends);
        if !segments_cross(one[0], one[1], other[0], other[1]) {
            return true;
        }
        let Some(crossing) = ExactCrossing::of(one, other).map(|crossing| crossing.rounded()) else {
            return true;
        };
        let is_on = |[a, b]: [Point; 2]| orient2d(a, b, crossing) == Orientation::Collinear;
        if !(is_on(one) && is_on(other)) {
            return false;
        }
        // Behind their crossing point they are neighbours again.
        if crossing.lex_cmp(point).is_gt() {
            self.crossings.push(Reverse(Event(crossing)));
        }
        true
    }
}

/// Collects the edges that leave a point: what is left of the edges that were `taken` there, and
/// the `starting` edges, by direction from below.
fn leave(edges: &[Edge], point: Point, taken: &[StatusEntry], starting: Range<usize>, made: &mut Vec<StatusEntry>) {
    let going_on = taken.iter().map(|entry| entry.edge);
    let going_on = going_on.filter(|&edge| edges[edge as usize].ends[1] != point);
    made.extend(
        going_on
            .chain(starting.map(|edge| edge as u32))
            .map(|edge| StatusEntry {
                edge,
                from: point,
                windings: [0; 2],
                face: 0,
                is_first: true,
            }),
    );
    if made.len() > 1 {
        made.sort_unstable_by(|one, other| by_direction(edges, point, one, other).then(one.edge.cmp(&other.edge)));
    }
}

/// Compares two edges that leave a point, by direction.
fn by_direction(edges: &[Edge], point: Point, one: &StatusEntry, other: &StatusEntry) -> Ordering {
    let [to, other] = [one, other].map(|entry| edges[entry.edge as usize].ends[1]);
    match orient2d(point, to, other) {
        Orientation::CounterClockwise => Ordering::Less,
        Orientation::Collinear => Ordering::Equal,
        Orientation::Clockwise => Ordering::Greater,
    }
}

/// The faces whose winding is negative, numbered from 1. Number 0 stands for all others.
struct Faces {
    joined: UnionFind,
    next: u32,
    count: u64,
    /// The first point at which such a face began.
    first: Option<Point>,
    /// The first point at which a face began whose winding is more than 1.
    overlap: Option<Point>,
}

impl Faces {
    fn new() -> Self {
        Self {
            joined: UnionFind::new(1),
            next: 1,
            count: 0,
            first: None,
            overlap: None,
        }
    }

    /// Labels the edges that leave a point. `lower` is the entry next below the point, and
    /// `highest` the highest entry that was taken there. Returns whether the windings agree.
    fn label(
        &mut self,
        edges: &[Edge],
        point: Point,
        [lower, highest]: [Option<&StatusEntry>; 2],
        made: &mut [StatusEntry],
    ) -> bool {
        let (mut winding, face) = lower.map_or((0, 0), |entry| (entry.windings[1], entry.face));
        let above = highest.map_or((winding, face), |entry| (entry.windings[1], entry.face));
        if made.is_empty() && winding < 0 && winding == above.0 {
            self.join(face, above.1);
        }
        let mut left = made.len();
        for along in made.chunk_by_mut(|one, other| by_direction(edges, point, one, other).is_eq()) {
            let rise: i32 = along.iter().map(|entry| edges[entry.edge as usize].rise).sum();
            let windings = [winding, winding + rise];
            winding += rise;
            left -= along.len();
            let face = match left {
                0 => above.1,
                _ if winding < 0 => self.begin(point),
                _ => {
                    self.overlap = self.overlap.or_else(|| (winding > 1).then_some(point));
                    0
                }
            };
            for (entry, at) in along.iter_mut().zip(0..) {
                (entry.windings, entry.face, entry.is_first) = (windings, face, at == 0);
            }
        }
        winding == above.0
    }

    fn begin(&mut self, point: Point) -> u32 {
        self.first.get_or_insert(point);
        self.joined.grow(1);
        self.next += 1;
        self.count += 1;
        self.next - 1
    }

    fn join(&mut self, one: u32, other: u32) {
        if self.joined.find(one) != self.joined.find(other) {
            self.joined.union(one, other);
            self.count -= 1;
        }
    }
}

#[cfg(test)]
mod tests;
