//! The pieces of an area: what roots see of convex polygons within their reach.

use std::f64::consts::{PI, TAU};

use crate::geometry::{Orientation, Point, orient2d};
use crate::query::answer::distance;
use crate::query::wavefront::{HalfPlane, RegionShape, VisibleRegion};

/// A piece of the area within a walking distance: the part of a convex polygon within reach of a
/// point that sees all of the polygon.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct AreaPiece {
    /// The point that sees the polygon: the start, or a point round which paths bend.
    pub root: Point,
    /// The walking distance of `root`.
    pub walked: f64,
    /// The distance that is left at `root`.
    pub reach: f64,
    /// The polygon, counter-clockwise. Its corners are rounded unless they are vertices.
    pub corners: Vec<Point>,
}

impl AreaPiece {
    /// Returns whether a point is in the closed piece, except for rounding of the corners.
    #[must_use]
    pub fn contains(&self, point: Point) -> bool {
        let around = self.corners.iter().zip(self.corners.iter().cycle().skip(1));
        distance(self.root, point) <= self.reach
            && around
                .into_iter()
                .all(|(&a, &b)| orient2d(a, b, point) != Orientation::Clockwise)
    }

    /// Returns the outline, counter-clockwise, without repeating its first point at the end. Arcs
    /// become chords inside the piece, which are nowhere farther from the arc than `tolerance`
    /// times its radius: 1e-4 makes 223 chords of a circle. The outline is empty if nothing
    /// remains.
    ///
    /// A tolerance below 1e-9 counts as 1e-9.
    #[must_use]
    pub fn outline(&self, tolerance: f64) -> Vec<Point> {
        let step = 2.0 * (1.0 - tolerance.clamp(1e-9, 0.5)).acos();
        let chords: Vec<[Point; 2]> = self.chords().collect();
        let mut outline = Vec::new();
        if chords.is_empty() {
            if self.contains(self.root) && self.reach > 0.0 {
                self.arc(0.0, TAU, step, &mut outline);
                outline.push(Point::new(self.root.x + self.reach, self.root.y));
            }
            return outline;
        }
        for (index, [from, to]) in chords.iter().copied().enumerate() {
            if outline.last() != Some(&from) {
                outline.push(from);
            }
            if to != from {
                outline.push(to);
            }
            let next = chords[(index + 1) % chords.len()][0];
            if next != to {
                let [start, end] = [to, next].map(|p| (p.y - self.root.y).atan2(p.x - self.root.x));
                let mut turn = (end - start).rem_euclid(TAU);
                // A turn that is nearly zero must not count as a full turn.
                if turn > TAU - 1e-9 && distance(to, next) <= 1e-9 * self.reach {
                    turn = 0.0;
                }
                self.arc(start, turn, step, &mut outline);
            }
        }
        while outline.len() > 1 && outline.first() == outline.last() {
            outline.pop();
        }
        if outline.len() < 3 {
            outline.clear();
        }
        outline
    }

    /// Appends the points of an arc of `turn` radians, counter-clockwise, at multiples of a fixed
    /// angle of at most `step`. The arcs of all roots have these angles: parallel chords cross about
    /// as often as the arcs, and others far more often.
    fn arc(&self, start: f64, turn: f64, step: f64, outline: &mut Vec<Point>) {
        let count = (TAU / step).ceil();
        let angle = TAU / count;
        let (first, end) = ((start / angle).floor() as i64 + 1, start + turn);
        for number in (first..).take_while(|&number| number as f64 * angle < end) {
            let (sin, cos) = ((number as f64).rem_euclid(count) * angle).sin_cos();
            outline.push(Point::new(
                self.root.x + self.reach * cos,
                self.root.y + self.reach * sin,
            ));
        }
    }

    /// Returns the parts of the polygon's edges that are within reach.
    fn chords(&self) -> impl Iterator<Item = [Point; 2]> {
        let around = self.corners.iter().zip(self.corners.iter().cycle().skip(1));
        around.filter_map(|(&a, &b)| self.chord(a, b))
    }

    /// Returns the part of an edge that is within reach.
    fn chord(&self, a: Point, b: Point) -> Option<[Point; 2]> {
        let is_near = [a, b].map(|p| distance(self.root, p) <= self.reach);
        if is_near == [true; 2] {
            return Some([a, b]);
        }
        // The neighbouring piece has the edge in the opposite direction.
        let (from, to) = if a.lex_cmp(b).is_lt() { (a, b) } else { (b, a) };
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        let (px, py) = (self.root.x - from.x, self.root.y - from.y);
        let square = dx * dx + dy * dy;
        let foot = (px * dx + py * dy) / square;
        let height = (px * dy - py * dx) / square.sqrt();
        let half = ((self.reach - height.abs()) * (self.reach + height.abs()) / square).sqrt();
        let is_beside = foot + half <= 0.0 || foot - half >= 1.0;
        if half.is_nan() || (is_near == [false; 2] && is_beside) {
            return is_near
                .contains(&true)
                .then(|| if is_near[0] { [a, a] } else { [b, b] });
        }
        let at = |t: f64| match t {
            t if t <= 0.0 => from,
            t if t >= 1.0 => to,
            t => Point::new(from.x + t * dx, from.y + t * dy),
        };
        let ends = [at(foot - half), at(foot + half)];
        let [low, high] = if from == a { ends } else { [ends[1], ends[0]] };
        Some([if is_near[0] { a } else { low }, if is_near[1] { b } else { high }])
    }

    /// Returns the piece of a region.
    pub(super) fn of(region: VisibleRegion, root: Point, walked: f64, radius: f64) -> Option<Self> {
        let reach = radius - walked;
        let corners = match region.shape {
            RegionShape::Triangle { corners, between } => cut(corners.to_vec(), root, between),
            RegionShape::HalfPlane { half_plane, except } => region_in_half_plane(root, half_plane, except, reach),
            RegionShape::BehindHullEdge { edge, between } => region_behind_edge(root, edge, between, reach),
        };
        let this = Self {
            root,
            walked,
            reach,
            corners,
        };
        let is_within_reach = reach > 0.0 && (this.chords().next().is_some() || this.contains(root));
        (this.corners.len() > 2 && is_within_reach).then_some(this)
    }
}

/// Clips a convex polygon to the part between two rays from a root.
fn cut(corners: Vec<Point>, root: Point, between: Option<[Point; 2]>) -> Vec<Point> {
    let Some([right, left]) = between else { return corners };
    let corners = cut_off(&corners, root, right, Orientation::Clockwise);
    cut_off(&corners, root, left, Orientation::CounterClockwise)
}

/// Removes from a convex polygon the part on the side `hidden` of the line from a root through
/// `via`.
fn cut_off(corners: &[Point], root: Point, via: Point, hidden: Orientation) -> Vec<Point> {
    let mut kept = Vec::new();
    for (index, &corner) in corners.iter().enumerate() {
        let next = corners[(index + 1) % corners.len()];
        let [turn, turn_next] = [corner, next].map(|p| orient2d(root, via, p));
        if turn != hidden {
            kept.push(corner);
        }
        if turn != turn_next && turn != Orientation::Collinear && turn_next != Orientation::Collinear {
            kept.push(crossing(root, via, corner, next));
        }
    }
    kept.dedup();
    kept
}

/// Returns the crossing of a ray and an edge. The order of the edge's ends does not matter.
fn crossing(root: Point, via: Point, a: Point, b: Point) -> Point {
    let (a, b) = if a.lex_cmp(b).is_lt() { (a, b) } else { (b, a) };
    let (rx, ry) = (via.x - root.x, via.y - root.y);
    let off = |p: Point| rx * (p.y - root.y) - ry * (p.x - root.x);
    let (from, to) = (off(a), off(b));
    let along = from / (from - to);
    if along.is_nan() {
        return a;
    }
    let along = along.clamp(0.0, 1.0);
    Point::new(a.x + along * (b.x - a.x), a.y + along * (b.y - a.y))
}

/// Returns the unit vector from one point to another.
fn direction(from: Point, to: Point) -> Point {
    let length = distance(from, to);
    Point::new((to.x - from.x) / length, (to.y - from.y) / length)
}

fn add(p: Point, v: Point, length: f64) -> Point {
    Point::new(p.x + length * v.x, p.y + length * v.y)
}

/// Returns a rectangle on one side of a line through a root that contains half a disc round the
/// root, without the part in the half-plane `except`.
fn region_in_half_plane(root: Point, half_plane: HalfPlane, except: Option<HalfPlane>, reach: f64) -> Vec<Point> {
    let mut along = direction(root, half_plane.towards);
    if !half_plane.is_left {
        along = Point::new(-along.x, -along.y);
    }
    let aside = Point::new(-along.y, along.x);
    let far = 1.5 * reach;
    let [back, front] = [add(root, along, -far), add(root, along, far)];
    let whole = vec![back, front, add(front, aside, far), add(back, aside, far)];
    match except {
        None => whole,
        Some(HalfPlane { towards, is_left: true }) => cut_off(&whole, root, towards, Orientation::CounterClockwise),
        Some(HalfPlane { towards, .. }) => cut_off(&whole, root, towards, Orientation::Clockwise),
    }
}

/// Returns a polygon of the space beyond an edge between two rays, as far as a root can reach.
fn region_behind_edge(root: Point, [right, left]: [Point; 2], rays: [Point; 2], reach: f64) -> Vec<Point> {
    let ends = [(rays[0], right), (rays[1], left)];
    let [right, left] = ends.map(|(via, end)| {
        if orient2d(root, via, end) == Orientation::Collinear {
            end
        } else {
            crossing(root, via, right, left)
        }
    });
    let [to_right, to_left] = [right, left].map(|hit| direction(root, hit));
    let far = 1.5 * reach.max(distance(root, right)).max(distance(root, left));
    let angle = (to_right.x * to_left.y - to_right.y * to_left.x)
        .atan2(to_right.x * to_left.x + to_right.y * to_left.y)
        .clamp(0.0, PI);
    let mut corners = vec![right, add(root, to_right, far)];
    // Three corners between the rays keep the polygon outside the disc. They are a third of the
    // angle apart, and farther out accordingly.
    let start = to_right.y.atan2(to_right.x);
    for region in [1.0, 3.0, 5.0] {
        let (sin, cos) = (start + angle * region / 6.0).sin_cos();
        corners.push(add(root, Point::new(cos, sin), far / (angle / 6.0).cos()));
    }
    corners.extend([add(root, to_left, far), left]);
    corners.dedup();
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(outline: &[Point]) -> f64 {
        let around = outline.iter().zip(outline.iter().cycle().skip(1));
        around.map(|(a, b)| 0.5 * (a.x * b.y - a.y * b.x)).sum()
    }

    fn piece(reach: f64, corners: &[[f64; 2]]) -> AreaPiece {
        AreaPiece {
            root: Point::new(0.0, 0.0),
            walked: 0.0,
            reach,
            corners: corners.iter().map(|&[x, y]| Point::new(x, y)).collect(),
        }
    }

    #[test]
    fn outlines_have_the_area_of_their_pieces() {
        let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let beside = [[1.0, -1.0], [2.0, -1.0], [2.0, 1.0], [1.0, 1.0]];
        // The area of a segment of a circle of radius r, cut off at distance 1.
        let cap = |r: f64| r * r * (1.0 / r).acos() - (r * r - 1.0).sqrt();
        for (reach, corners, expected) in [
            (0.5, square, PI / 4.0),
            (1.0, square, PI),
            (1.2, square, PI * 1.44 - 4.0 * cap(1.2)),
            (1.5, square, 4.0),
            (0.9, beside, 0.0),
            (1.3, beside, cap(1.3)),
            (3.0, beside, 2.0),
        ] {
            let found = area(&piece(reach, &corners).outline(1e-6));
            assert!(
                (found - expected).abs() <= 1e-5,
                "{reach} {corners:?}: {found}, not {expected}"
            );
            assert!(found <= expected + 1e-12);
        }
        let corner = piece(2.0, &[[0.0, 0.0], [9.0, 0.0], [0.0, 9.0]]);
        assert!((area(&corner.outline(1e-6)) - PI).abs() < 1e-5);
    }

    #[test]
    fn pieces_outside_the_hull_are_half_discs_or_sectors() {
        let (root, reach) = (Point::new(0.0, 0.0), 2.0);
        let towards = Point::new(3.0, 4.0);
        let cut = |is_left, except| AreaPiece {
            corners: region_in_half_plane(root, HalfPlane { towards, is_left }, except, reach),
            ..piece(reach, &[])
        };
        let half = |is_left| cut(is_left, None);
        let is_above = Point::new(-0.5, 0.5);
        assert!(half(true).contains(is_above) && !half(false).contains(is_above));
        assert!((area(&half(false).outline(1e-6)) - 2.0 * PI).abs() < 1e-5);
        let (towards, is_left) = (Point::new(1.0, 0.0), true);
        let rest = cut(false, Some(HalfPlane { towards, is_left }));
        let expected = 2.0 * PI - 2.0 * (4f64 / 3.0).atan();
        assert!((area(&rest.outline(1e-6)) - expected).abs() < 1e-5);
        let [right, left] = [Point::new(1.0, -1.0), Point::new(1.0, 1.0)];
        let sector = AreaPiece {
            corners: region_behind_edge(root, [right, left], [right, left], reach),
            ..piece(reach, &[])
        };
        let found = area(&sector.outline(1e-6));
        assert!((found - (PI - 1.0)).abs() < 1e-5, "{found}");
    }
}
