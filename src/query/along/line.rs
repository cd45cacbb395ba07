//! The ground along a straight line: which triangles it passes, and where.
//!
//! Places on the line are numbers from 0 at its start to 1 at its end. One is computed from nothing but the line and the edge that it crosses,
//! or the vertex that it passes through, so that neighbouring triangles agree about it to the last bit. Which triangles
//! the line passes is decided by exact predicates.

use foldhash::HashMap;

use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, orient2d, segment_meets};
use crate::mesh::Twin;
use crate::query::answer::distance;
use crate::query::request::{QueryError, Tiles, key};
use crate::store::{Tile, TileId};

/// A line from a point to another one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub(super) from: Point,
    pub(super) to: Point,
}

/// What the line passes: a closed triangle, or what lies outside the hull.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// From where to where.
    pub(super) range: [f64; 2],
    /// None: it lies outside.
    pub(super) triangle: Option<[Point; 3]>,
    /// For a piece along an edge: a point on that side of it.
    pub(super) beside: Option<Point>,
}

/// All that the line passes.
#[derive(Debug, Default)]
pub(crate) struct Passed {
    /// Where one may be.
    pub(super) free: Vec<Piece>,
    /// Places at which something may block the way along the line.
    pub(super) breaks: Vec<f64>,
    /// The free triangles by their corners, with their places in `free`.
    by_corners: HashMap<[u64; 6], usize>,
}

/// The mean of some points.
pub(crate) fn middle(points: &[Point]) -> Point {
    let part = 1.0 / points.len() as f64;
    let sum = |of: fn(&Point) -> f64| points.iter().map(|p| of(p) * part).sum();
    Point::new(sum(|p| p.x), sum(|p| p.y))
}

impl Line {
    /// How long it is.
    pub(super) fn length(self) -> f64 {
        distance(self.from, self.to)
    }

    /// The point at a place.
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

    /// How far a point is on the left of the directed line through two others, at the line's start and at its end, times
    /// the distance of these two.
    fn offsets(self, a: Point, b: Point) -> [f64; 2] {
        [self.from, self.to].map(|p| (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x))
    }

    /// Where the line crosses that through two points; it does not matter which of them is named first.
    pub(super) fn crossing(self, a: Point, b: Point) -> Option<f64> {
        let (a, b) = if a.lex_cmp(b).is_lt() { (a, b) } else { (b, a) };
        let [start, end] = self.offsets(a, b);
        let t = start / (start - end);
        t.is_finite().then_some(t)
    }

    /// The place of a point on the line.
    fn place(self, p: Point) -> f64 {
        let (dx, dy) = (self.to.x - self.from.x, self.to.y - self.from.y);
        if p == self.from {
            0.0
        } else if p == self.to {
            1.0
        } else {
            ((p.x - self.from.x) * dx + (p.y - self.from.y) * dy) / (dx * dx + dy * dy)
        }
    }

    /// The part of a range where the line is not on the right, or not on the left, of the ray from a point through another one.
    pub(super) fn clip(self, [low, high]: [f64; 2], from: Point, through: Point, is_left: bool) -> Option<[f64; 2]> {
        let sign = if is_left { 1.0 } else { -1.0 };
        let [start, end] = self.offsets(from, through).map(|offset| sign * offset);
        let reach = |p: Point| (p.x - from.x).abs() + (p.y - from.y).abs();
        // What is as good as on the ray counts as not beyond it: how long a way is does not change there to the first order.
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

    /// Finds out what the line passes.
    pub(super) async fn pass(self, tiles: &mut Tiles) -> Result<Passed, QueryError> {
        let mut passed = Passed::default();
        let outside_is_free = tiles.outside_is_free();
        let mut hull = [f64::INFINITY, f64::NEG_INFINITY];
        let ids: Vec<TileId> = tiles.ids_where(|bounds| segment_meets([self.from, self.to], bounds));
        for id in ids {
            let tile = tiles.get(id).await?;
            for triangle in tile.owned_triangles() {
                self.pass_triangle(&tile, triangle, outside_is_free, &mut passed, &mut hull);
            }
        }
        if outside_is_free {
            let whole = hull[0] > hull[1];
            let (first, last) = if whole { (1.0, 1.0) } else { (hull[0], hull[1]) };
            for range in [[0.0, first.min(1.0)], [last.max(0.0), 1.0]] {
                if range[0] < range[1] {
                    passed.push(range, None, None);
                }
            }
            passed.breaks.extend(hull);
        }
        passed.breaks.retain(|t| (0.0..=1.0).contains(t));
        passed.breaks.sort_by(f64::total_cmp);
        passed.breaks.dedup();
        Ok(passed)
    }

    /// Takes a triangle, if the line passes it.
    fn pass_triangle(
        self,
        tile: &Tile,
        triangle: TriangleId,
        outside_is_free: bool,
        passed: &mut Passed,
        hull: &mut [f64; 2],
    ) {
        let corners = tile.triangle_points(triangle);
        let turns = corners.map(|corner| orient2d(self.from, self.to, corner));
        let is_on = turns.map(|turn| turn == Orientation::Collinear);
        let mut places = Vec::new();
        for s in 0..3 {
            let (e, side) = ((s + 1) % 3, HalfEdge::new(triangle, s as u32));
            if is_on[s] {
                places.push(self.place(corners[s]));
            }
            let crosses = !is_on[s] && !is_on[e] && turns[s] != turns[e];
            if crosses && let Some(t) = self.crossing(corners[s], corners[e]) {
                places.push(t);
                if tile.is_constraint(side) {
                    passed.breaks.push(t);
                }
            } else if tile.is_constraint(side) {
                let ends = [s, e].into_iter().filter(|&end| is_on[end]);
                passed.breaks.extend(ends.map(|end| self.place(corners[end])));
            }
        }
        let Some(low) = places.iter().copied().reduce(f64::min) else {
            return;
        };
        let high = places.iter().copied().fold(low, f64::max);
        *hull = [hull[0].min(low), hull[1].max(high)];
        let range = [low.max(0.0), high.min(1.0)];
        if range[0] >= range[1] {
            return;
        }
        // Along an edge the line passes what lies on both sides of it.
        let along = (0..3).find(|&s| is_on[s] && is_on[(s + 1) % 3]);
        let inside = middle(&corners);
        let is_free = !tile.is_hole(triangle);
        if is_free {
            passed.push(range, Some(corners), along.map(|_| inside));
        }
        if let Some(s) = along {
            let side = HalfEdge::new(triangle, s as u32);
            let is_on_hull = tile.twin(side) == Twin::Hull;
            if is_on_hull && outside_is_free {
                let edge = middle(&[side, side.next()].map(|side| tile.point(tile.origin(side))));
                let mirrored = Point::new(2.0 * edge.x - inside.x, 2.0 * edge.y - inside.y);
                passed.push(range, None, Some(mirrored));
            }
        }
    }
}

impl Passed {
    fn push(&mut self, range: [f64; 2], triangle: Option<[Point; 3]>, beside: Option<Point>) {
        if let Some(corners) = triangle {
            self.by_corners.insert(key(corners), self.free.len());
        }
        self.free.push(Piece {
            range,
            triangle,
            beside,
        });
    }

    /// The range of a free triangle that the line passes.
    pub(super) fn range_of(&self, corners: [Point; 3]) -> Option<[f64; 2]> {
        let place = self.by_corners.get(&key(corners))?;
        Some(self.free[*place].range)
    }

    /// The ranges outside the hull.
    pub(super) fn outside(&self) -> impl Iterator<Item = [f64; 2]> {
        let outside = self.free.iter().filter(|piece| piece.triangle.is_none());
        outside.map(|piece| piece.range)
    }

    /// The ranges where one may be, as long as they can be, in order.
    pub(super) fn runs(&self) -> Vec<[f64; 2]> {
        let mut ranges: Vec<[f64; 2]> = self.free.iter().map(|piece| piece.range).collect();
        ranges.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        let mut runs: Vec<[f64; 2]> = Vec::new();
        for range in ranges {
            match runs.last_mut() {
                Some(run) if range[0] <= run[1] => run[1] = run[1].max(range[1]),
                _ => runs.push(range),
            }
        }
        runs
    }

    /// The runs, cut where something may block the way.
    pub(super) fn stretches(&self) -> Vec<[f64; 2]> {
        let mut stretches = Vec::new();
        for [mut low, high] in self.runs() {
            for &t in &self.breaks {
                if low < t && t < high {
                    stretches.push([low, t]);
                    low = t;
                }
            }
            stretches.push([low, high]);
        }
        stretches
    }
}
