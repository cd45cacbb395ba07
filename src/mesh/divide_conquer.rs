//! The library's own kernel: divide and conquer over triangles.
//!
//! In: distinct points in any order. Out: the canonical Delaunay triangulation with adjacency and hull.
//!
//! Sources: Guibas and Stolfi, "Primitives for the manipulation of general subdivisions and the computation of Voronoi
//! diagrams" (1985) for the merge; Dwyer, "A faster divide-and-conquer algorithm for constructing Delaunay
//! triangulations" (1987) for cuts along both axes; Shewchuk, "Triangle" (1996) for triangles with ghosts in place of
//! quad-edges. Departures: cells are halved in space, not by count, so that one sort by Morton keys finds
//! all the cuts and no medians are selected; and the circle test is the perturbed one, so that the result is canonical
//! without flips afterwards.
//!
//! Every hull edge u → v has a ghost triangle (v, u, ∞) on its outer side. So a set of two points, or a chain on one
//! line, is a ring of ghosts like any other hull, and n points always have 2n − 2 triangles, ghosts included: the merge
//! turns ghosts into triangles and back, and makes two new ones (below and above).

use super::{Engine, NONE, Triangulation};
use crate::geometry::{MortonSquare, Orientation, Point, Rect, in_circle, orient2d};

/// The corner of ghosts: the point at infinity.
const GHOST: u32 = u32::MAX;

/// A directed side of a triangle: `triangle << 2 | corner that it starts at`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Side(u32);

impl Side {
    const UNSET: Self = Self(u32::MAX);

    fn new(triangle: u32, corner: u32) -> Self {
        Self(triangle << 2 | corner)
    }

    fn triangle(self) -> usize {
        (self.0 >> 2) as usize
    }

    fn corner(self) -> usize {
        (self.0 & 3) as usize
    }

    fn next(self) -> Self {
        Self(if self.corner() == 2 { self.0 - 2 } else { self.0 + 1 })
    }

    fn prev(self) -> Self {
        Self(if self.corner() == 0 { self.0 + 2 } else { self.0 - 1 })
    }
}

/// The hull of a part: the ghosts of the hull edges that leave its lexicographically smallest and largest vertex.
///
/// A ghost is named by its real side, which runs against the hull edge.
#[derive(Clone, Copy)]
struct Hull {
    min: Side,
    max: Side,
}

/// A vertex of a hull and the ghost of the hull edge that leaves it.
type End = (u32, Side);

#[derive(Clone, Copy, PartialEq, Eq)]
enum Axis {
    X,
    Y,
}

/// The divide-and-conquer engine, with the memory that it keeps between calls.
#[derive(Default)]
pub(super) struct DivideConquer {
    /// For each vertex the index of its point in the caller's array, in the bits of `index_mask`, below as much of the
    /// point's [Morton key](MortonSquare::key) as there is room for.
    keyed: Vec<u64>,
    index_mask: u64,
    /// The points in the order of the cuts; vertices are positions in it.
    points: Vec<Point>,
    /// The corners of each triangle. While it works, the kernel holds the arrays of the result, and makes it in place.
    corners: Vec<[u32; 3]>,
    /// For each triangle and side the [`Side`] on its other side.
    twins: Vec<[u32; 3]>,
    /// The ghosts of the result.
    ghosts: Vec<Side>,
}

impl Engine for DivideConquer {
    fn triangulate(&mut self, points: &[Point], mesh: &mut Triangulation) {
        assert!(points.len() < 1 << 29, "side handles hold fewer than 2^29 points");
        if points.len() < 2 {
            mesh.set_collinear(points);
            return;
        }
        self.index_mask = (points.len() as u64).next_power_of_two() - 1;
        self.keyed.clear();
        self.keyed.extend(0..points.len() as u64);
        self.points.clear();
        self.points.extend_from_slice(points);
        mesh.clear();
        std::mem::swap(&mut self.corners, &mut mesh.triangles);
        std::mem::swap(&mut self.twins, &mut mesh.neighbours);
        self.corners.reserve(2 * points.len());
        self.twins.reserve(2 * points.len());
        let hull = self.conquer(points, 0, points.len());
        self.finish(hull, mesh);
        std::mem::swap(&mut self.corners, &mut mesh.triangles);
        std::mem::swap(&mut self.twins, &mut mesh.neighbours);
        if mesh.triangles.is_empty() {
            mesh.set_collinear(points);
        }
    }
}

impl DivideConquer {
    /// Triangulates the points `from..to`, two at least: cuts, conquers both parts, merges. They are sorted by key, or
    /// their keys are equal.
    fn conquer(&mut self, points: &[Point], from: usize, to: usize) -> Hull {
        if to - from <= 3 {
            return self.conquer_few(from, to);
        }
        if self.keyed[from] ^ self.keyed[to - 1] <= self.index_mask {
            self.sort(points, from, to);
        }
        // The highest bit in which keys differ says where the smallest cell around the points is halved.
        let bit = (self.keyed[from] ^ self.keyed[to - 1]).ilog2();
        let axis = if bit % 2 == 1 { Axis::X } else { Axis::Y };
        let mut cut = from + self.keyed[from..to].partition_point(|key| key >> bit & 1 == 0);
        // A part has two points at least: a lone one gets the one next to the cut from the other side.
        if cut - from == 1 {
            let next = (cut..to).reduce(|a, b| if self.comes_before(axis, b, a) { b } else { a });
            let next = next.expect("three points are left");
            self.keyed[cut..=next].rotate_right(1);
            self.points[cut..=next].rotate_right(1);
            cut += 1;
        } else if to - cut == 1 {
            let next = (from..cut).reduce(|a, b| if self.comes_before(axis, a, b) { b } else { a });
            let next = next.expect("three points are left");
            self.keyed[next..cut].rotate_left(1);
            self.points[next..cut].rotate_left(1);
            cut -= 1;
        }
        let left = self.conquer(points, from, cut);
        let right = self.conquer(points, cut, to);
        self.merge(left, right, axis)
    }

    /// Sorts the points `from..to` along the Morton curve over a square around them.
    ///
    /// The first key differs from the last one then. As there is room for 35 bits of it, and the square shrinks to
    /// 2⁻¹⁷ at each call for the points of one cell, there are few calls within calls, whatever the distribution.
    fn sort(&mut self, points: &[Point], from: usize, to: usize) {
        let (keyed, ordered) = (&mut self.keyed[from..to], &mut self.points[from..to]);
        let square = MortonSquare::around(Rect::around(ordered.iter().copied()));
        let mask = self.index_mask;
        for (key, p) in keyed.iter_mut().zip(&*ordered) {
            *key = square.key(*p) & !mask | *key & mask;
        }
        keyed.sort_unstable();
        for (p, key) in ordered.iter_mut().zip(keyed) {
            *p = points[(*key & mask) as usize];
        }
    }

    fn comes_before(&self, axis: Axis, a: usize, b: usize) -> bool {
        let (a, b) = (self.points[a], self.points[b]);
        match axis {
            Axis::X => xy_less(a, b),
            Axis::Y => yx_less(a, b),
        }
    }

    /// Two points or three.
    fn conquer_few(&mut self, from: usize, to: usize) -> Hull {
        let mut order = |i: usize, j: usize| {
            if xy_less(self.points[j], self.points[i]) {
                self.points.swap(i, j);
                self.keyed.swap(i, j);
            }
        };
        order(from, from + 1);
        if to - from == 2 {
            return self.edge(from as u32);
        }
        order(from + 1, from + 2);
        order(from, from + 1);
        self.three(from as u32)
    }

    /// Two points, in lexicographic order: an edge with a ghost on either side.
    fn edge(&mut self, a: u32) -> Hull {
        let b = a + 1;
        let ghosts = self.ring(&[(a, b), (b, a)]);
        self.link(Side::new(ghosts, 0), Side::new(ghosts + 1, 0));
        Hull {
            min: Side::new(ghosts, 0),
            max: Side::new(ghosts + 1, 0),
        }
    }

    /// Three points, in lexicographic order: a triangle, or a chain.
    fn three(&mut self, a: u32) -> Hull {
        let (b, c) = (a + 1, a + 2);
        match orient2d(self.point(a), self.point(b), self.point(c)) {
            Orientation::CounterClockwise => self.triangle([a, b, c], 2),
            Orientation::Clockwise => self.triangle([a, c, b], 1),
            Orientation::Collinear => {
                let ghosts = self.ring(&[(a, b), (b, c), (c, b), (b, a)]);
                self.link(Side::new(ghosts, 0), Side::new(ghosts + 3, 0));
                self.link(Side::new(ghosts + 1, 0), Side::new(ghosts + 2, 0));
                Hull {
                    min: Side::new(ghosts, 0),
                    max: Side::new(ghosts + 2, 0),
                }
            }
        }
    }

    /// One triangle with its three ghosts; its first corner is the smallest vertex, corner `max` the largest.
    fn triangle(&mut self, corners: [u32; 3], max: u32) -> Hull {
        let inner = self.new_triangle(corners);
        let [a, b, c] = corners;
        let ghosts = self.ring(&[(a, b), (b, c), (c, a)]);
        for side in 0..3 {
            self.link(Side::new(inner, side), Side::new(ghosts + side, 0));
        }
        Hull {
            min: Side::new(ghosts, 0),
            max: Side::new(ghosts + max, 0),
        }
    }

    /// Makes a ring of ghosts, one for each hull edge, and returns the first; they follow each other.
    #[inline(always)]
    fn ring(&mut self, hull_edges: &[(u32, u32)]) -> u32 {
        let first = self.corners.len() as u32;
        for &(u, v) in hull_edges {
            self.new_triangle([v, u, GHOST]);
        }
        let last = first + hull_edges.len() as u32 - 1;
        for ghost in first..=last {
            let following = if ghost == last { first } else { ghost + 1 };
            self.link(Side::new(ghost, 2), Side::new(following, 1));
        }
        first
    }

    /// Joins two triangulations that a cut across `axis` separates.
    ///
    /// On entry, either hull is a ring of ghosts. On exit, there is one ring around both.
    ///
    /// ```text
    ///      l'───────r'  upper tangent        The base edge l → r rises from the lower tangent to the upper one. At
    ///     /│╲      ╱│╲                       each step one of the hull edges that face the cut, l → l1 or r1 → r, gets
    ///    / l1 ╲  ╱  r1                       a triangle with the base, after those inner triangles that lose their
    ///    ╲ │   ╲╱   │ ╱                      empty circle by the other side's points became ghosts again.
    ///     ╲l────────r╱  lower tangent        (For a cut across Y the picture is turned clockwise.)
    /// ```
    fn merge(&mut self, left: Hull, right: Hull, axis: Axis) -> Hull {
        let ends_left = [left.min, left.max].map(|ghost| (self.dest(ghost), ghost));
        let ends_right = [right.min, right.max].map(|ghost| (self.dest(ghost), ghost));
        let (mut ghost_left, mut ghost_right) = self.lower_tangent(left, right, axis);
        let (mut l, mut r) = (self.dest(ghost_left), self.origin(ghost_right));
        let lowest_left = l;

        let bottom = Side::new(self.new_triangle([r, l, GHOST]), 0);
        let before = self.twin(ghost_left.next());
        let after = self.twin(ghost_right.prev());
        self.link(bottom.next(), before);
        self.link(bottom.prev(), after);

        let mut base = bottom;
        loop {
            let (pl, pr) = (self.point(l), self.point(r));
            let left_valid = self.is_above(pl, pr, self.origin(ghost_left));
            let right_valid = self.is_above(pl, pr, self.dest(ghost_right));
            if left_valid {
                self.expose_left(ghost_left, pl, pr);
            }
            if right_valid {
                self.expose_right(ghost_right, pl, pr);
            }
            let take_right = match (left_valid, right_valid) {
                (false, false) => break,
                (true, true) => {
                    let l1 = self.point(self.origin(ghost_left));
                    let r1 = self.point(self.dest(ghost_right));
                    in_circle(pl, pr, l1, r1)
                }
                (_, right_valid) => right_valid,
            };
            if take_right {
                // The ghost (r, r1, ∞) becomes the triangle (r, r1, l).
                let above = self.hull_prev(ghost_right);
                self.set_apex(ghost_right, l);
                self.link(ghost_right.prev(), base);
                base = ghost_right.next();
                r = self.origin(base);
                ghost_right = above;
            } else {
                // The ghost (l1, l, ∞) becomes the triangle (l1, l, r).
                let above = self.hull_next(ghost_left);
                self.set_apex(ghost_left, r);
                self.link(ghost_left.next(), base);
                base = ghost_left.prev();
                l = self.dest(base);
                ghost_left = above;
            }
        }

        let top = Side::new(self.new_triangle([l, r, GHOST]), 0);
        self.link(top, base);
        self.link(top.next(), ghost_right.prev());
        self.link(top.prev(), ghost_left.next());

        // New hull edges leave the left part at the lower tangent and the right part at the upper one. Every other
        // vertex of the hull keeps the ghost of the edge that leaves it.
        let leaving_left = |(vertex, ghost): End| (vertex, if vertex == lowest_left { bottom } else { ghost });
        let leaving_right = |(vertex, ghost): End| (vertex, if vertex == r { top } else { ghost });
        let [left_min, left_max] = ends_left.map(leaving_left);
        let [right_min, right_max] = ends_right.map(leaving_right);
        let smaller = |a: End, b: End| self.point(a.0).lex_cmp(self.point(b.0)).is_lt();
        Hull {
            min: if smaller(left_min, right_min) {
                left_min.1
            } else {
                right_min.1
            },
            max: if smaller(left_max, right_max) {
                right_max.1
            } else {
                left_max.1
            },
        }
    }

    /// The lower tangent l → r, as the ghosts of the hull edges that leave l and that arrive at r.
    ///
    /// Of several vertices on the tangent line, the ones next to the cut are taken.
    fn lower_tangent(&self, left: Hull, right: Hull, axis: Axis) -> (Side, Side) {
        let (mut leaves_l, mut leaves_r) = match axis {
            Axis::X => (left.max, right.min),
            Axis::Y => (
                self.climb(left.max, yx_less),
                self.climb(right.min, |here, next| yx_less(next, here)),
            ),
        };
        loop {
            let (l, r) = (self.point(self.dest(leaves_l)), self.point(self.dest(leaves_r)));
            let before_l = self.hull_prev(leaves_l);
            if self.is_below(l, r, self.dest(before_l)) {
                leaves_l = before_l;
            } else if self.is_below(l, r, self.origin(leaves_r)) {
                leaves_r = self.hull_next(leaves_r);
            } else {
                return (leaves_l, self.hull_prev(leaves_r));
            }
        }
    }

    /// Goes counter-clockwise along a hull as long as `better(here, next)`.
    fn climb(&self, mut leaves: Side, better: impl Fn(Point, Point) -> bool) -> Side {
        while better(self.point(self.dest(leaves)), self.point(self.origin(leaves))) {
            leaves = self.hull_next(leaves);
        }
        leaves
    }

    /// Makes ghosts of the triangles (l, l1, a) behind the hull edge l → l1 for which the circle through l, r and l1
    /// contains a. The ghost at l stays where it is.
    ///
    /// ```text
    ///      l1                    l1
    ///     ╱ │ ghost             ╱   new ghost
    ///    a  │            →     a
    ///     ╲ │                   ╲   ghost
    ///       l ──── r              l ──── r
    /// ```
    fn expose_left(&mut self, ghost: Side, pl: Point, pr: Point) {
        loop {
            let inner = self.twin(ghost);
            let (l1, a) = (self.origin(ghost), self.origin(inner.prev()));
            if a == GHOST || !in_circle(pl, pr, self.point(l1), self.point(a)) {
                return;
            }
            let (behind_l1_a, behind_a_l) = (self.twin(inner.next()), self.twin(inner.prev()));
            let following = self.twin(ghost.prev());
            self.set_origin(ghost, a);
            self.link(ghost, behind_a_l);
            self.set_corners(inner, [l1, a, GHOST]);
            self.link(inner, behind_l1_a);
            self.link(inner.next(), ghost.prev());
            self.link(inner.prev(), following);
        }
    }

    /// The mirror image of [`expose_left`](Self::expose_left): triangles (r1, r, a) behind the hull edge r1 → r.
    #[inline(always)]
    fn expose_right(&mut self, ghost: Side, pl: Point, pr: Point) {
        loop {
            let inner = self.twin(ghost);
            let (r1, a) = (self.dest(ghost), self.origin(inner.prev()));
            if a == GHOST || !in_circle(pl, pr, self.point(r1), self.point(a)) {
                return;
            }
            let (behind_r_a, behind_a_r1) = (self.twin(inner.next()), self.twin(inner.prev()));
            let preceding = self.twin(ghost.next());
            self.set_origin(ghost.next(), a);
            self.link(ghost, behind_r_a);
            self.set_corners(inner, [a, r1, GHOST]);
            self.link(inner, behind_a_r1);
            self.link(inner.next(), preceding);
            self.link(inner.prev(), ghost.next());
        }
    }

    /// Takes the ghosts out and puts everything into the caller's terms.
    fn finish(&mut self, hull: Hull, mesh: &mut Triangulation) {
        self.ghosts.clear();
        let mut ghost = hull.min;
        loop {
            self.ghosts.push(ghost);
            mesh.hull.push(self.index(self.dest(ghost)));
            ghost = self.hull_next(ghost);
            if ghost == hull.min {
                break;
            }
        }
        let count = self.corners.len() - self.ghosts.len();
        self.move_ghosts_behind(count);
        self.corners.truncate(count);
        self.twins.truncate(count);
        let (keyed, mask) = (&self.keyed, self.index_mask);
        for corner in self.corners.as_flattened_mut() {
            *corner = (keyed[*corner as usize] & mask) as u32;
        }
        for twin in self.twins.as_flattened_mut() {
            let side = Side(*twin);
            *twin = if side == Side::UNSET {
                NONE
            } else {
                3 * side.triangle() as u32 + side.corner() as u32
            };
        }
    }

    /// Moves triangles into the places of ghosts, until the first `count` are no ghosts. The ghosts are lost.
    fn move_ghosts_behind(&mut self, count: usize) {
        let mut behind = count;
        for i in 0..self.ghosts.len() {
            let ghost = self.ghosts[i];
            let inner = self.twin(ghost);
            // A chain has ghosts on both sides; then the other one was here before.
            if inner != Side::UNSET {
                self.twins[inner.triangle()][inner.corner()] = Side::UNSET.0;
            }
            if ghost.triangle() >= count {
                continue;
            }
            while self.corners[behind].contains(&GHOST) {
                behind += 1;
            }
            let place = ghost.triangle();
            self.corners[place] = self.corners[behind];
            self.twins[place] = self.twins[behind];
            for (corner, twin) in (0..).zip(self.twins[place].map(Side)) {
                if twin != Side::UNSET {
                    self.twins[twin.triangle()][twin.corner()] = Side::new(place as u32, corner).0;
                }
            }
            behind += 1;
        }
    }

    /// The caller's index of a vertex.
    fn index(&self, vertex: u32) -> u32 {
        (self.keyed[vertex as usize] & self.index_mask) as u32
    }

    fn point(&self, vertex: u32) -> Point {
        self.points[vertex as usize]
    }

    fn is_above(&self, l: Point, r: Point, vertex: u32) -> bool {
        orient2d(l, r, self.point(vertex)) == Orientation::CounterClockwise
    }

    fn is_below(&self, l: Point, r: Point, vertex: u32) -> bool {
        orient2d(l, r, self.point(vertex)) == Orientation::Clockwise
    }

    fn new_triangle(&mut self, corners: [u32; 3]) -> u32 {
        let number = self.corners.len() as u32;
        self.corners.push(corners);
        self.twins.push([Side::UNSET.0; 3]);
        number
    }

    fn origin(&self, side: Side) -> u32 {
        self.corners[side.triangle()][side.corner()]
    }

    fn dest(&self, side: Side) -> u32 {
        self.origin(side.next())
    }

    fn twin(&self, side: Side) -> Side {
        Side(self.twins[side.triangle()][side.corner()])
    }

    fn link(&mut self, a: Side, b: Side) {
        self.twins[a.triangle()][a.corner()] = b.0;
        self.twins[b.triangle()][b.corner()] = a.0;
    }

    fn set_origin(&mut self, side: Side, vertex: u32) {
        self.corners[side.triangle()][side.corner()] = vertex;
    }

    fn set_apex(&mut self, side: Side, vertex: u32) {
        self.set_origin(side.prev(), vertex);
    }

    /// Sets the corners of a triangle, the first one where `side` starts.
    fn set_corners(&mut self, side: Side, [a, b, c]: [u32; 3]) {
        self.set_origin(side, a);
        self.set_origin(side.next(), b);
        self.set_origin(side.prev(), c);
    }

    /// The ghost of the hull edge after that of `ghost`, counter-clockwise.
    fn hull_next(&self, ghost: Side) -> Side {
        self.twin(ghost.prev()).prev()
    }

    /// The ghost of the hull edge before that of `ghost`.
    fn hull_prev(&self, ghost: Side) -> Side {
        self.twin(ghost.next()).next()
    }
}

/// Whether `a` comes before `b` by x, then by y.
fn xy_less(a: Point, b: Point) -> bool {
    (a.x < b.x) | ((a.x == b.x) & (a.y < b.y))
}

/// Whether `a` comes before `b` by y, then by x.
fn yx_less(a: Point, b: Point) -> bool {
    (a.y < b.y) | ((a.y == b.y) & (a.x < b.x))
}
