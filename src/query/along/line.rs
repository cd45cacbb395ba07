//! The space along a straight line: which triangles the line passes, and where.
//!
//! Positions on the line are numbers from 0 at its start to 1 at its end. A position is computed
//! only from the line and the edge that it crosses, or the vertex that it passes through, so
//! neighbouring triangles agree about it to the last bit. Exact predicates decide which triangles
//! the line passes.

use foldhash::HashMap;

use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, orient2d, segment_meets};
use crate::mesh::Twin;
use crate::query::answer::distance;
use crate::query::request::{QueryError, Tiles, key};
use crate::store::{Tile, TileId};

/// A line from one point to another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QueryLine {
    pub(super) from: Point,
    pub(super) to: Point,
}

/// The part of the line in a closed triangle, or outside the hull.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LineSection {
    /// The positions where the section starts and ends.
    pub(super) range: [f64; 2],
    /// The corners of the triangle; `None` outside the hull.
    pub(super) triangle: Option<[Point; 3]>,
    /// For a section along an edge: a point on the section's side of the edge.
    pub(super) beside: Option<Point>,
}

/// The free sections of the line.
#[derive(Debug, Default)]
pub(crate) struct LineSections {
    /// The sections in free space.
    pub(super) free: Vec<LineSection>,
    /// The positions at which something may block the way along the line.
    pub(super) breaks: Vec<f64>,
    /// The indices in `free` of the free triangles, by their corners.
    by_corners: HashMap<[u64; 6], usize>,
}

/// Returns the mean of some points.
pub(crate) fn middle(points: &[Point]) -> Point {
    let part = 1.0 / points.len() as f64;
    let sum = |of: fn(&Point) -> f64| points.iter().map(|p| of(p) * part).sum();
    Point::new(sum(|p| p.x), sum(|p| p.y))
}

impl QueryLine {
    /// Returns the length of the line.
    pub(super) fn length(self) -> f64 {
        distance(self.from, self.to)
    }

    /// Returns the point at position `t`.
    pub(super) fn at(self, t: f64) -> Point {
        match t {
            0.0 => self.from,
            1.0 => self.to,
            t => Point::new(
                self.from.x + t * (self.to.x - self.from.x),
                self.from.y + t * (self.to.y - self.from.y),
            ),
        }
    }

    /// Returns how far the line's start and end are on the left of the directed line from `a` to
    /// `b`, multiplied by the distance of `a` and `b`.
    fn offsets(self, a: Point, b: Point) -> [f64; 2] {
        [self.from, self.to].map(|p| (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x))
    }

    /// Returns the position where the line crosses the line through two points. The order of the
    /// points does not matter.
    pub(super) fn crossing(self, a: Point, b: Point) -> Option<f64> {
        let (a, b) = if a.lex_cmp(b).is_lt() { (a, b) } else { (b, a) };
        let [start, end] = self.offsets(a, b);
        let t = start / (start - end);
        t.is_finite().then_some(t)
    }

    /// Returns the position of a point on the line.
    fn parameter(self, p: Point) -> f64 {
        let (dx, dy) = (self.to.x - self.from.x, self.to.y - self.from.y);
        if p == self.from {
            0.0
        } else if p == self.to {
            1.0
        } else {
            ((p.x - self.from.x) * dx + (p.y - self.from.y) * dy) / (dx * dx + dy * dy)
        }
    }

    /// Returns the part of a range where the line is not on the right (`is_left`), or not on the
    /// left, of the ray from `from` through `through`.
    pub(super) fn clip(self, [low, high]: [f64; 2], from: Point, through: Point, is_left: bool) -> Option<[f64; 2]> {
        let sign = if is_left { 1.0 } else { -1.0 };
        let [start, end] = self.offsets(from, through).map(|offset| sign * offset);
        let reach = |p: Point| (p.x - from.x).abs() + (p.y - from.y).abs();
        // A point that is nearly on the ray counts as on it, because to first order the length of a
        // path does not change there.
        let slack = 1e-14 * reach(through) * (reach(self.from) + reach(self.to));
        let at = |t: f64| start + t * (end - start);
        match (at(low) >= -slack, at(high) >= -slack) {
            (true, true) => Some([low, high]),
            (false, false) => None,
            (is_first, _) => {
                let t = self.crossing(from, through)?.clamp(low, high);
                Some(if is_first { [low, t] } else { [t, high] })
            }
        }
    }

    /// Determines the sections of the line.
    pub(super) async fn pass(self, tiles: &mut Tiles) -> Result<LineSections, QueryError> {
        let mut sections = LineSections::default();
        let outside_is_free = tiles.outside_is_free();
        let mut hull = [f64::INFINITY, f64::NEG_INFINITY];
        let ids: Vec<TileId> = tiles
            .ids_where(|bounds| segment_meets([self.from, self.to], bounds))
            .await?;
        for id in ids {
            let tile = tiles.get(id).await?;
            for triangle in tile.owned_triangles() {
                self.pass_triangle(&tile, triangle, outside_is_free, &mut sections, &mut hull);
            }
        }
        if outside_is_free {
            let whole = hull[0] > hull[1];
            let (first, last) = if whole { (1.0, 1.0) } else { (hull[0], hull[1]) };
            for range in [[0.0, first.min(1.0)], [last.max(0.0), 1.0]] {
                if range[0] < range[1] {
                    sections.push(range, None, None);
                }
            }
            sections.breaks.extend(hull);
        }
        sections.breaks.retain(|t| (0.0..=1.0).contains(t));
        sections.breaks.sort_by(f64::total_cmp);
        sections.breaks.dedup();
        Ok(sections)
    }

    /// Adds the section in a triangle, if the line passes it.
    fn pass_triangle(
        self,
        tile: &Tile,
        triangle: TriangleId,
        outside_is_free: bool,
        sections: &mut LineSections,
        hull: &mut [f64; 2],
    ) {
        let corners = tile.triangle_points(triangle);
        let turns = corners.map(|corner| orient2d(self.from, self.to, corner));
        let is_on = turns.map(|turn| turn == Orientation::Collinear);
        let mut parameters = Vec::new();
        for s in 0..3 {
            let (e, half_edge) = ((s + 1) % 3, HalfEdge::new(triangle, s as u32));
            if is_on[s] {
                parameters.push(self.parameter(corners[s]));
            }
            let crosses = !is_on[s] && !is_on[e] && turns[s] != turns[e];
            if crosses && let Some(t) = self.crossing(corners[s], corners[e]) {
                parameters.push(t);
                if tile.is_constraint(half_edge) {
                    sections.breaks.push(t);
                }
            } else if tile.is_constraint(half_edge) {
                let ends = [s, e].into_iter().filter(|&end| is_on[end]);
                sections.breaks.extend(ends.map(|end| self.parameter(corners[end])));
            }
        }
        let Some(low) = parameters.iter().copied().reduce(f64::min) else {
            return;
        };
        let high = parameters.iter().copied().fold(low, f64::max);
        *hull = [hull[0].min(low), hull[1].max(high)];
        let range = [low.max(0.0), high.min(1.0)];
        if range[0] >= range[1] {
            return;
        }
        // Along an edge the line passes the space on both sides of it.
        let along = (0..3).find(|&s| is_on[s] && is_on[(s + 1) % 3]);
        let inside = middle(&corners);
        let is_free = !tile.is_hole(triangle);
        if is_free {
            sections.push(range, Some(corners), along.map(|_| inside));
        }
        if let Some(s) = along {
            let half_edge = HalfEdge::new(triangle, s as u32);
            let is_on_hull = tile.twin(half_edge) == Twin::Hull;
            if is_on_hull && outside_is_free {
                let edge = middle(&[half_edge, half_edge.next()].map(|half_edge| tile.point(tile.origin(half_edge))));
                let mirrored = Point::new(2.0 * edge.x - inside.x, 2.0 * edge.y - inside.y);
                sections.push(range, None, Some(mirrored));
            }
        }
    }
}

impl LineSections {
    fn push(&mut self, range: [f64; 2], triangle: Option<[Point; 3]>, beside: Option<Point>) {
        if let Some(corners) = triangle {
            self.by_corners.insert(key(corners), self.free.len());
        }
        self.free.push(LineSection {
            range,
            triangle,
            beside,
        });
    }

    /// Returns the range of the line in a free triangle.
    pub(super) fn range_of(&self, corners: [Point; 3]) -> Option<[f64; 2]> {
        let index = self.by_corners.get(&key(corners))?;
        Some(self.free[*index].range)
    }

    /// Returns the ranges outside the hull.
    pub(super) fn outside(&self) -> impl Iterator<Item = [f64; 2]> {
        let outside = self.free.iter().filter(|section| section.triangle.is_none());
        outside.map(|section| section.range)
    }

    /// Returns the maximal ranges in free space, in order.
    pub(super) fn free_ranges(&self) -> Vec<[f64; 2]> {
        let mut ranges: Vec<[f64; 2]> = self.free.iter().map(|section| section.range).collect();
        ranges.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        let mut free_ranges: Vec<[f64; 2]> = Vec::new();
        for range in ranges {
            match free_ranges.last_mut() {
                Some(run) if range[0] <= run[1] => run[1] = run[1].max(range[1]),
                _ => free_ranges.push(range),
            }
        }
        free_ranges
    }

    /// Returns the free ranges, cut where something may block the way.
    pub(super) fn free_intervals(&self) -> Vec<[f64; 2]> {
        let mut free_intervals = Vec::new();
        for [mut low, high] in self.free_ranges() {
            for &t in &self.breaks {
                if low < t && t < high {
                    free_intervals.push([low, t]);
                    low = t;
                }
            }
            free_intervals.push([low, high]);
        }
        free_intervals
    }
}
