//! The parts of a line that are in polygons.
//!
//! In: a line and polygons. Out: its parts, one after the other. They end exactly where the line crosses
//! the boundary of the polygons, at a point that is rounded once. The boundary counts as inside, so a part
//! may run along an edge.
//!
//! ```text
//!          ┌────────┐        A segment stops where an edge of a polygon crosses it, ends
//!  p ──────┼▶▶▶▶▶▶▶▶┼──── q   on it, or runs along it. Each stop changes the winding
//!          └────────┘        number of what is just left of the segment.
//! ```
//!
//! The winding number is that of a point just left of the segment, so that ends of edges on the segment
//! need no rules of their own: an edge counts where its left end and its other end are on different sides.
//! Rounding keeps the order of stops, so what is lost by it is only what has no length afterwards.

use std::sync::Arc;

use super::chain;
use super::clip::{Clip, Side};
use crate::geometry::{Orientation, Point, Rect, crossing_point, orient2d};

/// A place on a segment where an edge of a polygon changes what is left of it.
#[derive(Clone, Copy, Debug)]
struct Stop {
    point: Point,
    /// The change of the winding number.
    winding: i32,
    /// The change of the number of edges that run along the segment.
    along: i32,
}

/// Bytes of memory that a [`Cut`] takes for each edge of polygons near a segment: a number, which the search
/// may find several times, a stop or two and a part, in lists that grow.
pub(crate) const CUT_PER_EDGE: u64 = 288;

/// The covered parts of a line, one after the other.
pub(crate) struct Cut {
    clip: Arc<Clip>,
    line: Vec<Point>,
    is_closed: bool,
    /// The index of the end of the next segment.
    next: usize,
    /// The ends of the other parts of the segment before it, and whether they are covered, from the last
    /// to the first.
    parts: Vec<(Point, bool)>,
    /// Where the parts begin.
    at: Point,
    /// The winding number where the next segment begins, if that is known: not on an edge.
    winding: Option<i32>,
    /// Whether a part of the line was not covered.
    is_cut: bool,
    /// What a closed line has until it is not covered for the first time; the last part leads to it.
    first: Vec<Point>,
}

/// A covered part of a line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Piece {
    /// At least two; no two consecutive ones are equal.
    pub(crate) points: Vec<Point>,
    /// Whether this is the whole of a closed line.
    pub(crate) is_closed: bool,
}

impl Cut {
    /// Prepares to cut a line. No two consecutive points of it are equal. The last point of a closed one is
    /// the first.
    pub(crate) fn new(clip: Arc<Clip>, line: Vec<Point>, is_closed: bool) -> Self {
        Self {
            clip,
            at: line.first().copied().unwrap_or_default(),
            line,
            is_closed,
            next: 1,
            parts: Vec::new(),
            winding: None,
            is_cut: false,
            first: Vec::new(),
        }
    }

    /// Returns the next part of a segment: its ends, and whether it is covered.
    fn part(&mut self) -> Option<([Point; 2], bool)> {
        loop {
            if let Some((to, is_covered)) = self.parts.pop() {
                return Some(([std::mem::replace(&mut self.at, to), to], is_covered));
            }
            let end = *self.line.get(self.next)?;
            let segment = [self.line[self.next - 1], end];
            self.next += 1;
            let (mut now, mut stops, ends_on_edge) = self.clip.stops(segment);
            now.winding = self.winding.unwrap_or_else(|| self.clip.winding_beside(segment));
            let winding = self.fill_parts(segment, now, &mut stops);
            self.winding = (!ends_on_edge).then_some(winding);
        }
    }

    /// Finds the parts of a segment that have a length, given what is at its start. Returns the winding
    /// number left of its end.
    fn fill_parts(&mut self, [p, q]: [Point; 2], mut now: Stop, stops: &mut [Stop]) -> i32 {
        let order = p.lex_cmp(q);
        stops.sort_unstable_by(|a, b| match order.is_lt() {
            true => a.point.lex_cmp(b.point),
            false => b.point.lex_cmp(a.point),
        });
        let mut from = p;
        let is_covered = |now: &Stop| now.winding > 0 || now.along > 0;
        let parts = &mut self.parts;
        let mut add = |to: Point, now: &Stop| {
            if from == to {
                return;
            }
            match parts.last_mut() {
                Some((end, before)) if *before == is_covered(now) => *end = to,
                _ => parts.push((to, is_covered(now))),
            }
            from = to;
        };
        for stop in &*stops {
            add(stop.point, &now);
            now.winding += stop.winding;
            now.along += stop.along;
        }
        add(q, &now);
        parts.reverse();
        now.winding
    }

    /// Returns the last part of the line: of a closed one, that to its start with that from its start.
    fn last(&mut self, mut points: Vec<Point>) -> Option<Piece> {
        let is_closed = self.is_closed && !self.is_cut;
        for point in std::mem::take(&mut self.first) {
            chain::push(&mut points, point);
        }
        (!points.is_empty()).then_some(Piece { points, is_closed })
    }
}

impl Iterator for Cut {
    type Item = Piece;

    fn next(&mut self) -> Option<Piece> {
        let mut points = Vec::new();
        while let Some(([from, to], is_covered)) = self.part() {
            if is_covered {
                if points.is_empty() {
                    points.push(from);
                }
                points.push(to);
                continue;
            }
            let is_first = !std::mem::replace(&mut self.is_cut, true);
            if is_first && self.is_closed {
                self.first = std::mem::take(&mut points);
            } else if !points.is_empty() {
                let is_closed = false;
                return Some(Piece { points, is_closed });
            }
        }
        self.last(points)
    }
}

impl Clip {
    /// Returns on which side of the boundary of the polygons a line is; `Both` if it meets the boundary.
    /// Exact.
    pub(crate) fn side_of_line(&self, line: &[Point]) -> Side {
        let meets = |[p, q]: [Point; 2]| {
            let around = Rect::around([p, q]);
            let mut near = self.edges_between(around.min_y, around.max_y);
            self.bounds().intersects(around)
                && near.any(|edge| Rect::around(edge).intersects(around) && meeting([p, q], edge).is_some())
        };
        let around = Rect::around(line.iter().copied());
        let mut near = self.edges_between(around.min_y, around.max_y);
        let is_near = near.any(|edge| Rect::around(edge).intersects(around));
        match line.first() {
            None => Side::Outside,
            Some(_) if is_near && line.windows(2).any(|ends| meets([ends[0], ends[1]])) => Side::Both,
            Some(&first) if self.covers(first) => Side::Inside,
            Some(_) => Side::Outside,
        }
    }

    /// Returns how many edges run along a segment at its start, where edges change what is left of it, in
    /// no order, and whether an edge passes through its end.
    fn stops(&self, segment: [Point; 2]) -> (Stop, Vec<Stop>, bool) {
        let (mut stops, mut ends_on_edge) = (Vec::new(), false);
        let mut begins = Stop {
            point: segment[0],
            winding: 0,
            along: 0,
        };
        for edge in self.edges_near(Rect::around(segment)) {
            let Some(sides) = meeting(segment, edge) else { continue };
            ends_on_edge |= sides.1[1] == Orientation::Collinear;
            match sides.0 == [Orientation::Collinear; 2] {
                true => begins.along += add_along(segment, edge, &mut stops),
                false => stops.extend(stop(segment, edge, sides)),
            }
        }
        (begins, stops, ends_on_edge)
    }

    /// Returns the winding number of a point at a distance behind the start of a segment that is
    /// infinitesimal, and left of it by an infinitesimal share of that.
    fn winding_beside(&self, [p, q]: [Point; 2]) -> i32 {
        let rises = q.y > p.y || (q.y == p.y && q.x > p.x);
        let is_above = |end: Point| if end.y == p.y { !rises } else { end.y > p.y };
        let mut winding = 0;
        // At one y, each edge comes once.
        for [a, b] in self.edges_between(p.y, p.y) {
            if is_above(a) == is_above(b) || a.x.max(b.x) < p.x {
                continue;
            }
            let side = match (orient2d(a, b, p), orient2d(a, b, q)) {
                (Orientation::Collinear, Orientation::Collinear) if a.lex_cmp(b) == p.lex_cmp(q) => {
                    Orientation::CounterClockwise
                }
                (Orientation::Collinear, Orientation::Collinear) => Orientation::Clockwise,
                (Orientation::Collinear, side) | (side, _) => side,
            };
            // Edges right of the point count.
            winding += i32::from(is_above(b) && side == Orientation::CounterClockwise);
            winding -= i32::from(is_above(a) && side == Orientation::Clockwise);
        }
        winding
    }
}

/// On which side of a segment the ends of an edge are, and the reverse.
type Sides = ([Orientation; 2], [Orientation; 2]);

/// Returns how a segment and an edge whose boxes meet lie to each other, if they have a point in common.
fn meeting([p, q]: [Point; 2], [a, b]: [Point; 2]) -> Option<Sides> {
    let is_apart = |[one, other]: [Orientation; 2]| one == other && one != Orientation::Collinear;
    let of_edge = [a, b].map(|end| orient2d(p, q, end));
    if is_apart(of_edge) {
        return None;
    }
    let of_segment = [p, q].map(|end| orient2d(a, b, end));
    (!is_apart(of_segment)).then_some((of_edge, of_segment))
}

/// Returns where an edge that meets a segment changes the winding number on the left of the segment.
fn stop([p, q]: [Point; 2], [a, b]: [Point; 2], (of_edge, of_segment): Sides) -> Option<Stop> {
    let is_left = of_edge.map(|side| side == Orientation::CounterClockwise);
    // What is at the start of the segment is counted there, and what is at its end concerns the next one.
    if is_left[0] == is_left[1] || of_segment.contains(&Orientation::Collinear) {
        return None;
    }
    let on_segment = of_edge.iter().position(|&side| side == Orientation::Collinear);
    let point = match on_segment {
        Some(end) => [a, b][end],
        None => crossing_point(p, q, a, b)?.normalized(),
    };
    Some(Stop {
        point,
        // The interior is on the left of the edge. Where it leads to the left, that is what is behind.
        winding: if is_left[1] { -1 } else { 1 },
        along: 0,
    })
}

/// Adds where an edge begins and ends to run along a segment. Returns 1 if it does at its start, else 0.
fn add_along([p, q]: [Point; 2], [a, b]: [Point; 2], stops: &mut Vec<Stop>) -> i32 {
    let order = p.lex_cmp(q);
    let [from, to] = if a.lex_cmp(b) == order { [a, b] } else { [b, a] };
    let is_before = |one: Point, other: Point| one.lex_cmp(other) == order;
    if !is_before(from, q) || !is_before(p, to) {
        return 0;
    }
    let mut add = |point: Point, along: i32| {
        let winding = 0;
        stops.push(Stop { point, winding, along });
    };
    if is_before(to, q) {
        add(to, -1);
    }
    match is_before(p, from) {
        true => {
            add(from, 1);
            0
        }
        false => 1,
    }
}

#[cfg(test)]
mod tests;
