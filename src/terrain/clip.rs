//! Polygons to which exports and volumes are limited.
//!
//! In: the edges of polygons, their interiors on the left. Out: which points, edges and triangles
//! meet the interior. Whether a triangle's interior meets that of a polygon is exact, but for slivers
//! whose centroid rounds to the other side: either an edge of a polygon passes through the triangle
//! (exact predicates), or the triangle is on one side, which its centroid tells.

use super::strips::Strips;
use crate::geometry::{Orientation, Point, Rect, orient2d, segments_cross};

/// Polygons to which an export or a volume is limited, in memory.
///
/// ```
/// use delaunay_tiles::terrain::Clip;
/// use delaunay_tiles::geometry::Point;
///
/// let corners = [(0.0, 0.0), (4.0, 0.0), (0.0, 4.0)].map(|(x, y)| Point::new(x, y));
/// let clip = Clip::new((0..3).map(|i| [corners[i], corners[(i + 1) % 3]]).collect());
/// assert!(clip.covers(Point::new(1.0, 1.0)) && !clip.covers(Point::new(3.0, 3.0)));
/// ```
#[derive(Debug)]
pub struct Clip {
    edges: Strips,
}

/// Where the interior of a triangle, or a line, lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// In no polygon.
    Outside,
    /// In polygons.
    Inside,
    /// An edge of a polygon passes through it.
    Both,
}

impl Clip {
    /// The largest number of edges, which together take about 300 MB.
    pub const MAX_EDGES: usize = Strips::MAX;

    /// The bytes of memory per edge that [`new`](Self::new) and the list of edges given to it take, at
    /// most.
    pub const BYTES_PER_EDGE: u64 = 144;

    /// Creates the polygons from their edges, in any order. The interior is on the left of the edges:
    /// outer rings are counter-clockwise and inner ones clockwise, as
    /// [`SegmentSource::open_obstacles`](crate::input::SegmentSource::open_obstacles) reads them.
    ///
    /// Two edges between the same points in opposite directions cancel out, so that a ring without area
    /// covers nothing, not even its own points.
    ///
    /// # Panics
    /// Panics if there are more than [`MAX_EDGES`](Self::MAX_EDGES).
    #[must_use]
    pub fn new(mut edges: Vec<[Point; 2]>) -> Self {
        cancel_opposites(&mut edges);
        Self {
            edges: Strips::new(edges),
        }
    }

    /// Returns the rectangle around all polygons.
    pub(crate) fn bounds(&self) -> Rect {
        self.edges.bounds()
    }

    /// Returns the number of edges.
    pub(crate) fn edge_count(&self) -> u64 {
        self.edges.segment_count()
    }

    /// Returns the bytes of memory that the polygons take.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.edges.bytes()
    }

    /// Returns the edges whose bounding boxes meet a rectangle.
    pub(crate) fn edges_near(&self, rect: Rect) -> Vec<[Point; 2]> {
        let numbers = self.edges.near(rect).into_iter();
        numbers.map(|number| self.edges.segment(number)).collect()
    }

    /// Returns whether the rectangle around all polygons meets another one.
    pub(crate) fn reaches(&self, bounds: Rect) -> bool {
        self.bounds().intersects(bounds)
    }

    /// Returns the edges that may have a y from `low` to `high`; those of a great height several times, if
    /// `low` is not `high`.
    pub(crate) fn edges_between(&self, low: f64, high: f64) -> impl Iterator<Item = [Point; 2]> {
        self.edges.between(low, high).map(|(_, edge)| edge)
    }

    /// Returns the part of the winding number of points at `y` and right of `x` that comes from edges
    /// left of `x`. The lower end of an edge belongs to it, and the upper one does not.
    pub(crate) fn winding_left_of(&self, x: f64, y: f64) -> i64 {
        if y < self.bounds().min_y || y > self.bounds().max_y {
            return 0;
        }
        // At one y, each edge comes once.
        let edges = self.edges.between(y, y).filter(|(_, [a, b])| a.x.max(b.x) < x);
        edges
            .map(|(_, [a, b])| i64::from(b.y <= y && y < a.y) - i64::from(a.y <= y && y < b.y))
            .sum()
    }

    /// Returns whether a point is inside a polygon or on its boundary. Exact.
    #[must_use]
    pub fn covers(&self, p: Point) -> bool {
        if !self.edges.bounds().contains(p) {
            return false;
        }
        let mut winding = 0;
        for (_, edge) in self.edges.between(p.y, p.y) {
            match Passing::of(edge, p) {
                Passing::Through => return true,
                Passing::Right(turn) => winding += i64::from(turn),
                Passing::Elsewhere => {}
            }
        }
        winding > 0
    }

    /// Returns whether the interior of a triangle meets the interior of a polygon. The corners are
    /// counter-clockwise.
    pub(crate) fn meets_triangle(&self, corners: [Point; 3]) -> bool {
        self.side(corners) != Side::Outside
    }

    /// Returns on which side of the boundary of the polygons the interior of a triangle lies. The
    /// corners are counter-clockwise.
    pub(crate) fn side(&self, mut corners: [Point; 3]) -> Side {
        let around = Rect::around(corners);
        if !self.edges.bounds().intersects(around) {
            return Side::Outside;
        }
        let passes = |[p, q]: [Point; 2]| Rect::around([p, q]).intersects(around) && passes_through([p, q], corners);
        if self
            .edges
            .between(around.min_y, around.max_y)
            .any(|(_, edge)| passes(edge))
        {
            return Side::Both;
        }
        // The centroid must not depend on which corner comes first.
        corners.sort_by(|a, b| a.lex_cmp(*b));
        let [a, b, c] = corners.map(|p| [p.x / 3.0, p.y / 3.0]);
        match self.covers(Point::new(a[0] + b[0] + c[0], a[1] + b[1] + c[1])) {
            true => Side::Inside,
            false => Side::Outside,
        }
    }

    /// Returns whether an edge crosses the boundary of a polygon, or has an end or its midpoint in a
    /// polygon.
    pub(crate) fn meets_edge(&self, [a, b]: [Point; 2]) -> bool {
        let middle = Point::new(a.x / 2.0 + b.x / 2.0, a.y / 2.0 + b.y / 2.0);
        if [a, b, middle].into_iter().any(|p| self.covers(p)) {
            return true;
        }
        let around = Rect::around([a, b]);
        self.edges.bounds().intersects(around)
            && self
                .edges
                .between(a.y, b.y)
                .any(|(_, [c, d])| segments_cross(a, b, c, d))
    }
}

/// How an edge of a polygon passes a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Passing {
    /// The point is on it.
    Through,
    /// It passes the point on the right, at the same y, and changes the point's winding number by this.
    Right(i32),
    /// It does not change the winding number.
    Elsewhere,
}

impl Passing {
    /// Exact.
    pub(crate) fn of([a, b]: [Point; 2], p: Point) -> Self {
        let (upwards, downwards) = (a.y <= p.y && p.y < b.y, b.y <= p.y && p.y < a.y);
        let in_box = Rect::around([a, b]).contains(p);
        if !(upwards || downwards || in_box) {
            return Self::Elsewhere;
        }
        match orient2d(a, b, p) {
            Orientation::Collinear if in_box => Self::Through,
            Orientation::CounterClockwise if upwards => Self::Right(1),
            Orientation::Clockwise if downwards => Self::Right(-1),
            _ => Self::Elsewhere,
        }
    }
}

/// Removes pairs of edges between the same points in opposite directions. Neither side of them is the
/// inside more than the other, so they change no winding number.
fn cancel_opposites(edges: &mut Vec<[Point; 2]>) {
    let is_forward = |edge: &[Point; 2]| edge[0].lex_cmp(edge[1]).is_lt();
    let key = |edge: &[Point; 2]| if is_forward(edge) { *edge } else { [edge[1], edge[0]] };
    edges.sort_unstable_by(|one, other| {
        let ([a, b], [c, d]) = (key(one), key(other));
        a.lex_cmp(c).then(b.lex_cmp(d))
    });
    let (mut kept, mut next) = (0, 0);
    while let Some(&edge) = edges.get(next) {
        let same = edges[next..].iter().take_while(|other| key(other) == key(&edge));
        let (forward, all) = same.fold((0, 0), |(forward, all), other| {
            (forward + usize::from(is_forward(other)), all + 1)
        });
        next += all;
        let [a, b] = key(&edge);
        let (backward, left) = (all - forward, if forward * 2 >= all { [a, b] } else { [b, a] });
        for _ in 0..forward.abs_diff(backward) {
            edges[kept] = left;
            kept += 1;
        }
    }
    edges.truncate(kept);
    edges.shrink_to_fit();
}

/// Returns whether a segment meets the interior of a triangle whose corners are counter-clockwise:
/// no line along an edge of either separates them.
fn passes_through([p, q]: [Point; 2], corners: [Point; 3]) -> bool {
    let sides = corners.map(|corner| orient2d(p, q, corner));
    let on_both = [Orientation::CounterClockwise, Orientation::Clockwise];
    on_both.into_iter().all(|side| sides.contains(&side))
        && (0..3).all(|i| {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            [p, q]
                .into_iter()
                .any(|end| orient2d(a, b, end) == Orientation::CounterClockwise)
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(corners: &[(f64, f64)]) -> Vec<[Point; 2]> {
        let corner = |i: usize| Point::new(corners[i % corners.len()].0, corners[i % corners.len()].1);
        (0..corners.len()).map(|i| [corner(i), corner(i + 1)]).collect()
    }

    fn triangle(corners: [(f64, f64); 3]) -> [Point; 3] {
        corners.map(|(x, y)| Point::new(x, y))
    }

    #[test]
    fn triangles_that_only_touch_a_polygon_do_not_meet_it() {
        // A square with a square hole.
        let mut edges = ring(&[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]);
        edges.extend(ring(&[(4.0, 4.0), (4.0, 6.0), (6.0, 6.0), (6.0, 4.0)]));
        let clip = Clip::new(edges);
        for (corners, meets) in [
            ([(1.0, 1.0), (2.0, 1.0), (1.0, 2.0)], true),
            ([(-9.0, -9.0), (40.0, -9.0), (-9.0, 40.0)], true),
            ([(-1.0, 5.0), (1.0, 5.0), (1.0, 6.0)], true),
            ([(10.0, 0.0), (12.0, 0.0), (10.0, 10.0)], false),
            ([(10.0, 10.0), (12.0, 10.0), (10.0, 12.0)], false),
            ([(4.0, 4.0), (6.0, 4.0), (6.0, 6.0)], false),
            ([(4.0, 4.0), (6.0, 4.0), (6.5, 6.0)], true),
            ([(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)], true),
            ([(20.0, 1.0), (21.0, 1.0), (20.0, 2.0)], false),
        ] {
            for shift in 0..3 {
                let mut corners = triangle(corners);
                corners.rotate_left(shift);
                assert_eq!(clip.meets_triangle(corners), meets, "{corners:?}");
            }
        }
        for (p, inside) in [
            ((0.0, 0.0), true),
            ((5.0, 5.0), false),
            ((4.0, 5.0), true),
            ((10.0, 10.5), false),
        ] {
            assert_eq!(clip.covers(Point::new(p.0, p.1)), inside, "{p:?}");
        }
        for (ends, meets) in [
            ([(-1.0, 5.0), (11.0, 5.0)], true),
            ([(4.5, 5.0), (5.5, 5.0)], false),
            ([(4.5, 5.0), (6.5, 5.0)], true),
            ([(11.0, 0.0), (11.0, 9.0)], false),
        ] {
            assert_eq!(clip.meets_edge(ends.map(|(x, y)| Point::new(x, y))), meets, "{ends:?}");
        }
    }

    /// Overlapping polygons of many edges, against the sum over all edges.
    #[test]
    fn strips_do_not_change_the_answer() {
        let circle = |x: f64, steps: u32| {
            let at = |i: u32| f64::from(i) / f64::from(steps) * std::f64::consts::TAU;
            let corners: Vec<_> = (0..steps).map(|i| (x + at(i).cos(), at(i).sin())).collect();
            ring(&corners)
        };
        let edges = [circle(0.0, 300), circle(1.0, 70), circle(5.0, 3)].concat();
        let clip = Clip::new(edges.clone());
        assert!(clip.edges.count() > 100 && clip.bytes() < 150 * edges.len() as u64);
        let mut found = 0;
        for i in 0..5000u32 {
            let p = Point::new(f64::from(i % 89) / 10.0 - 1.5, f64::from(i % 57) / 20.0 - 1.4);
            let inside = [(0.0, 300), (1.0, 70), (5.0, 3)].into_iter().any(|(x, steps)| {
                let ring = circle(x, steps);
                ring.iter().all(|&[a, b]| orient2d(a, b, p) != Orientation::Clockwise)
            });
            assert_eq!(clip.covers(p), inside, "{p:?}");
            found += u32::from(inside);
        }
        assert!((500..4500).contains(&found));
    }

    #[test]
    fn rings_without_area_cover_nothing_and_borders_between_polygons_are_inside() {
        let line = [(1.0, 1.0), (3.0, 1.0), (2.0, 1.0)].map(|(x, y)| Point::new(x, y));
        let mut edges: Vec<_> = (0..3).map(|i| [line[i], line[(i + 1) % 3]]).collect();
        edges.extend(edges.clone().into_iter().map(|[a, b]| [b, a]));
        let nothing = Clip::new(edges.clone());
        let around = triangle([(0.0, 0.0), (9.0, 0.0), (0.0, 9.0)]);
        assert!(!nothing.covers(line[2]) && !nothing.meets_triangle(around));
        assert!(!nothing.meets_edge([Point::new(2.0, 0.0), Point::new(2.0, 2.0)]));
        // Two squares side by side, one of them twice, and the line in one of them.
        for x in [0.0, 0.0, 10.0] {
            edges.extend(ring(&[(x, 0.0), (x + 10.0, 0.0), (x + 10.0, 10.0), (x, 10.0)]));
        }
        let clip = Clip::new(edges);
        assert_eq!(clip.edge_count(), 10);
        for (x, covered) in [(0.0, true), (2.0, true), (10.0, true), (20.0, true), (20.5, false)] {
            assert_eq!(clip.covers(Point::new(x, 1.0)), covered, "{x}");
        }
        assert!(clip.meets_triangle(triangle([(9.0, 4.0), (11.0, 4.0), (10.0, 5.0)])));
    }

    #[test]
    fn polygons_without_edges_or_height_cover_nothing() {
        for edges in [vec![], ring(&[(0.0, 1.0), (2.0, 1.0)])] {
            assert!(!Clip::new(edges).covers(Point::new(1.0, 2.0)));
        }
        assert!(!Clip::new(vec![]).meets_triangle(triangle([(0.0, 0.0), (2.0, 0.0), (1.0, 2.0)])));
    }
}
